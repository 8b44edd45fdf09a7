//! One of several equal shares of an image's work, each rendered by itself.

use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Share `index` of `count`: the tiles whose number, row by row, is `index` - 1 modulo `count`
/// ([`Share::tile_side`]).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Share {
    /// From 1 to `count`.
    pub index: u32,
    /// From 1 to [`Share::MOST`].
    pub count: u32,
}

impl Default for Share {
    fn default() -> Share {
        Share::WHOLE
    }
}

impl Share {
    /// The whole image.
    pub const WHOLE: Share = Share { index: 1, count: 1 };
    /// Most shares of an image.
    pub const MOST: u32 = 65536;
    /// Longest side of a share's tiles, pixels.
    const LARGEST: u32 = 256;
    /// Tiles that each share has at least, where the image has enough pixels: neighbouring pixels take similar
    /// times, and many small pieces spread the slow ones over all shares.
    const TILES: u64 = 16;

    /// True for the whole image.
    pub fn is_whole(self) -> bool {
        self.count == 1
    }

    /// True if both numbers are in their ranges.
    pub fn is_sound(self) -> bool {
        (1..=Share::MOST).contains(&self.count) && (1..=self.count).contains(&self.index)
    }

    /// Side of the square tiles that an image of `region` is cut into for its shares, a power of two, pixels. It follows
    /// from the region and the number of shares alone, so that all devices cut alike.
    pub fn tile_side(self, [x0, y0, x1, y1]: [u32; 4]) -> u32 {
        let tiles = |side: u32| u64::from((x1 - x0).div_ceil(side)) * u64::from((y1 - y0).div_ceil(side));
        let mut side = Share::LARGEST;
        while side > 1 && tiles(side) < Share::TILES * u64::from(self.count) {
            side /= 2;
        }
        side
    }
}

impl fmt::Display for Share {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}/{}", self.index, self.count)
    }
}

impl FromStr for Share {
    type Err = String;

    fn from_str(text: &str) -> Result<Share, String> {
        let numbers = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
        match numbers.map(|(index, count)| Share { index, count }) {
            Some(share) if share.is_sound() => Ok(share),
            _ => Err(format!("write I/N with I from 1 to N and N up to {}, such as 2/8", Share::MOST)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_written_as_they_are_read() {
        for text in ["1/1", "8/8", "3/65536"] {
            assert_eq!(text.parse::<Share>().unwrap().to_string(), text);
        }
        for bad in ["0/8", "9/8", "1/0", "1/65537", "1", "1/", "/2", "-1/2", "1/2/3", ""] {
            assert!(bad.parse::<Share>().is_err(), "{bad}");
        }
    }

    #[test]
    fn every_share_gets_many_tiles() {
        let of = |count| Share { index: 1, count }.tile_side([0, 0, 640, 480]);
        // 3 x 2 tiles of 256, 5 x 4 of 128, 10 x 8 of 64.
        assert_eq!([of(1), of(2), of(5), of(6), of(1000)], [128, 64, 64, 32, 4]);
        assert_eq!(Share { index: 1, count: 9 }.tile_side([5, 5, 7, 7]), 1);
    }
}

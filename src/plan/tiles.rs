//! Rectangles of pixels: how an image is cut.

use crate::settings::Share;

/// A rectangle of pixels, in image coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Tile {
    pub(crate) x: u32,
    pub(crate) y: u32,
    pub(crate) width: u32,
    pub(crate) height: u32,
}

impl Tile {
    pub(crate) fn pixels(&self) -> u32 {
        self.width * self.height
    }

    /// Two halves along the longer side, or nothing for a single pixel.
    pub(crate) fn halves(&self) -> Option<[Tile; 2]> {
        let t = *self;
        if t.pixels() == 1 {
            None
        } else if t.height > 1 {
            let h = t.height / 2;
            Some([Tile { height: h, ..t }, Tile { y: t.y + h, height: t.height - h, ..t }])
        } else {
            let w = t.width / 2;
            Some([Tile { width: w, ..t }, Tile { x: t.x + w, width: t.width - w, ..t }])
        }
    }

    /// Offsets of its pixels, row by row, in an image of `[x0, y0, x1, y1]`.
    pub(crate) fn offsets(self, region: [u32; 4]) -> impl Iterator<Item = usize> {
        self.rows(region).flatten()
    }

    /// Offsets of its rows' pixels in an image of `[x0, y0, x1, y1]`.
    pub(crate) fn rows(self, [x0, y0, x1, _]: [u32; 4]) -> impl Iterator<Item = std::ops::Range<usize>> {
        let stride = (x1 - x0) as usize;
        let (left, top) = ((self.x - x0) as usize, (self.y - y0) as usize);
        let first = move |y| (top + y) * stride + left;
        (0..self.height as usize).map(move |y| first(y)..first(y) + self.width as usize)
    }
}

/// Tiles of at most `pixels` pixels, rows first; the first tile last, so that `pop` takes it first.
pub(crate) fn tiles(region: [u32; 4], pixels: u32) -> Vec<Tile> {
    let [x0, y0, x1, y1] = region;
    let width = (x1 - x0).min(pixels);
    let height = (pixels / width).clamp(1, y1 - y0);
    cut(region, width, height)
}

/// The tiles of `share`, as [`tiles`] has them: of at most `pixels` pixels, each inside one of the squares that the
/// share consists of.
pub(crate) fn tiles_of(share: Share, region: [u32; 4], pixels: u32) -> Vec<Tile> {
    if share.is_whole() {
        return tiles(region, pixels);
    }
    let mut squares = squares_of(share, region);
    squares.reverse();
    let pieces = |t: Tile| tiles([t.x, t.y, t.x + t.width, t.y + t.height], pixels);
    squares.into_iter().flat_map(pieces).collect()
}

/// The squares that `share` of an image consists of, in the order of their numbers.
pub(crate) fn squares_of(share: Share, region: [u32; 4]) -> Vec<Tile> {
    let side = share.tile_side(region);
    let mut all = cut(region, side, side);
    all.reverse();
    all.into_iter().skip(share.index as usize - 1).step_by(share.count as usize).collect()
}

/// Tiles of `width` x `height`, smaller at the right and the bottom; the first tile last.
fn cut([x0, y0, x1, y1]: [u32; 4], width: u32, height: u32) -> Vec<Tile> {
    let mut all = Vec::new();
    for y in (y0..y1).step_by(height as usize) {
        for x in (x0..x1).step_by(width as usize) {
            all.push(Tile { x, y, width: width.min(x1 - x), height: height.min(y1 - y) });
        }
    }
    all.reverse();
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const REGION: [u32; 4] = [3, 5, 40, 31];

    /// How often each pixel of `REGION` is covered.
    fn cover(tiles: &[Tile]) -> Vec<u32> {
        let mut count = vec![0; 37 * 26];
        for tile in tiles {
            let [x0, y0, x1, y1] = REGION;
            assert!(tile.pixels() > 0 && tile.x >= x0 && tile.y >= y0, "{tile:?}");
            assert!(tile.x + tile.width <= x1 && tile.y + tile.height <= y1, "{tile:?}");
            tile.offsets(REGION).for_each(|i| count[i] += 1);
        }
        count
    }

    proptest! {
        #[test]
        fn tiles_cover_the_region_once(pixels in 1u32..1200) {
            let all = tiles(REGION, pixels);
            prop_assert!(all.iter().all(|t| t.pixels() <= pixels));
            prop_assert!(cover(&all).iter().all(|&n| n == 1));
        }

        /// However small the tiles are that a device has room for.
        #[test]
        fn shares_cover_the_region_once(count in 1u32..60, pixels in proptest::collection::vec(1u32..1200, 60)) {
            let of = |index| tiles_of(Share { index, count }, REGION, pixels[index as usize - 1]);
            let all: Vec<Tile> = (1..=count).flat_map(of).collect();
            prop_assert!(cover(&all).iter().all(|&n| n == 1));
        }
    }

    #[test]
    fn a_share_has_the_same_pixels_whatever_its_tiles() {
        for count in [2, 3, 7] {
            let share = Share { index: 2, count };
            let whole = cover(&squares_of(share, REGION));
            assert!([1, 5, 64, 2000].iter().all(|pixels| cover(&tiles_of(share, REGION, *pixels)) == whole));
            let pixels: u32 = whole.iter().sum();
            assert!(pixels.abs_diff(37 * 26 / count) < 37 * 26 / 16, "{pixels} of {count} shares");
        }
    }

    #[test]
    fn halves_are_the_whole() {
        assert_eq!(Tile { x: 3, y: 5, width: 1, height: 1 }.halves(), None);
        for (width, height) in [(2, 1), (1, 2), (7, 3)] {
            let tile = Tile { x: 3, y: 5, width, height };
            let [a, b] = tile.halves().unwrap();
            assert_eq!(a.pixels() + b.pixels(), tile.pixels());
            assert!(cover(&[a, b]) == cover(&[tile]));
        }
    }
}

//! Rectangles of pixels: how an image is cut, and what of it is left to do.

use serde::{Deserialize, Serialize};

/// A rectangle of pixels, in image coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
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

    fn right(&self) -> u32 {
        self.x.saturating_add(self.width)
    }

    fn bottom(&self) -> u32 {
        self.y.saturating_add(self.height)
    }

    /// True if all of it lies in `[x0, y0, x1, y1]` and it is not empty.
    pub(crate) fn is_in(&self, [x0, y0, x1, y1]: [u32; 4]) -> bool {
        let sides = self.width > 0 && self.height > 0;
        sides && self.x >= x0 && self.y >= y0 && self.right() <= x1 && self.bottom() <= y1
    }

    /// Offsets of its pixels, row by row, in an image of `[x0, y0, x1, y1]`.
    pub(crate) fn offsets(self, [x0, y0, x1, _]: [u32; 4]) -> impl Iterator<Item = usize> {
        let stride = (x1 - x0) as usize;
        let (left, top) = ((self.x - x0) as usize, (self.y - y0) as usize);
        let row = move |y| (0..self.width as usize).map(move |x| (top + y) * stride + left + x);
        (0..self.height as usize).flat_map(row)
    }

    /// What of it lies outside `hole`, from the top; at most four pieces.
    fn without(self, hole: &Tile) -> Vec<Tile> {
        let (left, right) = (self.x.max(hole.x), self.right().min(hole.right()));
        let (top, bottom) = (self.y.max(hole.y), self.bottom().min(hole.bottom()));
        if left >= right || top >= bottom {
            return vec![self];
        }
        let piece = |x, y, x1: u32, y1: u32| Tile { x, y, width: x1 - x, height: y1 - y };
        [
            piece(self.x, self.y, self.right(), top),
            piece(self.x, top, left, bottom),
            piece(right, top, self.right(), bottom),
            piece(self.x, bottom, self.right(), self.bottom()),
        ]
        .into_iter()
        .filter(|piece| piece.pixels() > 0)
        .collect()
    }

    /// Both in one, if they make a rectangle.
    fn joined(&self, next: &Tile) -> Option<Tile> {
        let t = *self;
        if (t.y, t.height, t.right()) == (next.y, next.height, next.x) {
            Some(Tile { width: t.width + next.width, ..t })
        } else if (t.x, t.width, t.bottom()) == (next.x, next.width, next.y) {
            Some(Tile { height: t.height + next.height, ..t })
        } else {
            None
        }
    }
}

/// Adds a finished tile. Neighbours are joined: tiles that follow each other in rows stay a few
/// rectangles, however many they were.
pub(crate) fn push(finished: &mut Vec<Tile>, mut tile: Tile) {
    while let Some(joined) = finished.last().and_then(|last| last.joined(&tile)) {
        finished.pop();
        tile = joined;
    }
    finished.push(tile);
}

/// `work` less what is finished.
pub(crate) fn remaining(work: Vec<Tile>, finished: &[Tile]) -> Vec<Tile> {
    // `work` is a stack: its pieces are stacked the other way round too.
    let cut = |work: Vec<Tile>, hole: &Tile| -> Vec<Tile> {
        work.into_iter().flat_map(|tile| tile.without(hole).into_iter().rev()).collect()
    };
    finished.iter().fold(work, cut)
}

/// Tiles of at most `pixels` pixels, rows first; the first tile last, so that `pop` takes it first.
pub(crate) fn tiles(region: [u32; 4], pixels: u32) -> Vec<Tile> {
    let [x0, y0, x1, y1] = region;
    let width = (x1 - x0).min(pixels);
    let height = (pixels / width).clamp(1, y1 - y0);
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
            assert!(tile.is_in(REGION), "{tile:?}");
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

        #[test]
        fn what_is_finished_and_what_remains_make_the_whole(
            first in 1u32..1200, then in 1u32..1200, count in 0usize..1000,
        ) {
            let (mut finished, mut whole) = (Vec::new(), 0);
            for tile in tiles(REGION, first).into_iter().rev().take(count) {
                whole += tile.pixels();
                push(&mut finished, tile);
            }
            prop_assert!(finished.len() <= 3, "{finished:?}");
            prop_assert_eq!(finished.iter().map(Tile::pixels).sum::<u32>(), whole);
            let rest = remaining(tiles(REGION, then), &finished);
            prop_assert!(cover(&[finished, rest].concat()).iter().all(|&n| n == 1));
        }
    }

    #[test]
    fn a_hole_in_the_middle_leaves_four_pieces() {
        let whole = Tile { x: 0, y: 0, width: 5, height: 5 };
        let hole = Tile { x: 1, y: 2, width: 2, height: 1 };
        assert_eq!(whole.without(&hole).len(), 4);
        assert_eq!(whole.without(&whole), []);
        assert_eq!(hole.without(&whole), []);
    }

    #[test]
    fn halves_are_the_whole() {
        assert_eq!(Tile { x: 3, y: 5, width: 1, height: 1 }.halves(), None);
        for (width, height) in [(2, 1), (1, 2), (7, 3)] {
            let tile = Tile { x: 3, y: 5, width, height };
            let [a, b] = tile.halves().unwrap();
            assert_eq!(a.joined(&b), Some(tile));
        }
    }
}

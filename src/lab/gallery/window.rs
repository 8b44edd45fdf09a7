//! Which part of a row's pictures is worth enlarging: where two neighbours differ most.

use crate::image::canvas::Canvas;

/// A rectangle of pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Window {
    pub(super) corner: [u32; 2],
    pub(super) size: [u32; 2],
}

/// Two neighbours of a row, and the window in which they differ most.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Difference {
    /// Index of the right one of the two pictures; the other is left of it.
    pub(super) right: usize,
    pub(super) window: Window,
}

impl Window {
    fn overlaps(&self, other: &Window) -> bool {
        (0..2).all(|axis| {
            let (a, b) = (self.corner[axis], other.corner[axis]);
            a < b + other.size[axis] && b < a + self.size[axis]
        })
    }
}

/// Up to `most` windows of `size` pixels that do not overlap: the first where the last two pictures
/// differ most, the next where the two before them do, and so on. None for pictures of different
/// sizes or pairs that are equal.
pub(super) fn differences(pictures: &[&Canvas], size: [u32; 2], most: usize) -> Vec<Difference> {
    let mut found: Vec<Difference> = Vec::new();
    for right in (1..pictures.len()).rev() {
        let taken: Vec<Window> = found.iter().map(|d| d.window).collect();
        if found.len() < most
            && let Some(window) = strongest(pictures[right - 1], pictures[right], size, &taken)
        {
            found.push(Difference { right, window });
        }
    }
    found
}

/// The window with the greatest sum of differences of sRGB codes, the topmost and leftmost of
/// equals.
fn strongest(a: &Canvas, b: &Canvas, size: [u32; 2], taken: &[Window]) -> Option<Window> {
    let [width, height] = size;
    if (a.width, a.height) != (b.width, b.height) || width > a.width || height > a.height {
        return None;
    }
    // sums[y][x]: of all pixels above and left of (x, y).
    let row = a.width as usize + 1;
    let mut sums = vec![0u64; row * (a.height as usize + 1)];
    for (i, (p, q)) in a.rgb.as_chunks::<3>().0.iter().zip(b.rgb.as_chunks::<3>().0).enumerate() {
        let at = (i / (row - 1) + 1) * row + i % (row - 1) + 1;
        let here: u64 = p.iter().zip(q).map(|(p, q)| u64::from(p.abs_diff(*q))).sum();
        sums[at] = here + sums[at - 1] + sums[at - row] - sums[at - row - 1];
    }
    let sum = |[x, y]: [u32; 2]| {
        let at = |x: u32, y: u32| sums[y as usize * row + x as usize];
        at(x + width, y + height) + at(x, y) - at(x + width, y) - at(x, y + height)
    };
    let mut best: Option<(u64, Window)> = None;
    for corner in (0..=a.height - height).flat_map(|y| (0..=a.width - width).map(move |x| [x, y])) {
        let (total, window) = (sum(corner), Window { corner, size });
        if total > best.map_or(0, |(most, _)| most) && !taken.iter().any(|t| t.overlaps(&window)) {
            best = Some((total, window));
        }
    }
    best.map(|(_, window)| window)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A black picture with a grey square of 4 pixels a side.
    fn with_square(corner: [u32; 2], grey: u8) -> Canvas {
        let mut canvas = Canvas::new(40, 30, [0; 3]);
        canvas.fill(corner, [4, 4], [grey; 3]);
        canvas
    }

    #[test]
    fn the_window_holds_what_differs() {
        // From the third to the fourth picture a faint square appears, from the second to the third
        // a bright one goes: each pair has a window of its own.
        let pictures = [
            with_square([2, 3], 255),
            with_square([2, 3], 255),
            with_square([9, 9], 0),
            with_square([30, 20], 9),
        ];
        let all: Vec<&Canvas> = pictures.iter().collect();
        let found = differences(&all, [4, 4], 2);
        let want = |right, corner| Difference { right, window: Window { corner, size: [4, 4] } };
        assert_eq!(found, [want(3, [30, 20]), want(2, [2, 3])]);
        // A larger window holds the square, whatever else it holds.
        let [Difference { window: Window { corner: [x, y], .. }, .. }] = differences(&all, [10, 8], 1)[..]
        else {
            panic!("one window expected")
        };
        assert!((24..=30).contains(&x) && (16..=20).contains(&y), "{x} {y}");
    }

    #[test]
    fn windows_do_not_overlap() {
        let pictures = [with_square([5, 5], 0), with_square([5, 5], 200), with_square([5, 5], 100)];
        let found = differences(&pictures.iter().collect::<Vec<_>>(), [3, 3], 2);
        let [a, b] = found[..] else { panic!("{found:?}") };
        assert!(a.window.corner == [5, 5] && !a.window.overlaps(&b.window), "{a:?} {b:?}");
    }

    #[test]
    fn equal_or_unlike_pictures_have_no_window() {
        let (one, other) = (with_square([5, 5], 200), Canvas::new(20, 15, [9; 3]));
        assert_eq!(differences(&[&one, &one], [4, 4], 2), []);
        assert_eq!(differences(&[&one, &other], [4, 4], 2), []);
        assert_eq!(differences(&[&other, &Canvas::new(20, 15, [0; 3])], [4, 16], 2), []);
        assert_eq!(differences(&[&one], [4, 4], 2), []);
        assert_eq!(differences(&[], [4, 4], 2), []);
    }
}

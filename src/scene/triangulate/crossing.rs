//! Sides of a border that cross.

use super::Point;
use super::box_tree::{BoxTree, Rectangle};
use robust::orient2d;

/// The first two sides, called by the corners they start at, that cross at a point inside both.
pub(super) fn first(border: &[Point]) -> Option<(usize, usize)> {
    let n = border.len();
    let side = |i: usize| (border[i], border[(i + 1) % n]);
    let bounds = |i: usize| -> Rectangle {
        let (a, b) = side(i);
        [a.x.min(b.x), a.y.min(b.y), a.x.max(b.x), a.y.max(b.y)]
    };
    let tree = BoxTree::new(n, bounds);
    (0..n).find_map(|i| {
        let (a, b) = side(i);
        let other = tree.find(&bounds(i), i + 1, |j| {
            let (c, d) = side(j);
            are_apart(orient2d(a, b, c), orient2d(a, b, d)) && are_apart(orient2d(c, d, a), orient2d(c, d, b))
        });
        Some((i, other?))
    })
}

/// True for strictly opposite signs.
fn are_apart(a: f64, b: f64) -> bool {
    (a > 0.0 && b < 0.0) || (a < 0.0 && b > 0.0)
}

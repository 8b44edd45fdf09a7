//! Cuts faces and polygons with any number of corners into triangles.
//!
//! A border whose fan from the first corner covers it once keeps that fan: every convex one, and concave ones of which the
//! first corner sees all. Others are cut by ear clipping (Meisters, "Polygons have ears", 1975) with exact orientation tests
//! (Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates", 1997). An ear is cut only
//! where no other corner touches it, so that a corner within a straight side stays a corner: neighbours meet the face along
//! the same edges. A border may touch itself, and may go to a hole and back along one line. It may not cross itself.
//!
//! Corners in space are projected along the axis that is nearest to their normal. The coordinates that are left are the
//! given ones, so that nothing is rounded.

mod box_tree;
mod crossing;
mod ears;

use glam::DVec3;
use robust::{Coord, orient2d};

/// How far from a straight line, as a sine, corners count as in it where there is a choice: coordinates with six written
/// digits are off by up to 5e-6, at either end of a side, on two sides. Triangles flatter than that may have no area in single
/// precision, so that they are avoided where the border allows.
const NEARLY_FLAT: f64 = 2e-5;

/// A corner in the plane.
type Point = Coord<f64>;

/// How a border is cut.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Cut {
    /// (0, i, i + 1) for each i from 1 to n - 2.
    Fan,
    /// Corner numbers of each triangle, in the border's sense of rotation; at most n - 2 triangles, fewer where corners repeat.
    Triangles(Vec<[u32; 3]>),
}

/// Why a border cannot be cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Fault {
    /// All corners are in one line, or the areas on both sides are equal.
    NoArea,
    /// The sides that start at these corners cross each other.
    Crosses(usize, usize),
    /// The border overlaps itself near this corner, though no two sides cross at a point inside both.
    Overlaps(usize),
}

/// Cuts the border with these `corners`, three or more.
pub(super) fn cut(corners: &[DVec3]) -> Result<Cut, Fault> {
    if corners.len() <= 3 {
        return Ok(Cut::Fan);
    }
    let border = flattened(corners).ok_or(Fault::NoArea)?;
    if is_fan(&border) {
        return Ok(Cut::Fan);
    }
    if let Some((a, b)) = crossing::first(&border) {
        return Err(Fault::Crosses(a, b));
    }
    ears::clip(&border).map(Cut::Triangles).map_err(Fault::Overlaps)
}

/// Twice the area of a border in space, as a vector: the sum of Newell. Corners relative to the first, so that a place far
/// away costs no digits.
pub(super) fn area(corners: &[DVec3]) -> DVec3 {
    let from = |i: usize| corners[i] - corners[0];
    (1..corners.len() - 1).map(|i| from(i).cross(from(i + 1))).sum()
}

/// The corners in the plane, counter-clockwise; `None` if they have no area.
fn flattened(corners: &[DVec3]) -> Option<Vec<Point>> {
    let normal = area(corners);
    let size = normal.abs();
    let largest = size.max_element();
    if largest.is_nan() || largest <= 0.0 {
        return None;
    }
    let axis = (0..3).find(|i| size[*i] == largest)?;
    // The two other axes, in an order that makes the border counter-clockwise.
    let (x, y) = match (axis, normal[axis] > 0.0) {
        (0, true) => (1, 2),
        (0, false) => (2, 1),
        (1, true) => (2, 0),
        (1, false) => (0, 2),
        (_, true) => (0, 1),
        (_, false) => (1, 0),
    };
    Some(corners.iter().map(|c| Coord { x: c[x], y: c[y] }).collect())
}

fn squared(a: Point, b: Point) -> f64 {
    let (x, y) = (b.x - a.x, b.y - a.y);
    x * x + y * y
}

/// True for a triangle of double area `area` that is flat up to [`NEARLY_FLAT`].
fn is_sliver(area: f64, a: Point, b: Point, c: Point) -> bool {
    area <= NEARLY_FLAT * squared(a, b).max(squared(b, c)).max(squared(c, a))
}

/// True if the fan from the first corner covers the border's inside once: the corners turn around the first one in one sense,
/// by less than a full turn. Where a triangle of the fan is nearly flat, true only if no corner is nearly straight.
fn is_fan(border: &[Point]) -> bool {
    let hub = border[0];
    let mut rim = border[1..].iter().copied().filter(|p| *p != hub);
    let Some(first) = rim.next() else { return false };
    let (mut last, mut beyond_half, mut slivers) = (first, false, false);
    for next in rim {
        if next == last {
            continue;
        }
        let area = orient2d(hub, last, next);
        if area <= 0.0 {
            return false;
        }
        slivers |= is_sliver(area, hub, last, next);
        let side = orient2d(hub, first, next);
        if beyond_half && side >= 0.0 {
            return false;
        }
        beyond_half |= side <= 0.0;
        last = next;
    }
    last != first && (!slivers || is_strictly_convex(border))
}

/// True if every corner turns left by more than [`NEARLY_FLAT`].
fn is_strictly_convex(border: &[Point]) -> bool {
    let mut corners = border.to_vec();
    corners.dedup();
    let n = corners.len();
    (0..n).all(|i| {
        let (a, b, c) = (corners[i], corners[(i + 1) % n], corners[(i + 2) % n]);
        b == c || orient2d(a, b, c) > NEARLY_FLAT * (squared(a, b) * squared(b, c)).sqrt()
    })
}

#[cfg(test)]
mod tests;

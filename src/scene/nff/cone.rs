//! Cones and cylinders of NFF as triangles.

use super::Corner;
use glam::DVec3;
use std::f64::consts::TAU;

/// Flat sides around a cone. The middle of a side lies 1 - cos(pi / 72) = 0.00095 of the radius inside the surface.
const SIDES: usize = 72;

/// What is said of them.
pub(super) fn note() -> String {
    format!("cones and cylinders are drawn with {SIDES} sides, within a thousandth of their radius")
}

/// The open surface between two circles, centre and radius each, with normals; one of the radii may be 0. None if it
/// has no area.
pub(super) fn triangles(base: (DVec3, f64), apex: (DVec3, f64)) -> Option<Vec<[Corner; 3]>> {
    let axis = apex.0 - base.0;
    let length = axis.length();
    if base.1 + apex.1 <= 0.0 || (length == 0.0 && base.1 == apex.1) {
        return None;
    }
    // Two coinciding centres make a flat ring, whose plane NFF leaves open.
    let along = if length > 0.0 { axis / length } else { DVec3::Z };
    let (right, up) = along.any_orthonormal_pair();
    let around = |i: usize| {
        let (sine, cosine) = (TAU * (i % SIDES) as f64 / SIDES as f64).sin_cos();
        right * cosine + up * sine
    };
    // A normal leans against the slope: the radius shrinks by `base.1 - apex.1` over `length`.
    let normal = |direction: DVec3| (direction * length + along * (base.1 - apex.1)).normalize();
    let mut triangles = Vec::with_capacity(2 * SIDES);
    for i in 0..SIDES {
        let (here, next) = (around(i), around(i + 1));
        let corner = |(center, radius): (DVec3, f64), direction: DVec3| {
            (center + direction * radius, Some(normal(direction)))
        };
        let [a, b] = [corner(base, here), corner(base, next)];
        let [c, d] = [corner(apex, next), corner(apex, here)];
        if base.1 > 0.0 {
            triangles.push([a, b, if apex.1 > 0.0 { c } else { tip(apex.0, normal(here + next)) }]);
        }
        if apex.1 > 0.0 {
            triangles.push([if base.1 > 0.0 { a } else { tip(base.0, normal(here + next)) }, c, d]);
        }
    }
    Some(triangles)
}

/// The point of a cone has a normal in each triangle of its own.
fn tip(point: DVec3, normal: DVec3) -> Corner {
    (point, Some(normal))
}

//! Twin of `glsl/lib/surface.glsl`.

use super::super::real::{Real, Real3, U, real};
use super::super::structs::{CornerNormals, Sphere, Triangle, TriangleInfo, WideSphere};
use super::numeric::{dot3, max_component, safe_normalize};

/// Position, normals and spawn offset of a hit.
#[derive(Debug, Clone, Copy)]
pub struct Point {
    /// Local frame.
    pub position: Real3,
    /// Unit, as stored.
    pub geometric: Real3,
    /// Unit shading normal.
    pub normal: Real3,
    /// Spawn offset along `geometric`.
    pub offset: Real3,
}

/// The point with weights u of b and v of c.
pub fn triangle_point(t: &Triangle, info: &TriangleInfo, u: Real, v: Real) -> Point {
    let a = Real3::from(t.a);
    let (e1, e2) = (Real3::from(t.b) - a, Real3::from(t.c) - a);
    let geometric = Real3::from(info.geometric);
    let (m1, m2) = (max_component(e1), max_component(e2));
    let extent = 2.0 * if m1 > m2 { m1 } else { m2 };
    let n = geometric.abs();
    let length = (4.0 * U) * dot3(n, a.abs()) + (12.0 * U) * extent * ((n.x + n.y) + n.z);
    Point {
        position: a + (u * e1 + v * e2),
        geometric,
        normal: info.normal.into(),
        offset: length * geometric,
    }
}

/// Interpolated normal, on the geometric side; `flat_normal` where the corners' cancel.
pub fn smooth_normal(c: &CornerNormals, flat_normal: Real3, geometric: Real3, u: Real, v: Real) -> Real3 {
    let (a, b, c) = (Real3::from(c.a), Real3::from(c.b), Real3::from(c.c));
    if max_component(a) == 0.0 {
        return flat_normal;
    }
    let n = safe_normalize((1.0 - u - v) * a + (u * b + v * c));
    let side = dot3(n, geometric);
    if side == 0.0 {
        return flat_normal;
    }
    if side < 0.0 { -n } else { n }
}

/// The point of a sphere in double length at distance t.
pub fn wide_sphere_point(s: &WideSphere, o: Real3, d: Real3, t: Real) -> Point {
    let at = o + t * d;
    let (point, normal) = (Real3::from(s.point), Real3::from(s.normal));
    let (position, geometric) = if s.radius > 1.0 {
        (at, safe_normalize(normal + (at - point) / s.radius))
    } else {
        let geometric = safe_normalize(((o - point) + t * d) + s.radius * normal);
        (point + s.radius * (geometric - normal), geometric)
    };
    let size = (max_component(o) + t * max_component(d)) + max_component(position);
    Point { position, geometric, normal: geometric, offset: (16.0 * U) * size * geometric }
}

/// The point of a sphere at distance t.
pub fn sphere_point(s: &Sphere, o: Real3, d: Real3, t: Real) -> Point {
    let center = Real3::from(s.center);
    let geometric = safe_normalize((o - center) + t * d);
    Point {
        position: center + s.radius * geometric,
        geometric,
        normal: geometric,
        offset: (8.0 * U) * (dot3(geometric.abs(), center.abs()) + s.radius) * geometric,
    }
}

fn nudge(x: Real, by: Real) -> Real {
    let step = (2.0 * U) * x.abs();
    if by > 0.0 {
        x + step
    } else if by < 0.0 {
        x - step
    } else {
        x
    }
}

/// Origin of a ray that leaves the surface in unit `direction`; `fixed`: `shift` along it.
pub fn spawn_origin(position: Real3, offset: Real3, direction: Real3, fixed: bool, shift: f32) -> Real3 {
    if fixed {
        return position + real(shift) * direction;
    }
    let o = if dot3(direction, offset) < 0.0 { -offset } else { offset };
    let p = position + o;
    Real3::new(nudge(p.x, o.x), nudge(p.y, o.y), nudge(p.z, o.z))
}

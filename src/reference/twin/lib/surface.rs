//! Twin of `glsl/lib/optics/surface.glsl`.

use super::super::real::{Real, Real3, U, real};
use super::super::structs::{CornerNormals, ExtendedSphere, Sphere, Triangle};
use super::numeric::{cross3, dot3, max_component, safe_normalize};
use crate::kernel::abi::{INNER_AB, INNER_CA};

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

fn inset_share(by: Real, base: Real3, area: Real) -> Real {
    let share = by * dot3(base, base).sqrt() / area;
    if share < 0.125 { share } else { 0.125 }
}

fn inset(e1: Real3, e2: Real3, by: Real, inner_edges: u32, (mut u, mut v): (Real, Real)) -> (Real, Real) {
    let n = cross3(e1, e2);
    let area = dot3(n, n).sqrt();
    let least_u = if inner_edges & INNER_CA != 0 { 0.0 } else { inset_share(by, e2, area) };
    let least_v = if inner_edges & INNER_AB != 0 { 0.0 } else { inset_share(by, e1, area) };
    let least_w = inset_share(by, e2 - e1, area);
    u = if u > least_u { u } else { least_u };
    v = if v > least_v { v } else { least_v };
    let lack = least_w - (1.0 - u - v);
    if lack > 0.0 {
        if u > v {
            u -= lack;
        } else {
            v -= lack;
        }
    }
    (u, v)
}

/// The point with weights u of b and v of c. `robust`: kept off the edges.
pub fn triangle_point(t: &Triangle, normal: Real3, u: Real, v: Real, robust: bool) -> Point {
    let a = Real3::from(t.a);
    let (e1, e2) = (Real3::from(t.b) - a, Real3::from(t.c) - a);
    let geometric = Real3::new(t.normal_x, t.normal_y, t.normal_z);
    let (m1, m2, m3) = (max_component(e1), max_component(e2), max_component(e2 - e1));
    let extent = if m1 > m2 { m1 } else { m2 };
    let extent = if m3 > extent { m3 } else { extent };
    let (n, at) = (geometric.abs(), a.abs());
    let by = (16.0 * U) * ((at.x + at.y) + at.z) + (96.0 * U) * extent;
    let (u, v) = if robust { inset(e1, e2, by, t.inner_edges, (u, v)) } else { (u, v) };
    let length = (4.0 * U) * dot3(n, at) + (12.0 * U) * extent * ((n.x + n.y) + n.z);
    Point { position: a + (u * e1 + v * e2), geometric, normal, offset: length * geometric }
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
pub fn wide_sphere_point(s: &ExtendedSphere, o: Real3, d: Real3, t: Real) -> Point {
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
        offset: (16.0 * U) * (dot3(geometric.abs(), center.abs()) + s.radius) * geometric,
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

//! Twin of `glsl/lib/shape/box.glsl`.

use super::super::real::{Real, Real3, U};
use super::super::structs::{Sphere, Triangle};

/// Growth of far distances.
pub const SLAB_GROW: Real = 1.0 + 16.0 * U;
/// f32's pad at both precisions, 2^-19.
const PAD: Real = 1.907_348_632_812_5e-6;

fn reciprocal(d: Real) -> Real {
    let least: Real = 8.271_806_125_530_277e-25;
    let m = d.abs();
    let m = if m > least { m } else { least };
    1.0 / if d.is_sign_negative() { -m } else { m }
}

/// 1/d with |d| >= 2^-80 per component, sign kept.
pub fn safe_reciprocal(d: Real3) -> Real3 {
    Real3::new(reciprocal(d.x), reciprocal(d.y), reciprocal(d.z))
}

/// Where the ray is within the box: near, at least 0, and far. Empty if near > far.
pub fn box_interval(lo: Real3, hi: Real3, o: Real3, inv: Real3) -> (Real, Real) {
    let (x0, x1) = ((lo.x - o.x) * inv.x, (hi.x - o.x) * inv.x);
    let (y0, y1) = ((lo.y - o.y) * inv.y, (hi.y - o.y) * inv.y);
    let (z0, z1) = ((lo.z - o.z) * inv.z, (hi.z - o.z) * inv.z);
    let (mut near, mut far) = if inv.x >= 0.0 { (x0, x1) } else { (x1, x0) };
    let (yn, yf) = if inv.y >= 0.0 { (y0, y1) } else { (y1, y0) };
    let (zn, zf) = if inv.z >= 0.0 { (z0, z1) } else { (z1, z0) };
    near = if yn > near { yn } else { near };
    near = if zn > near { zn } else { near };
    far = if yf < far { yf } else { far };
    far = if zf < far { zf } else { far };
    near = if near > 0.0 { near } else { 0.0 };
    (near, far * SLAB_GROW)
}

/// Entry distance, or a negative number if the ray misses the box within (0, limit].
pub fn enter_box(lo: Real3, hi: Real3, o: Real3, inv: Real3, limit: Real) -> Real {
    let (near, far) = box_interval(lo, hi, o, inv);
    if near <= far && near <= limit * SLAB_GROW { near } else { -1.0 }
}

fn pad_down(x: Real) -> Real {
    x - PAD * if x.abs() > 1.0 { x.abs() } else { 1.0 }
}

fn pad_up(x: Real) -> Real {
    x + PAD * if x.abs() > 1.0 { x.abs() } else { 1.0 }
}

fn least(a: Real, b: Real, c: Real) -> Real {
    let m = if a < b { a } else { b };
    if m < c { m } else { c }
}

fn greatest(a: Real, b: Real, c: Real) -> Real {
    let m = if a > b { a } else { b };
    if m > c { m } else { c }
}

/// The triangle's own box.
pub fn triangle_box(t: &Triangle) -> (Real3, Real3) {
    let lo = |i: usize| pad_down(least(t.a[i], t.b[i], t.c[i]));
    let hi = |i: usize| pad_up(greatest(t.a[i], t.b[i], t.c[i]));
    (Real3::new(lo(0), lo(1), lo(2)), Real3::new(hi(0), hi(1), hi(2)))
}

/// The sphere's own box.
pub fn sphere_box(s: &Sphere) -> (Real3, Real3) {
    let lo = |i: usize| pad_down(s.center[i] - s.radius);
    let hi = |i: usize| pad_up(s.center[i] + s.radius);
    (Real3::new(lo(0), lo(1), lo(2)), Real3::new(hi(0), hi(1), hi(2)))
}

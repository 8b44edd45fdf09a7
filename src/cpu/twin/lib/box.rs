//! Twin of `glsl/lib/box.glsl`.

use super::real::{Real, Real3, U};

/// Growth of far distances: 1 + 2^-20.
pub const SLAB_GROW: Real = 1.0 + 16.0 * U;

/// 1/d with |d| >= 2^-60, sign kept.
pub fn safe_reciprocal(d: Real) -> Real {
    let least: Real = 8.673_617_379_884_035_5e-19;
    let m = d.abs();
    let m = if m > least { m } else { least };
    1.0 / m.copysign(d)
}

/// Entry distance, or a negative number if the ray misses the box within (0, limit].
pub fn enter_box(lo: Real3, hi: Real3, o: Real3, inv: Real3, limit: Real) -> Real {
    let (x0, x1) = ((lo.x - o.x) * inv.x, (hi.x - o.x) * inv.x);
    let (y0, y1) = ((lo.y - o.y) * inv.y, (hi.y - o.y) * inv.y);
    let (z0, z1) = ((lo.z - o.z) * inv.z, (hi.z - o.z) * inv.z);
    let (mut tn, mut tf) = if inv.x >= 0.0 { (x0, x1) } else { (x1, x0) };
    let (yn, yf) = if inv.y >= 0.0 { (y0, y1) } else { (y1, y0) };
    let (zn, zf) = if inv.z >= 0.0 { (z0, z1) } else { (z1, z0) };
    tn = if yn > tn { yn } else { tn };
    tn = if zn > tn { zn } else { tn };
    tf = if yf < tf { yf } else { tf };
    tf = if zf < tf { zf } else { tf };
    tn = if tn > 0.0 { tn } else { 0.0 };
    if tn <= tf * SLAB_GROW && tn <= limit * SLAB_GROW { tn } else { -1.0 }
}

//! Twin of `glsl/lib/base/numeric.glsl`. No `dot()`, `normalize()` of glam: the order of operations is
//! the kernel's.

use super::super::real::{Real, Real3, SPLIT, Vec3};

/// Scalar product, summed from the left.
pub fn dot3(a: Real3, b: Real3) -> Real {
    (a.x * b.x + a.y * b.y) + a.z * b.z
}

/// Vector product.
pub fn cross3(a: Real3, b: Real3) -> Real3 {
    Real3::new(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)
}

/// Largest absolute component.
pub fn max_component(v: Real3) -> Real {
    let (x, y, z) = (v.x.abs(), v.y.abs(), v.z.abs());
    let m = if x > y { x } else { y };
    if m > z { m } else { z }
}

/// Unit vector along v, or zero for zero.
pub fn safe_normalize(v: Real3) -> Real3 {
    let m = max_component(v);
    // Not `m <= 0`: NaN gives zero as well.
    if !(m > 0.0) {
        return Real3::ZERO;
    }
    let s = v / m;
    s / dot3(s, s).sqrt()
}

/// a b - p for p = fl(a b), exactly.
pub fn product_error(a: Real, b: Real, p: Real) -> Real {
    let (ca, cb) = (SPLIT * a, SPLIT * b);
    let (ah, bh) = (ca - (ca - a), cb - (cb - b));
    let (al, bl) = (a - ah, b - bh);
    ((ah * bh - p) + ah * bl + al * bh) + al * bl
}

/// One step of Neumaier's compensated sum.
pub fn neumaier(sum: &mut Vec3, compensation: &mut Vec3, x: Vec3) {
    let t = *sum + x;
    for i in 0..3 {
        compensation[i] +=
            if sum[i].abs() >= x[i].abs() { (sum[i] - t[i]) + x[i] } else { (x[i] - t[i]) + sum[i] };
    }
    *sum = t + *compensation;
    *compensation -= *sum - t;
}

//! Twin of `glsl/lib/shape/double_length.glsl`.

use super::super::real::{Real, Real3};
use super::numeric::product_error;

/// An unevaluated sum of two numbers.
#[derive(Debug, Clone, Copy)]
pub struct Wide {
    /// The rounded sum.
    pub hi: Real,
    /// What rounding took from it.
    pub lo: Real,
}

/// Three of them.
#[derive(Debug, Clone, Copy)]
pub struct Wide3 {
    x: Wide,
    y: Wide,
    z: Wide,
}

fn two_sum(a: Real, b: Real) -> Wide {
    let s = a + b;
    let bb = s - a;
    Wide { hi: s, lo: (a - (s - bb)) + (b - bb) }
}

fn quick_two_sum(a: Real, b: Real) -> Wide {
    let s = a + b;
    Wide { hi: s, lo: b - (s - a) }
}

/// a + b.
pub fn wide_add(a: Wide, b: Wide) -> Wide {
    let (s, t) = (two_sum(a.hi, b.hi), two_sum(a.lo, b.lo));
    let s = quick_two_sum(s.hi, s.lo + t.hi);
    quick_two_sum(s.hi, s.lo + t.lo)
}

/// -a.
pub fn wide_negative(a: Wide) -> Wide {
    Wide { hi: -a.hi, lo: -a.lo }
}

/// a b.
pub fn wide_mul(a: Wide, b: Wide) -> Wide {
    let p = a.hi * b.hi;
    quick_two_sum(p, product_error(a.hi, b.hi, p) + (a.hi * b.lo + a.lo * b.hi))
}

/// a / b.
pub fn wide_div(a: Wide, b: Wide) -> Wide {
    let q = a.hi / b.hi;
    let r = wide_add(a, wide_negative(wide_mul(b, Wide { hi: q, lo: 0.0 })));
    quick_two_sum(q, (r.hi + r.lo) / b.hi)
}

/// Square root of a > 0.
pub fn wide_sqrt(a: Wide) -> Wide {
    let s = a.hi.sqrt();
    // Not `s <= 0`: NaN gives zero as well.
    if !(s > 0.0) {
        return Wide { hi: 0.0, lo: 0.0 };
    }
    let p = s * s;
    let r = wide_add(a, Wide { hi: -p, lo: -product_error(s, s, p) });
    quick_two_sum(s, (r.hi + r.lo) / (2.0 * s))
}

/// From the two parts of three numbers.
pub fn wide3(hi: Real3, lo: Real3) -> Wide3 {
    let part = |i: usize| Wide { hi: hi[i], lo: lo[i] };
    Wide3 { x: part(0), y: part(1), z: part(2) }
}

/// a + b.
pub fn wide_add3(a: Wide3, b: Wide3) -> Wide3 {
    Wide3 { x: wide_add(a.x, b.x), y: wide_add(a.y, b.y), z: wide_add(a.z, b.z) }
}

/// s v.
pub fn wide_scale(s: Wide, v: Wide3) -> Wide3 {
    Wide3 { x: wide_mul(s, v.x), y: wide_mul(s, v.y), z: wide_mul(s, v.z) }
}

/// Scalar product.
pub fn wide_dot(a: Wide3, b: Wide3) -> Wide {
    wide_add(wide_add(wide_mul(a.x, b.x), wide_mul(a.y, b.y)), wide_mul(a.z, b.z))
}

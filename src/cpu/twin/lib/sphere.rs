//! Twin of `glsl/lib/sphere.glsl`.

use super::numeric::dot3;
use super::real::{Real, Real3};
use crate::abi::Sphere;

/// Whether the ray meets the sphere at 0 < t, and the nearest such t. `own`: it starts on the sphere.
pub fn hit_sphere(s: &Sphere, o: Real3, d: Real3, own: bool) -> (bool, Real) {
    let f = o - Real3::from(s.center);
    let a = dot3(d, d);
    let b = -dot3(f, d);
    if own {
        return (b > 0.0, 2.0 * b / a);
    }
    let p = f + (b / a) * d;
    let discriminant = s.radius * s.radius - dot3(p, p);
    let root = (a * if discriminant > 0.0 { discriminant } else { 0.0 }).sqrt();
    let q = b + if b < 0.0 { -root } else { root };
    let length_f = dot3(f, f).sqrt();
    let c = (length_f - s.radius) * (length_f + s.radius);
    let (t0, t1) = (c / q, q / a);
    let (near, far) = (if t0 < t1 { t0 } else { t1 }, if t0 < t1 { t1 } else { t0 });
    let t = if near > 0.0 { near } else { far };
    (discriminant >= 0.0 && q != 0.0 && t > 0.0, t)
}

//! Twin of `glsl/lib/shape/sphere.glsl`.

use super::super::real::{Real, Real3, U};
use super::super::structs::{ExtendedSphere, Sphere};
use super::double_length::{
    Wide, wide_add, wide_add3, wide_div, wide_dot, wide_mul, wide_negative, wide_scale, wide_sqrt, wide3,
};
use super::numeric::{dot3, max_component};

fn nearest_root(t0: Real, t1: Real) -> Real {
    let (near, far) = (if t0 < t1 { t0 } else { t1 }, if t0 < t1 { t1 } else { t0 });
    if near > 0.0 { near } else { far }
}

/// Where a ray that starts on the sphere goes.
#[derive(PartialEq)]
enum Course {
    Outward,
    Inward,
    Grazing,
}

fn own_course(b: Real, o: Real3, d: Real3, radius: Real) -> Course {
    let noise = (32.0 * U) * (max_component(o) + radius) * max_component(d);
    if b > noise {
        Course::Inward
    } else if b < -noise {
        Course::Outward
    } else {
        Course::Grazing
    }
}

/// Whether the ray meets the sphere at 0 < t, and the nearest such t. `own`: it starts on the sphere.
pub fn hit_sphere(s: &Sphere, o: Real3, d: Real3, own: bool) -> (bool, Real) {
    let f = o - Real3::from(s.center);
    let a = dot3(d, d);
    let b = -dot3(f, d);
    let course = if own { own_course(b, o, d, s.radius) } else { Course::Grazing };
    if course != Course::Grazing {
        return (course == Course::Inward, 2.0 * b / a);
    }
    let p = f + (b / a) * d;
    let discriminant = s.radius * s.radius - dot3(p, p);
    let root = (a * if discriminant > 0.0 { discriminant } else { 0.0 }).sqrt();
    let q = b + if b < 0.0 { -root } else { root };
    let length_f = dot3(f, f).sqrt();
    let c = (length_f - s.radius) * (length_f + s.radius);
    if own && !(c < 0.0) {
        return (false, 0.0);
    }
    let t = nearest_root(c / q, q / a);
    (discriminant >= 0.0 && q != 0.0 && t > 0.0, t)
}

/// The same for a sphere in double length.
pub fn hit_extended_sphere(s: &ExtendedSphere, o: Real3, d: Real3, own: bool) -> (bool, Real) {
    let n = wide3(s.normal.into(), s.normal_low.into());
    let r = Wide { hi: s.radius, lo: s.radius_low };
    let to = wide_add3(wide3(o, Real3::ZERO), wide3(-Real3::from(s.point), -Real3::from(s.point_low)));
    let f = wide_add3(to, wide_scale(r, n));
    let dir = wide3(d, Real3::ZERO);
    let a = wide_dot(dir, dir);
    let b = wide_negative(wide_dot(f, dir));
    let near = if s.radius < 1.0 { s.radius } else { 1.0 };
    let course = if own { own_course(b.hi, o, d, near) } else { Course::Grazing };
    if course != Course::Grazing {
        return (course == Course::Inward, 2.0 * b.hi / a.hi);
    }
    let height = wide_mul(r, wide_dot(n, to));
    let c = wide_add(wide_dot(to, to), Wide { hi: 2.0 * height.hi, lo: 2.0 * height.lo });
    if own && !(c.hi < 0.0) {
        return (false, 0.0);
    }
    let discriminant = if s.radius > 1.0 {
        wide_add(wide_mul(b, b), wide_negative(wide_mul(a, c)))
    } else {
        let p = wide_add3(f, wide_scale(wide_div(b, a), dir));
        wide_mul(a, wide_add(wide_mul(r, r), wide_negative(wide_dot(p, p))))
    };
    // Not `< 0`: NaN misses.
    if !(discriminant.hi >= 0.0) {
        return (false, 0.0);
    }
    let root = wide_sqrt(discriminant);
    let q = wide_add(b, if b.hi < 0.0 { wide_negative(root) } else { root });
    let t = nearest_root(wide_div(c, q).hi, wide_div(q, a).hi);
    (q.hi != 0.0 && t > 0.0, t)
}

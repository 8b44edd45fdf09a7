//! Twin of `glsl/lib/shape/triangle.glsl`.

use super::super::real::{Real, Real3};
use super::super::structs::Triangle;
use super::numeric::product_error;

/// The ray's part of the test.
#[derive(Debug, Clone, Copy)]
pub struct Shear {
    kz: usize,
    sx: Real,
    sy: Real,
    sz: Real,
}

fn permute(v: Real3, kz: usize) -> Real3 {
    match kz {
        0 => Real3::new(v.y, v.z, v.x),
        1 => Real3::new(v.z, v.x, v.y),
        _ => v,
    }
}

/// The shear that sends direction `d` to the z axis.
pub fn make_shear(d: Real3) -> Shear {
    let (x, y, z) = (d.x.abs(), d.y.abs(), d.z.abs());
    let kz = if x > y {
        if x > z { 0 } else { 2 }
    } else if y > z {
        1
    } else {
        2
    };
    let p = permute(d, kz);
    Shear { kz, sx: p.x / p.z, sy: p.y / p.z, sz: 1.0 / p.z }
}

fn exact_edge(a: Real, b: Real, c: Real, d: Real, rounded: Real) -> Real {
    if rounded != 0.0 {
        return rounded;
    }
    product_error(a, b, a * b) - product_error(c, d, c * d)
}

/// Whether the ray from `o` meets the triangle at 0 < t; t and the weights u of b and v of c.
pub fn hit_triangle(tri: &Triangle, o: Real3, s: &Shear, robust: bool) -> (bool, Real, Real, Real) {
    let a = permute(Real3::from(tri.a) - o, s.kz);
    let b = permute(Real3::from(tri.b) - o, s.kz);
    let c = permute(Real3::from(tri.c) - o, s.kz);
    let (ax, ay) = (a.x - s.sx * a.z, a.y - s.sy * a.z);
    let (bx, by) = (b.x - s.sx * b.z, b.y - s.sy * b.z);
    let (cx, cy) = (c.x - s.sx * c.z, c.y - s.sy * c.z);
    let mut ua = cx * by - cy * bx;
    let mut vb = ax * cy - ay * cx;
    let mut wc = bx * ay - by * ax;
    if robust && (ua == 0.0 || vb == 0.0 || wc == 0.0) {
        ua = exact_edge(cx, by, cy, bx, ua);
        vb = exact_edge(ax, cy, ay, cx, vb);
        wc = exact_edge(bx, ay, by, ax, wc);
    }
    let inside = (ua >= 0.0 && vb >= 0.0 && wc >= 0.0) || (ua <= 0.0 && vb <= 0.0 && wc <= 0.0);
    let det = (ua + vb) + wc;
    let scaled = ((ua * a.z + vb * b.z) + wc * c.z) * s.sz;
    let (t, u, v) = (scaled / det, vb / det, wc / det);
    (inside && det != 0.0 && t > 0.0, t, u, v)
}

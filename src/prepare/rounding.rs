//! How host numbers become those of the kernels.

use crate::kernel::abi::double;
use crate::scene::bounds::Bounds;
use crate::settings::Precision;
use glam::DVec3;

/// Radii that single numbers serve: outside, a ratio of distance to radius above 2^15 leaves f32 no
/// silhouette (numerics.md, Spheres: f32 holds to 1e5), and a surface too far from its centre no position.
pub(crate) const SINGLE_RADII: std::ops::RangeInclusive<f64> = (1.0 / 16_384.0)..=4096.0;

/// A number as a sum of two, each rounded as the kernels round.
pub(super) fn extended_sphere(center: DVec3, radius: f64, round: Rounding) -> double::ExtendedSphere {
    // The surface point nearest the origin; for a centre at the origin, any. Its distance is the
    // difference of two numbers that may be near equal, a planet's radius and its centre's distance,
    // so it comes from the difference of their squares, error-free (Dekker's product by fma).
    let normal = normalized(-center).unwrap_or(DVec3::Y);
    let scale = 2f64.powi(radius.max(center.abs().max_element()).log2().floor() as i32);
    let (r, c) = (radius / scale, center / scale);
    let products =
        [(r, r), (-c.x, c.x), (-c.y, c.y), (-c.z, c.z)].map(|(x, y)| (x * y, x.mul_add(y, -(x * y))));
    let (mut sum, mut error) = (0.0, 0.0);
    for (p, e) in products {
        let s: f64 = sum + p;
        let b = s - sum;
        error += (sum - (s - b)) + (p - b) + e;
        sum = s;
    }
    let point = normal * (scale * ((sum + error) / (r + c.length())));
    let split = |v: DVec3| {
        let high = round.point(v);
        (high.to_array(), round.point(v - high).to_array())
    };
    let ((point, point_low), (normal, normal_low)) = (split(point), split(normal));
    let high = round.number(radius);
    double::ExtendedSphere {
        point,
        point_low,
        normal,
        normal_low,
        radius: high,
        radius_low: round.number(radius - high),
    }
}

/// Unit vector, or `None` for exactly zero; safe for lengths whose squares leave f64.
pub(super) fn normalized(v: DVec3) -> Option<DVec3> {
    let m = v.abs().max_element();
    (m > 0.0).then(|| (v / m).normalize())
}

/// How the kernels of a precision round.
#[derive(Clone, Copy)]
pub(super) struct Rounding {
    pub precision: Precision,
    pub padding: f64,
}

impl Rounding {
    pub fn number(self, x: f64) -> f64 {
        if self.precision == Precision::Double { x } else { f64::from(x as f32) }
    }

    pub fn point(self, p: DVec3) -> DVec3 {
        DVec3::new(self.number(p.x), self.number(p.y), self.number(p.z))
    }

    /// `pad_down` and `pad_up` of glsl/lib/shape/box.glsl, operation by operation in the kernels' precision.
    pub fn padded(self, lo: DVec3, hi: DVec3) -> Bounds {
        let pad = |x: f64| self.number(self.padding * x.abs().max(1.0));
        let axis = |f: &dyn Fn(usize) -> f64| DVec3::new(f(0), f(1), f(2));
        Bounds {
            lo: axis(&|a| self.number(lo[a] - pad(lo[a]))),
            hi: axis(&|a| self.number(hi[a] + pad(hi[a]))),
        }
    }

    /// `sphere_box` of the same file.
    pub fn sphere_box(self, center: DVec3, radius: f64) -> Bounds {
        let r = DVec3::splat(radius);
        self.padded(self.point(center - r), self.point(center + r))
    }
}

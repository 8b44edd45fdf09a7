//! Rays against triangles and spheres, in `f64` and the scene's own units.

use glam::DVec3;

/// How far a ray's origin moves off the surface it leaves, in units of `sum |n_i| (|p_i| + extent)`.
///
/// A barycentric point is off its plane by at most 4u|p| + 12u extent along the normal (u = EPSILON/2),
/// and the test of a neighbour in the same plane moves that plane by no more than as much again: together
/// 12 EPSILON, rounded up to a power of two so that scaling a scene by 2^k changes no bit.
const ORIGIN_ERROR: f64 = 16.0 * f64::EPSILON;

/// A ray; `direction` is a unit vector, or ends at the light for a shadow ray.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ray {
    pub origin: DVec3,
    pub direction: DVec3,
    /// The primitive it leaves.
    pub from: Option<u32>,
}

impl Ray {
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }
}

/// Bound on the distance from the surface of a point computed to lie on it.
pub(super) fn origin_error(normal: DVec3, point: DVec3, extent: f64) -> f64 {
    ORIGIN_ERROR * normal.abs().dot(point.abs() + DVec3::splat(extent))
}

/// The ray's part of the triangle test: axes permuted and sheared so that the ray runs along +z.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shear {
    axes: [usize; 3],
    factors: [f64; 3],
}

impl Shear {
    pub fn of(direction: DVec3) -> Shear {
        let d = direction.to_array();
        let z = (0..3).fold(0, |best, i| if d[i].abs() > d[best].abs() { i } else { best });
        let (x, y) = ((z + 1) % 3, (z + 2) % 3);
        Shear { axes: [x, y, z], factors: [d[x] / d[z], d[y] / d[z], 1.0 / d[z]] }
    }

    fn apply(&self, v: DVec3) -> [f64; 3] {
        let [x, y, z] = self.axes.map(|i| v[i]);
        [x - self.factors[0] * z, y - self.factors[1] * z, z]
    }
}

/// Corners of a triangle.
pub(super) type Corners = [DVec3; 3];

/// Where a line meets a triangle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Crossing {
    pub t: f64,
    /// Weights of the corners.
    pub weights: [f64; 3],
    /// True if the ray runs exactly through an edge, where the neighbour is met too.
    pub on_edge: bool,
}

/// Watertight test of Woop, Benthin and Wald, JCGT 2(1), 2013: a neighbour computes the exact negation
/// of a shared edge's value, so one of the two accepts.
pub(super) fn cross_triangle(corners: &Corners, origin: DVec3, shear: &Shear) -> Option<Crossing> {
    let [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = corners.map(|p| shear.apply(p - origin));
    let (u, v, w) = (cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax);
    if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
        return None;
    }
    let det = (u + v) + w;
    let t = ((u * az + v * bz) + w * cz) * shear.factors[2] / det;
    // False for NaN, so that a triangle seen edge-on (det = 0) is missed.
    (det != 0.0 && t > 0.0 && t.is_finite()).then(|| Crossing {
        t,
        weights: [u / det, v / det, w / det],
        on_edge: u == 0.0 || v == 0.0 || w == 0.0,
    })
}

/// Smallest positive root of a ray and a sphere. The discriminant comes from the line's distance to the
/// centre: Haines, Günther and Akenine-Möller, *Ray Tracing Gems*, ch. 7.
pub(super) fn cross_sphere(center: DVec3, radius: f64, ray: &Ray) -> Option<f64> {
    let (f, a, b) = about(center, ray);
    let perpendicular = f + ray.direction * (b / a);
    let discriminant = radius * radius - perpendicular.length_squared();
    if discriminant < 0.0 {
        return None;
    }
    let root = (a * discriminant).sqrt();
    let q = if b < 0.0 { b - root } else { b + root };
    // (|f| - r)(|f| + r) keeps what |f|^2 - r^2 loses near the surface.
    let distance = f.length();
    let t0 = (distance - radius) * (distance + radius) / q;
    let t1 = q / a;
    let (near, far) = if t0 < t1 { (t0, t1) } else { (t1, t0) };
    [near, far].into_iter().find(|&t| t > 0.0 && t.is_finite())
}

/// The chord of a ray that leaves the sphere's own surface: one root is 0, the other 2b'/a.
pub(super) fn chord(center: DVec3, ray: &Ray) -> Option<f64> {
    let (_, a, b) = about(center, ray);
    (b > 0.0).then(|| 2.0 * b / a)
}

/// Origin seen from the centre, d.d, and b' = -f.d.
fn about(center: DVec3, ray: &Ray) -> (DVec3, f64, f64) {
    let f = ray.origin - center;
    (f, ray.direction.length_squared(), -f.dot(ray.direction))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ray(origin: [f64; 3], direction: [f64; 3]) -> Ray {
        Ray { origin: origin.into(), direction: direction.into(), from: None }
    }

    #[test]
    fn both_roots_of_spheres_in_a_row() {
        let at = |z: f64, from: f64| cross_sphere(DVec3::Z * z, 1.0, &ray([0.0, 0.0, from], [0.0, 0.0, 1.0]));
        assert_eq!(
            [at(0.0, -5.0), at(0.0, 0.0), at(3.0, -5.0), at(3.0, 3.5)].map(|t| t.unwrap_or(-1.0)),
            [4.0, 1.0, 7.0, 0.5]
        );
        assert_eq!(at(0.0, 1.5), None);
    }

    #[test]
    fn far_and_huge_spheres_keep_their_digits() {
        let t = cross_sphere(DVec3::ZERO, 1.0, &ray([0.3, 0.0, -1e7], [0.0, 0.0, 1.0])).unwrap();
        assert!((t - (1e7 - (1.0f64 - 0.09).sqrt())).abs() <= 4e-9, "{t}");
        let t = cross_sphere(DVec3::Y * -1e6, 1e6, &ray([0.0, 0.01, 0.0], [0.0, -1.0, 0.0])).unwrap();
        assert!((t - 0.01).abs() < 1e-9, "{t}");
    }

    #[test]
    fn chord_only_inward() {
        let s = 0.5f64.sqrt();
        let t = chord(DVec3::ZERO, &ray([1.0, 0.0, 0.0], [-s, s, 0.0])).unwrap();
        assert!((t - 2.0 * s).abs() < 4.0 * f64::EPSILON);
        assert_eq!(chord(DVec3::ZERO, &ray([1.0, 0.0, 0.0], [s, s, 0.0])), None);
    }

    #[test]
    fn a_fan_of_slivers_has_no_leak_at_its_hub() {
        // Rays aimed at the hub, at every spoke and at random inside: each meets at least one sliver.
        let hub = DVec3::new(0.1, -0.2, 3.0);
        let rim = |i: u32| {
            let a = f64::from(i % 37) * std::f64::consts::TAU / 37.0;
            hub + DVec3::new(a.cos(), a.sin(), 0.3 * (3.0 * a).sin())
        };
        let origin = DVec3::new(0.01, 0.02, 0.0);
        for i in 0..37 {
            for k in 0..50 {
                let target = hub + (rim(i) - hub) * (f64::from(k) / 50.0);
                let shear = Shear::of(target - origin);
                assert!(
                    (0..37).any(|j| cross_triangle(&[hub, rim(j), rim(j + 1)], origin, &shear).is_some())
                );
            }
        }
    }

    #[test]
    fn edge_on_and_behind_are_missed() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let shear = Shear::of(DVec3::X);
        assert!(cross_triangle(&corners, DVec3::new(-1.0, 0.2, 0.0), &shear).is_none());
        let shear = Shear::of(DVec3::Z);
        assert!(cross_triangle(&corners, DVec3::new(0.2, 0.2, 1.0), &shear).is_none());
        assert!(cross_triangle(&corners, DVec3::new(0.2, 0.2, -1.0), &shear).is_some());
    }
}

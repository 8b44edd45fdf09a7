//! Compares pictures with closed forms: the expected class of each pixel, except at edges.

use super::case::Harness;
use super::tracer::Picture;
use crate::scene::Scene;
use glam::DVec3;

/// The ray through image coordinates (x, y), in pixels from the top left, in world coordinates.
pub fn ray_through(scene: &Scene, x: f64, y: f64) -> (DVec3, DVec3) {
    let c = &scene.camera;
    let forward = (c.look_at - c.look_from).normalize();
    let right = forward.cross(c.up).normalize();
    let up = right.cross(forward);
    let half = (c.fov / 2.0).tan();
    let (w, h) = (f64::from(c.width), f64::from(c.height));
    let lateral = (2.0 * x / w - 1.0) * half * w / h * right + (1.0 - 2.0 * y / h) * half * up;
    (c.look_from, (forward + lateral).normalize())
}

/// Number of pixels whose class differs from that of their ray in `class_of`, and number of pixels
/// compared. A pixel is compared if the class is constant within `blur` pixels.
pub fn wrong_pixels(
    scene: &Scene,
    picture: &Picture,
    blur: f64,
    class_of: impl Fn(DVec3, DVec3) -> u8,
    class_in: impl Fn([f32; 3]) -> u8,
) -> (usize, usize) {
    let at = |x: f64, y: f64| {
        let (o, d) = ray_through(scene, x, y);
        class_of(o, d)
    };
    let (mut wrong, mut judged) = (0, 0);
    for (i, color) in picture.linear.iter().enumerate() {
        let (x, y) = (i as u32 % scene.camera.width, i as u32 / scene.camera.width);
        let (x, y) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
        let class = at(x, y);
        if [(blur, 0.0), (-blur, 0.0), (0.0, blur), (0.0, -blur)]
            .iter()
            .any(|(dx, dy)| at(x + dx, y + dy) != class)
        {
            continue;
        }
        judged += 1;
        wrong += usize::from(class_in(*color) != class);
    }
    (wrong, judged)
}

/// 1 for a lit pixel, 0 for black, 2 if not finite.
pub fn lit(color: [f32; 3]) -> u8 {
    if color.iter().any(|c| !c.is_finite()) { 2 } else { u8::from(color.iter().any(|c| *c > 0.0)) }
}

/// Nearest t > 0 of a sphere, in f64.
pub fn sphere_hit(o: DVec3, d: DVec3, c: DVec3, r: f64) -> Option<f64> {
    let f = o - c;
    let b = -f.dot(d);
    let p = f + b * d;
    let disc = r * r - p.length_squared();
    if disc < 0.0 {
        return None;
    }
    let q = if b < 0.0 { b - disc.sqrt() } else { b + disc.sqrt() };
    let lack = (f.length() - r) * (f.length() + r);
    let (x, y) = (lack / q, q);
    let (near, far) = (x.min(y), x.max(y));
    [near, far].into_iter().find(|t| *t > 0.0)
}

/// Shift of a shadow's edge by the ray offset, in pixels of `footprint` metres, plus 0.02 pixels
/// for all other roundings: 4u |p| + 12u * 2 ext along each axis of a frame of radius 1
/// (numerics.md, Spawn origins) is under 64u.
pub fn blur(h: &Harness<'_>, scene: &Scene, footprint: f64) -> f64 {
    let radius = 2f64.powi(-h.local_frame(scene).scale_log2);
    0.02 + 64.0 * h.u() * radius / footprint
}

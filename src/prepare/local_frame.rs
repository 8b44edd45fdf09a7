//! The local frame: kernels see `(world - center) * 2^scale_log2`, so that the scene fills a ball of
//! radius in (1/2, 1] and f32 spends its bits on it (numerics.md, Local frame). The power of two is exact:
//! scaling a scene by one changes no bit of its image. A scene of two scales, near things in a room and a
//! moon, has its frame around what the eye sees first (numerics.md, Two scales).

use super::near::Near;
use crate::scene::bounds::Bounds;
use crate::scene::{Camera, Scene};
use glam::DVec3;

/// A sphere this many times the rest of the scene stays out of the local frame.
const HUGE: f64 = 4096.0;

fn half(b: &Bounds) -> DVec3 {
    b.hi * 0.5 - b.lo * 0.5
}

/// A cube around the eye that reaches the nearest surface of a sphere, or the point looked at.
fn around_eye(scene: &Scene) -> Bounds {
    let c = &scene.camera;
    let height = |s: &crate::scene::Sphere| (s.center.distance(c.look_from) - s.radius).abs();
    let nearest = scene.spheres.iter().map(height).filter(|h| *h > 0.0).fold(f64::INFINITY, f64::min);
    let reach = if nearest.is_finite() { nearest } else { c.look_at.distance(c.look_from) };
    Bounds::of_sphere(c.look_from, reach)
}

/// The map from the user's space to the kernels'.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalFrame {
    /// World position of the local origin, metres.
    pub center: DVec3,
    /// Binary exponent of the scale.
    pub scale_log2: i32,
    /// The scene's box in local coordinates.
    pub bounds: Bounds,
    /// What the frame was drawn in to, in a scene of two scales.
    pub near: Option<Near>,
}

impl LocalFrame {
    /// The frame of a scene: around all of it, or, where that leaves too few digits to what the eye sees first,
    /// around that.
    pub fn of(scene: &Scene) -> LocalFrame {
        let whole = LocalFrame::of_whole(scene);
        Near::of(scene, &whole).map_or(whole, |near| whole.drawn_in(near))
    }

    /// This frame of everything, drawn in to what is near.
    fn drawn_in(&self, near: Near) -> LocalFrame {
        let scale_log2 = -exponent_of_length(DVec3::X * near.extent);
        let mut frame = LocalFrame { center: near.center, scale_log2, near: Some(near), ..*self };
        let back = |p: DVec3| {
            let world = p.to_array().map(|x| times_power_of_two(x, -self.scale_log2));
            frame.point(self.center + DVec3::from(world))
        };
        frame.bounds = Bounds { lo: back(self.bounds.lo), hi: back(self.bounds.hi) };
        frame
    }

    /// The frame of all geometry but for spheres so huge that f32 could not tell the rest apart beside them (a planet
    /// under a table). Of the eye where there is nothing else.
    pub(crate) fn of_whole(scene: &Scene) -> LocalFrame {
        let corners = scene.polygons.iter().flat_map(|p| &p.vertices);
        let flat = corners.fold(Bounds::EMPTY, |b, p| b.with(*p));
        let flat = scene.meshes.iter().fold(flat, |b, mesh| b.union(mesh.bounds()));
        let mut spheres: Vec<(f64, Bounds)> =
            scene.spheres.iter().map(|s| (s.radius, Bounds::of_sphere(s.center, s.radius))).collect();
        spheres.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut all = flat;
        // Smallest first: box of everything up to each sphere, so that dropping the largest is cheap.
        let up_to: Vec<Bounds> = spheres
            .iter()
            .map(|(_, b)| {
                all = all.union(*b);
                all
            })
            .collect();
        let mut kept = spheres.len();
        while kept > 0 {
            let rest = if kept > 1 { up_to[kept - 2] } else { flat };
            // Huge beside the rest, and beside its distance from the eye: from afar even a planet is a
            // ball.
            let (radius, b) = spheres[kept - 1];
            let eye = scene.camera.look_from;
            let height = (eye.distance(b.lo * 0.5 + b.hi * 0.5) - radius).abs();
            if radius <= HUGE * half(&rest.with(eye)).length().max(height) {
                break;
            }
            kept -= 1;
        }
        let eye = scene.camera.look_from;
        let focus = match kept {
            0 if spheres.is_empty() => flat,
            0 => flat.with(eye),
            n => up_to[n - 1],
        };
        let focus = if focus.is_empty() || half(&focus).length() == 0.0 { around_eye(scene) } else { focus };
        // Halves first: the sum of two large coordinates must not overflow.
        let center = focus.lo * 0.5 + focus.hi * 0.5;
        let scale_log2 = -exponent_of_length(half(&focus));
        let mut frame = LocalFrame { center, scale_log2, bounds: Bounds::EMPTY, near: None };
        if !all.is_empty() {
            frame.bounds = Bounds { lo: frame.point(all.lo), hi: frame.point(all.hi) };
        }
        frame
    }

    /// 2^scale_log2 applied to a length; exact unless it leaves f64's range.
    pub fn length(&self, world: f64) -> f64 {
        times_power_of_two(world, self.scale_log2)
    }

    /// A point in local coordinates.
    pub fn point(&self, world: DVec3) -> DVec3 {
        self.map().point(world)
    }

    /// The same for many points.
    pub fn map(&self) -> PointMap {
        PointMap { center: self.center, factors: power_of_two(self.scale_log2) }
    }

    /// The eye's position in local coordinates and how far in front of it, along the view, all
    /// geometry begins: 0 if the eye is beside or within the scene's box. In a scene of two scales, how far in front
    /// all geometry begins that is in the view of an image of `aspect` = width / height.
    pub fn eye(&self, scene: &Scene, forward: DVec3, aspect: f64) -> (DVec3, f64) {
        let camera: &Camera = &scene.camera;
        let eye = self.point(camera.look_from);
        if let Some(near) = &self.near {
            return (eye, self.length(near.advance_for(scene, aspect)));
        }
        let nearest =
            self.bounds.corners().iter().map(|c| (*c - eye).dot(forward)).fold(f64::INFINITY, f64::min);
        // Kept clear of the geometry by more than f32 rounds the start plane: u times a ball of
        // radius 1 and u relative, each with a factor of 8 in hand.
        let clear = nearest - nearest.abs() * 2f64.powi(-21) - 2f64.powi(-21);
        (eye, clear.max(0.0))
    }
}

/// From the user's coordinates to those of a local frame.
#[derive(Debug, Clone, Copy)]
pub struct PointMap {
    center: DVec3,
    factors: [f64; 2],
}

impl PointMap {
    /// A point in local coordinates.
    pub fn point(&self, world: DVec3) -> DVec3 {
        (world - self.center) * self.factors[0] * self.factors[1]
    }
}

/// 2^k as two factors, as 2^k itself may lie outside f64's range.
fn power_of_two(k: i32) -> [f64; 2] {
    [k / 2, k - k / 2].map(|k| 2f64.powi(k))
}

/// x * 2^k, exact unless it leaves f64's range.
pub fn times_power_of_two(x: f64, k: i32) -> f64 {
    let [first, second] = power_of_two(k);
    x * first * second
}

/// The k with |v| in (2^(k-1), 2^k]; 0 for the zero vector.
fn exponent_of_length(v: DVec3) -> i32 {
    let m = v.abs().max_element();
    if m == 0.0 || !m.is_finite() {
        return 0;
    }
    let k = m.log2().floor() as i32;
    let scaled =
        DVec3::new(times_power_of_two(v.x, -k), times_power_of_two(v.y, -k), times_power_of_two(v.z, -k));
    let length = scaled.length(); // in [1, 2 sqrt 3]
    k + (length.log2().ceil() as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn length_lands_in_the_unit_ball() {
        for k in [-300, -60, -1, 0, 1, 60, 300] {
            for v in [DVec3::new(1.0, 0.0, 0.0), DVec3::new(3.0, -2.0, 0.5), DVec3::splat(0.9)] {
                let w = v * 2f64.powi(k);
                let e = exponent_of_length(w);
                let r = times_power_of_two(w.length(), -e);
                assert!(r > 0.5 && r <= 1.0, "{w:?}: {r}");
            }
        }
        assert_eq!(exponent_of_length(DVec3::ZERO), 0);
    }
}

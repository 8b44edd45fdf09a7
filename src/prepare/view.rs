//! What the eye has in front of it: the depth at which the first of a scene's shapes reaches into the view.

use crate::scene::bounds::Bounds;
use crate::scene::{Camera, Mesh, Scene};
use glam::DVec3;
use rayon::prelude::*;

/// The pyramid that the eye looks into. All lengths in metres.
#[derive(Debug, Clone, Copy)]
pub(super) struct View {
    eye: DVec3,
    /// Unit vectors to the right, up and forward.
    axes: [DVec3; 3],
    /// Half the view's width and height at depth 1.
    half: [f64; 2],
    /// Cosine of the angle from the view's middle to its corner.
    corner_cos: f64,
}

impl View {
    /// That of `camera` for an image of `aspect` = width / height.
    pub(super) fn new(camera: &Camera, aspect: f64) -> View {
        let half_height = (camera.fov / 2.0).tan();
        let half = [half_height * aspect, half_height];
        let corner_cos = 1.0 / (1.0 + half[0] * half[0] + half[1] * half[1]).sqrt();
        View { eye: camera.look_from, axes: camera.axes(), half, corner_cos }
    }

    /// The least depth, the distance along the view, at which a shape is in view, if it is below `limit`.
    /// Never more than the true one but for rounding in f64; shapes hide none.
    pub(super) fn nearest(&self, scene: &Scene, limit: f64) -> Option<f64> {
        let spheres = scene.spheres.iter().map(|s| self.of_sphere(s.center, s.radius));
        let polygons = scene.polygons.iter().map(|p| {
            let bounds = p.vertices.iter().fold(Bounds::EMPTY, |b, v| b.with(*v));
            if self.is_beyond(&bounds, limit) { f64::INFINITY } else { self.of_polygon(&p.vertices) }
        });
        let least = spheres.chain(polygons).fold(f64::INFINITY, f64::min);
        let meshes = scene.meshes.iter().filter(|m| !self.is_beyond(&m.bounds(), limit));
        let least = meshes.map(|m| self.of_mesh(m, limit)).fold(least, f64::min);
        (least < limit).then_some(least)
    }

    fn of_mesh(&self, mesh: &Mesh, limit: f64) -> f64 {
        let of_face = |face: &crate::scene::Face| {
            let corners = face.vertices.map(|v| mesh.vertices[v as usize]);
            let bounds = corners.iter().fold(Bounds::EMPTY, |b, c| b.with(*c));
            if self.is_beyond(&bounds, limit) { f64::INFINITY } else { self.of_polygon(&corners) }
        };
        mesh.faces.par_iter().map(of_face).reduce(|| f64::INFINITY, f64::min)
    }

    /// True if a box lies behind the eye, or nowhere nearer than `limit`.
    fn is_beyond(&self, bounds: &Bounds, limit: f64) -> bool {
        let [.., forward] = self.axes;
        let (mut least, mut most) = (0.0, 0.0);
        for axis in 0..3 {
            let a = (bounds.lo[axis] - self.eye[axis]) * forward[axis];
            let b = (bounds.hi[axis] - self.eye[axis]) * forward[axis];
            least += a.min(b);
            most += a.max(b);
        }
        !(least < limit && most >= 0.0)
    }

    fn of_sphere(&self, center: DVec3, radius: f64) -> f64 {
        let [.., forward] = self.axes;
        let to = center - self.eye;
        let (distance, depth) = (to.length(), to.dot(forward));
        if distance <= radius {
            return (radius - distance) * self.corner_cos;
        }
        // Angle between the sphere's middle and the view's, against those of the two rims.
        let apart = (depth / distance).clamp(-1.0, 1.0).acos();
        if apart > self.corner_cos.acos() + (radius / distance).asin() {
            return f64::INFINITY;
        }
        ((distance - radius) * self.corner_cos).max(depth - radius)
    }

    /// A convex polygon, cut by the four sides of the view (Sutherland and Hodgman, CACM 17(1), 1974).
    fn of_polygon(&self, corners: &[DVec3]) -> f64 {
        let mut inside: Vec<DVec3> = corners
            .iter()
            .map(|c| {
                let to = *c - self.eye;
                DVec3::from(self.axes.map(|axis| to.dot(axis)))
            })
            .collect();
        let [wide, high] = self.half;
        let sides: [fn(DVec3, f64, f64) -> f64; 5] = [
            |p, _, _| p.z,
            |p, wide, _| p.z * wide - p.x,
            |p, wide, _| p.z * wide + p.x,
            |p, _, high| p.z * high - p.y,
            |p, _, high| p.z * high + p.y,
        ];
        for side in sides {
            let mut kept = Vec::with_capacity(inside.len() + 1);
            for (i, p) in inside.iter().enumerate() {
                let q = inside[(i + 1) % inside.len()];
                let (a, b) = (side(*p, wide, high), side(q, wide, high));
                if a >= 0.0 {
                    kept.push(*p);
                }
                if (a > 0.0 && b < 0.0) || (a < 0.0 && b > 0.0) {
                    kept.push(*p + (q - *p) * (a / (a - b)));
                }
            }
            inside = kept;
        }
        inside.iter().map(|p| p.z.max(0.0)).fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::procedural::shapes::{empty, matte, mesh, polygon, sphere};

    /// From (0, 0, 5) toward -z, tan of half the field 0.5 either way.
    fn seen() -> Scene {
        let mut s = empty(vec![matte([1.0; 3], 0.0)]);
        s.camera.fov = 2.0 * 0.5f64.atan();
        s
    }

    fn nearest(s: &Scene) -> Option<f64> {
        View::new(&s.camera, 1.0).nearest(s, f64::INFINITY)
    }

    #[test]
    fn depth_is_that_of_what_is_in_view() {
        let wall =
            |z: f64, x: f64| polygon(&[[x, -1.0, z], [x + 1.0, -1.0, z], [x + 1.0, 1.0, z], [x, 1.0, z]], 0);
        let mut s = seen();
        assert_eq!(nearest(&s), None);
        s.polygons = vec![wall(6.0, 0.0), wall(4.0, 0.51), wall(2.0, 0.0)];
        assert_eq!(nearest(&s), Some(3.0), "behind, beside, before");
        s.spheres = vec![sphere([0.0, 0.0, 4.0], 0.25, 0)];
        let depth = nearest(&s).unwrap();
        assert!(depth <= 0.75 && depth > 0.6, "{depth}");
        s.spheres = vec![sphere([3.0, 0.0, 4.0], 0.25, 0), sphere([0.0, 0.0, 8.0], 2.5, 0)];
        assert_eq!(nearest(&s), Some(3.0), "beside and behind");
        // Nothing of it is a corner in view: the ground 1 below is met at depth 2.
        s.polygons
            .push(polygon(&[[-1e5, -1.0, -1e5], [-1e5, -1.0, 1e5], [1e5, -1.0, 1e5], [1e5, -1.0, -1e5]], 0));
        assert!((nearest(&s).unwrap() - 2.0).abs() < 1e-9);
        assert_eq!(View::new(&s.camera, 1.0).nearest(&s, 1.5), None);
    }

    #[test]
    fn meshes_count_as_polygons_do() {
        let mut s = seen();
        let corners = [[-1e5, -1.0, -1e5], [-1e5, -1.0, 1e5], [2e5, -1.0, 0.0]].map(DVec3::from);
        s.meshes = vec![mesh(corners.to_vec(), &[[0, 1, 2]], 0)];
        assert!((nearest(&s).unwrap() - 2.0).abs() < 1e-9);
    }
}

//! Collects the vertices and triangles of one mesh for readers whose files may hold anything: what is not
//! finite is left out and counted, a mirrored place keeps the outside outside.

use super::obj::is_flat;
use super::table::{MAX_LENGTH, unit};
use super::triangulate::{self, Cut};
use super::{Face, Mesh, Transform};
use glam::DVec3;

/// A mesh being read. Corners must be indices of vertices and normals added before.
pub(super) struct MeshBuilder {
    place: Transform,
    /// The order of corners is reversed.
    mirrored: bool,
    /// NaN where the file's vertex is not finite, or its place beyond [`MAX_LENGTH`].
    vertices: Vec<DVec3>,
    /// Zero where the file's normal has no direction.
    normals: Vec<DVec3>,
    faces: Vec<Face>,
    lost: usize,
}

impl MeshBuilder {
    /// An empty mesh whose vertices and normals go through `place`.
    pub fn new(place: Transform) -> MeshBuilder {
        MeshBuilder {
            place,
            mirrored: place.mirrors(),
            vertices: Vec::new(),
            normals: Vec::new(),
            faces: Vec::new(),
            lost: 0,
        }
    }

    /// Number of vertices so far.
    pub fn vertex_count(&self) -> usize {
        self.vertices.len()
    }

    /// Number of normals so far.
    pub fn normal_count(&self) -> usize {
        self.normals.len()
    }

    /// Adds a vertex, in the file's space.
    pub fn vertex(&mut self, position: DVec3) {
        let placed = self.place.point(position);
        let sound = position.is_finite() && placed.abs().max_element() <= MAX_LENGTH;
        self.vertices.push(if sound { placed } else { DVec3::NAN });
    }

    /// Adds a shading normal of any length, in the file's space.
    pub fn normal(&mut self, direction: DVec3) {
        let direction = Some(direction).filter(|d| d.is_finite()).and_then(unit);
        let placed = direction.map(|d| self.place.normal(d)).filter(|d| d.is_finite());
        self.normals.push(placed.unwrap_or(DVec3::ZERO));
    }

    /// Adds a triangle. Corners whose normals have no direction, or are the triangle's own, leave it flat.
    pub fn triangle(&mut self, corners: [u32; 3], normals: Option<[u32; 3]>, material: usize) {
        let turn = |[a, b, c]: [u32; 3]| if self.mirrored { [a, c, b] } else { [a, b, c] };
        let vertices = turn(corners);
        if vertices.iter().any(|v| self.vertices[*v as usize].is_nan()) {
            self.lost += 1;
            return;
        }
        let curved = |n: &[u32; 3]| {
            n.iter().all(|i| self.normals[*i as usize] != DVec3::ZERO)
                && !is_flat(&self.vertices, &self.normals, vertices, *n)
        };
        let normals = normals.map(turn).filter(curved);
        self.faces.push(Face { vertices, normals, material });
    }

    /// Adds the triangles of a face with three or more corners.
    pub fn polygon(&mut self, corners: &[u32], normals: Option<&[u32]>, material: usize) {
        let places: Vec<DVec3> = corners.iter().map(|c| self.vertices[*c as usize]).collect();
        let triangles = match triangulate::cut(&places) {
            Ok(Cut::Triangles(triangles)) => triangles,
            // A border that crosses itself, or a corner that is none, leaves nothing better.
            _ => (1..corners.len().saturating_sub(1) as u32).map(|i| [0, i, i + 1]).collect(),
        };
        for [a, b, c] in triangles.into_iter().map(|t| t.map(|i| i as usize)) {
            let normals = normals.map(|n| [n[a], n[b], n[c]]);
            self.triangle([corners[a], corners[b], corners[c]], normals, material);
        }
    }

    /// The mesh, and how many triangles had a corner that is not finite and are left out.
    pub fn finish(mut self, name: String) -> (Mesh, usize) {
        // Whatever no triangle uses still has to be a number.
        for vertex in self.vertices.iter_mut().filter(|v| v.is_nan()) {
            *vertex = DVec3::ZERO;
        }
        for normal in self.normals.iter_mut().filter(|n| **n == DVec3::ZERO) {
            *normal = DVec3::Z;
        }
        if self.faces.iter().all(|face| face.normals.is_none()) {
            self.normals = Vec::new();
        }
        let MeshBuilder { vertices, normals, faces, lost, .. } = self;
        (Mesh { name, vertices, normals, faces }, lost)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DAffine3;

    #[test]
    fn mirrors_keep_the_outside_and_lost_corners_are_counted() {
        let mirror = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        let place = Transform::new(1.0, DVec3::ZERO, DVec3::ZERO);
        let outside = |place: Transform| {
            let mut builder = MeshBuilder::new(place);
            for v in [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::INFINITY, DVec3::splat(1e80)] {
                builder.vertex(v);
            }
            builder.triangle([0, 1, 2], None, 0);
            builder.triangle([0, 1, 3], None, 0);
            builder.triangle([0, 1, 4], None, 0);
            let (mesh, lost) = builder.finish(String::new());
            assert_eq!((mesh.faces.len(), lost), (1, 2));
            assert!(mesh.vertices.iter().all(|v| v.is_finite()));
            let [a, b, c] = mesh.faces[0].vertices.map(|v| mesh.vertices[v as usize]);
            (b - a).cross(c - a)
        };
        assert_eq!(outside(place), DVec3::Z);
        assert_eq!(outside(place.after(mirror).unwrap()), DVec3::Z);
    }

    #[test]
    fn a_dent_is_not_covered() {
        let mut builder = MeshBuilder::new(Transform::new(1.0, DVec3::ZERO, DVec3::ZERO));
        for [x, y] in [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 0.5]] {
            builder.vertex(DVec3::new(x, y, 0.0));
        }
        builder.polygon(&[0, 1, 2, 3], None, 0);
        let (mesh, _) = builder.finish(String::new());
        let areas = mesh.faces.iter().map(|f| {
            let [a, b, c] = f.vertices.map(|v| mesh.vertices[v as usize]);
            (b - a).cross(c - a).z / 2.0
        });
        assert_eq!(areas.clone().sum::<f64>(), 1.5);
        assert!(areas.into_iter().all(|area| area > 0.0));
    }

    #[test]
    fn normals_without_direction_leave_a_triangle_flat() {
        let mut builder = MeshBuilder::new(Transform::new(1.0, DVec3::ZERO, DVec3::ZERO));
        for v in [DVec3::ZERO, DVec3::X, DVec3::Y] {
            builder.vertex(v);
        }
        for n in [DVec3::Z, DVec3::new(1.0, 0.0, 5.0), DVec3::ZERO, DVec3::NAN] {
            builder.normal(n);
        }
        builder.triangle([0, 1, 2], Some([0, 0, 0]), 0);
        builder.triangle([0, 1, 2], Some([0, 1, 2]), 0);
        builder.triangle([0, 1, 2], Some([0, 1, 3]), 0);
        builder.triangle([0, 1, 2], Some([0, 1, 1]), 0);
        let (mesh, _) = builder.finish(String::new());
        let normals: Vec<_> = mesh.faces.iter().map(|f| f.normals).collect();
        assert_eq!(normals, [None, None, None, Some([0, 1, 1])]);
        assert!(mesh.normals.iter().all(|n| n.is_normalized()));
    }
}

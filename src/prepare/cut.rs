//! Large flat shapes that pass near the eye, cut into pieces whose size grows with their distance: a ground of a
//! hundred kilometres under things of centimetres. Each piece has then the digits that its distance needs
//! (numerics.md, Two scales).
//!
//! Whether an edge is halved depends on the edge alone, so that neighbours halve it alike and no T-junction opens. A
//! triangle whose edges are all far off, but which itself passes near, gets a new corner at its nearest point.

use crate::scene::{Face, Mesh, Polygon, Scene};
use glam::DVec3;

/// Largest extent of a piece, in distances of its nearest point from the eye.
pub(super) const LARGEST: f64 = 2.0;
/// Pieces of a scene, at most; beyond, nothing is cut.
const MOST_PIECES: usize = 1 << 21;
/// Halvings of an edge, at most: f64 has no more to give.
const MOST_HALVINGS: u32 = 96;

/// Where digits are wanted: around `center`, seen from `depth` before it. Metres.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub(super) center: DVec3,
    pub(super) depth: f64,
}

/// A corner of a piece: position, and shading normal of a smooth face (not of unit length).
#[derive(Debug, Clone, Copy, PartialEq)]
struct Corner {
    at: DVec3,
    normal: DVec3,
}

impl Corner {
    fn halfway(p: Corner, q: Corner) -> Corner {
        // Halves first: the sum of two large coordinates must not overflow.
        Corner { at: p.at * 0.5 + q.at * 0.5, normal: p.normal * 0.5 + q.normal * 0.5 }
    }
}

type Corners = [Corner; 3];

impl Place {
    /// From `center` to the nearest point of a triangle.
    pub(super) fn distance(&self, corners: &[DVec3; 3]) -> f64 {
        let w = nearest(corners, self.center);
        (corners[0] * w[0] + corners[1] * w[1] + corners[2] * w[2]).distance(self.center)
    }

    /// True for an edge to halve; the same for both directions of the edge.
    fn halves(&self, p: DVec3, q: DVec3) -> bool {
        let (p, q) = if p.to_array() <= q.to_array() { (p, q) } else { (q, p) };
        let along = q - p;
        let length_squared = along.length_squared();
        let share = if length_squared > 0.0 { (self.center - p).dot(along) / length_squared } else { 0.0 };
        let distance = (p + along * share.clamp(0.0, 1.0)).distance(self.center);
        (q - p).abs().max_element() > LARGEST * (self.depth + distance)
    }

    /// Pieces of a triangle, appended to `pieces`; false if there are too many.
    fn cut(&self, corners: Corners, halvings: u32, pieces: &mut Vec<Corners>) -> bool {
        let [a, b, c] = corners;
        if halvings == MOST_HALVINGS || pieces.len() > MOST_PIECES {
            pieces.push(corners);
            return pieces.len() <= MOST_PIECES;
        }
        let mut all = |parts: &[Corners]| parts.iter().all(|p| self.cut(*p, halvings + 1, pieces));
        let split = [(a, b), (b, c), (c, a)].map(|(p, q)| self.halves(p.at, q.at));
        let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(p, q)| Corner::halfway(p, q));
        match split {
            [true, true, true] => all(&[[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]),
            [true, true, false] => all(&[[ab, b, bc], [a, ab, bc], [a, bc, c]]),
            [false, true, true] => all(&[[bc, c, ca], [b, bc, ca], [b, ca, a]]),
            [true, false, true] => all(&[[ca, a, ab], [c, ca, ab], [c, ab, b]]),
            [true, false, false] => all(&[[a, ab, c], [ab, b, c]]),
            [false, true, false] => all(&[[b, bc, a], [bc, c, a]]),
            [false, false, true] => all(&[[c, ca, b], [ca, a, b]]),
            [false, false, false] => {
                let at = corners.map(|c| c.at);
                let w = nearest(&at, self.center);
                if extent(&at) <= LARGEST * (self.depth + self.distance(&at)) || w.iter().any(|w| *w <= 0.0) {
                    pieces.push(corners);
                    return true;
                }
                let mix = |f: fn(&Corner) -> DVec3| f(&a) * w[0] + f(&b) * w[1] + f(&c) * w[2];
                let foot = Corner { at: mix(|c| c.at), normal: mix(|c| c.normal) };
                all(&[[a, b, foot], [b, c, foot], [c, a, foot]])
            }
        }
    }
}

/// Longest side of a triangle's box.
pub(super) fn extent([a, b, c]: &[DVec3; 3]) -> f64 {
    (a.max(*b).max(*c) - a.min(*b).min(*c)).max_element()
}

/// Weights of the corners in the point of a triangle that is nearest to `p` (Ericson, *Real-Time Collision
/// Detection*, 2005, 5.1.5).
fn nearest([a, b, c]: &[DVec3; 3], p: DVec3) -> [f64; 3] {
    let (ab, ac) = (b - a, c - a);
    let (d1, d2) = (ab.dot(p - a), ac.dot(p - a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let (d3, d4) = (ab.dot(p - b), ac.dot(p - b));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let v = d1 / (d1 - d3);
        return [1.0 - v, v, 0.0];
    }
    let (d5, d6) = (ab.dot(p - c), ac.dot(p - c));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let w = d2 / (d2 - d6);
        return [1.0 - w, 0.0, w];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - w, w];
    }
    let sum = va + vb + vc;
    [va / sum, vb / sum, vc / sum]
}

/// `scene` with every triangle cut that is too large for its distance; `None` if none is, or there would be too many
/// pieces.
pub(super) fn cut(scene: &Scene, place: Place) -> Option<Scene> {
    let mut all = Pieces { place, count: 0, cuts: false };
    let polygons = scene.polygons.iter().map(|p| all.of_polygon(p)).collect::<Option<Vec<_>>>()?.concat();
    let meshes = scene.meshes.iter().map(|m| all.of_mesh(m)).collect::<Option<Vec<_>>>()?;
    all.cuts.then(|| Scene { polygons, meshes, ..without_shapes(scene) })
}

/// All of a scene but its polygons and meshes.
fn without_shapes(scene: &Scene) -> Scene {
    Scene {
        file: scene.file.clone(),
        read_time: scene.read_time.clone(),
        camera: scene.camera,
        render: scene.render,
        lights: scene.lights.clone(),
        materials: scene.materials.clone(),
        spheres: scene.spheres.clone(),
        polygons: Vec::new(),
        meshes: Vec::new(),
        notes: scene.notes.clone(),
    }
}

struct Pieces {
    place: Place,
    count: usize,
    /// Some triangle is in more than one piece.
    cuts: bool,
}

impl Pieces {
    /// The pieces of a triangle; `None` if there are too many.
    fn of(&mut self, corners: Corners) -> Option<Vec<Corners>> {
        let mut pieces = Vec::new();
        let fits = self.place.cut(corners, 0, &mut pieces);
        self.count += pieces.len() - 1;
        self.cuts |= pieces.len() > 1;
        (fits && self.count <= MOST_PIECES).then_some(pieces)
    }

    fn of_polygon(&mut self, polygon: &Polygon) -> Option<Vec<Polygon>> {
        let corner = |i: usize| Corner { at: polygon.vertices[i], normal: DVec3::ZERO };
        let mut pieces = Vec::new();
        for k in 0..polygon.triangle_count() {
            pieces.extend(self.of(polygon.triangle(k).map(corner))?);
        }
        if pieces.len() == polygon.triangle_count() {
            return Some(vec![polygon.clone()]);
        }
        let piece = |c: Corners| Polygon::fan(c.map(|c| c.at).to_vec(), polygon.normal, polygon.material);
        Some(pieces.into_iter().map(piece).collect())
    }

    fn of_mesh(&mut self, mesh: &Mesh) -> Option<Mesh> {
        let mut out = Mesh { faces: Vec::with_capacity(mesh.faces.len()), ..mesh.clone() };
        for face in &mesh.faces {
            let normals = face.normals.map_or([DVec3::ZERO; 3], |n| n.map(|n| mesh.normals[n as usize]));
            let at = face.vertices.map(|v| mesh.vertices[v as usize]);
            let pieces = self.of(std::array::from_fn(|i| Corner { at: at[i], normal: normals[i] }))?;
            if pieces.len() == 1 {
                out.faces.push(*face);
                continue;
            }
            for piece in pieces {
                let first = u32::try_from(out.vertices.len()).ok()?;
                out.vertices.extend(piece.map(|c| c.at));
                let vertices = [first, first + 1, first + 2];
                let normals = match face.normals {
                    None => None,
                    Some(_) => {
                        let first = u32::try_from(out.normals.len()).ok()?;
                        out.normals.extend(piece.map(|c| c.normal));
                        Some([first, first + 1, first + 2])
                    }
                };
                out.faces.push(Face { vertices, normals, material: face.material });
            }
        }
        Some(out)
    }
}

#[cfg(test)]
mod tests;

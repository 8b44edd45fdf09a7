//! Which solids a ray is in.

use super::geometry::{Shear, cross_triangle};
use super::world::{Boundary, World};
use crate::scene::Material;
use crate::settings::sampler::pcg4d;
use glam::DVec3;

#[derive(Debug, Clone, Copy)]
struct Medium {
    solid: usize,
    ior: f64,
    priority: i32,
}

/// The solids a ray is in, in the order it entered them. Of those with the highest priority the last
/// one entered fills the space.
#[derive(Debug, Clone, Default)]
pub(super) struct Media(Vec<Medium>);

impl Medium {
    fn of(solid: usize, material: &Material) -> Medium {
        Medium { solid, ior: material.ior, priority: material.priority }
    }
}

impl Media {
    /// Index of refraction around the ray.
    pub fn ior(&self) -> f64 {
        self.0.iter().max_by_key(|m| m.priority).map_or(1.0, |m| m.ior)
    }

    /// True if the matter on both sides of the surface of `solid` is another solid's, which has a
    /// higher priority: then the surface is not there for light.
    pub fn hides(&self, solid: usize, priority: i32) -> bool {
        self.0.iter().any(|m| m.solid != solid && m.priority > priority)
    }

    /// After crossing the surface of `solid`: out of it if the ray was in it, else into it.
    pub fn across(&self, solid: usize, material: &Material) -> Media {
        let mut list = self.0.clone();
        match list.iter().rposition(|m| m.solid == solid) {
            Some(i) => {
                list.remove(i);
            }
            None => list.push(Medium::of(solid, material)),
        }
        Media(list)
    }

    /// The solids that contain `eye`, the largest first.
    pub fn around(eye: DVec3, world: &World, materials: &[Material]) -> Media {
        let mut found: Vec<(f64, Medium)> = Vec::new();
        let faces: Vec<_> = world.triangles.iter().filter(|t| materials[t.material].refracts()).collect();
        for group in faces.chunk_by(|a, b| a.boundary == b.boundary) {
            if let Boundary::Solid(solid) = group[0].boundary {
                let corners = || group.iter().flat_map(|t| t.corners);
                let low = corners().fold(DVec3::INFINITY, DVec3::min);
                let high = corners().fold(DVec3::NEG_INFINITY, DVec3::max);
                let within = eye.cmpge(low).all() && eye.cmple(high).all();
                if within && odd_crossings(eye, || group.iter().map(|t| &t.corners)) {
                    let medium = Medium::of(solid, &materials[group[0].material]);
                    found.push((low.distance(high), medium));
                }
            }
        }
        for ball in world.balls.iter().filter(|b| materials[b.material].refracts()) {
            if eye.distance(ball.center) < ball.radius {
                // The diagonal of its bounding box, to compare with a mesh's.
                let size = ball.radius * 12f64.sqrt();
                found.push((size, Medium::of(ball.solid, &materials[ball.material])));
            }
        }
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        Media(found.into_iter().map(|(_, medium)| medium).collect())
    }
}

/// Parity of the crossings of a ray from `eye`. The triangle test is watertight, so only a ray exactly
/// through an edge can count twice: such a direction is passed over.
fn odd_crossings<'a, I: Iterator<Item = &'a [DVec3; 3]>>(eye: DVec3, corners: impl Fn() -> I) -> bool {
    const DIRECTIONS: u32 = 16;
    (0..DIRECTIONS)
        .find_map(|k| {
            let shear = Shear::of(direction(k));
            corners()
                .filter_map(|c| cross_triangle(c, eye, &shear))
                .try_fold(false, |odd, crossing| (!crossing.on_edge).then_some(!odd))
        })
        .unwrap_or(false)
}

/// One of a fixed list of directions with nothing in common.
fn direction(k: u32) -> DVec3 {
    let [x, y, z, _] = pcg4d([k, 0, 0, 0]).map(|c| f64::from(c) - f64::from(u32::MAX) / 2.0);
    DVec3::new(x, y, z).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parity_survives_a_corner_exactly_in_the_way() {
        // The point of the first direction that the shear maps to exactly (0, 0).
        let d = direction(0).to_array();
        let z = (0..3).max_by(|&i, &j| d[i].abs().total_cmp(&d[j].abs())).unwrap();
        let mut tip = [0.0; 3];
        tip[z] = d[z];
        for i in [(z + 1) % 3, (z + 2) % 3] {
            tip[i] = d[i] / d[z] * d[z];
        }
        let tip = DVec3::from_array(tip);
        let (e1, e2) = tip.normalize().any_orthonormal_pair();
        // Four faces meet at the tip: counted there, they would cancel.
        let [p, q, r, s] = [e1, e2, -e1, -e2].map(|foot| foot - tip * 0.5);
        let pyramid = [[tip, p, q], [tip, q, r], [tip, r, s], [tip, s, p], [p, r, q], [p, s, r]];
        let shear = Shear::of(direction(0));
        let inside = (tip + p + q) / 3.0 * 0.9;
        assert!(pyramid.iter().any(|c| cross_triangle(c, DVec3::ZERO, &shear).is_some_and(|x| x.on_edge)));
        for (eye, expected) in [(DVec3::ZERO, true), (inside, true), (tip * 1.5, false), (-tip, false)] {
            assert_eq!(odd_crossings(eye, || pyramid.iter()), expected, "{eye}");
        }
    }
}

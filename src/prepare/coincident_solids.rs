//! Surfaces of two solids in the same place, where it is undefined which a ray crosses first and so
//! which matter lies between.

use crate::prepare::local_frame::{LocalFrame, PointMap};
use crate::scene::Scene;
use glam::DVec3;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet, HashSet};

/// Where a triangle or a sphere is, in cells of `CELLS` to the local unit: corners, sorted, or centre and
/// radius.
type Place = [[i64; 3]; 3];
/// Cells of 16u, about what a ray's start is moved off a surface: two surfaces in one such cell are
/// crossed at once.
const CELLS: f64 = 1_048_576.0;

/// One sentence for each pair of refracting solids that share a triangle or a sphere. Faces that
/// overlap without being the same triangle are not looked for.
pub fn warnings(scene: &Scene) -> Vec<String> {
    let surfaces = Surfaces::of(scene);
    let solids = surfaces.meshes.iter().chain(&surfaces.spheres).filter(|r| **r).count();
    if solids < 2 {
        return Vec::new();
    }
    // By a hash of their places first, which leaves few to compare.
    let mut keys = surfaces.all(|solid, place| Some((key(&place), solid)));
    keys.par_sort_unstable();
    let shared = |pair: &[(u64, usize)]| pair[0].0 == pair[1].0 && pair[0].1 != pair[1].1;
    let suspects: HashSet<u64> = keys.windows(2).filter(|pair| shared(pair)).map(|pair| pair[0].0).collect();
    drop(keys);
    if suspects.is_empty() {
        return Vec::new();
    }
    let mut owner: BTreeMap<Place, usize> = BTreeMap::new();
    let mut pairs = BTreeSet::new();
    for (place, solid) in
        surfaces.all(|solid, place| suspects.contains(&key(&place)).then_some((place, solid)))
    {
        let first = *owner.entry(place).or_insert(solid);
        if first != solid {
            pairs.insert((first, solid));
        }
    }
    let name = |solid: usize| solid_name(scene, solid);
    pairs
        .into_iter()
        .map(|(a, b)| {
            format!(
                "{} and {} share a surface, and which of the two light enters first is undefined; \
                 let them overlap and give one a higher `priority`, or leave a gap",
                name(a),
                name(b)
            )
        })
        .collect()
}

/// The refracting surfaces of a scene. Solids are numbered meshes first, then spheres.
struct Surfaces<'a> {
    scene: &'a Scene,
    map: PointMap,
    frame: LocalFrame,
    refracts: Vec<bool>,
    /// Meshes, spheres that have such a surface.
    meshes: Vec<bool>,
    spheres: Vec<bool>,
}

impl Surfaces<'_> {
    fn of(scene: &Scene) -> Surfaces<'_> {
        let refracts: Vec<bool> = scene.materials.iter().map(|m| m.refracts()).collect();
        let frame = LocalFrame::of(scene);
        Surfaces {
            scene,
            map: frame.map(),
            frame,
            meshes: scene.meshes.iter().map(|m| m.faces.iter().any(|f| refracts[f.material])).collect(),
            spheres: scene.spheres.iter().map(|s| refracts[s.material]).collect(),
            refracts,
        }
    }

    /// What `take` makes of each, in order.
    fn all<T: Send>(&self, take: impl Fn(usize, Place) -> Option<T> + Sync) -> Vec<T> {
        let mut all = Vec::new();
        for (solid, mesh) in self.scene.meshes.iter().enumerate().filter(|(i, _)| self.meshes[*i]) {
            all.par_extend(mesh.faces.par_iter().filter(|f| self.refracts[f.material]).filter_map(|face| {
                let mut place = face.vertices.map(|v| cells(self.map.point(mesh.vertices[v as usize])));
                place.sort_unstable();
                take(solid, place)
            }));
        }
        let first = self.scene.meshes.len();
        all.extend(self.scene.spheres.iter().enumerate().filter(|(i, _)| self.spheres[*i]).filter_map(
            |(i, s)| {
                let radius = DVec3::splat(self.frame.length(s.radius));
                take(first + i, [cells(self.map.point(s.center)), cells(radius), [i64::MIN; 3]])
            },
        ));
        all
    }
}

fn cells(p: DVec3) -> [i64; 3] {
    (p * CELLS).round().to_array().map(|x| x as i64)
}

/// 64 bits mixed from a place.
fn key(place: &Place) -> u64 {
    // The multiplier of SplitMix64 (Steele, Lea, Flood, OOPSLA 2014).
    let mix = |h: u64, w: &i64| (h ^ *w as u64).wrapping_mul(0xbf58_476d_1ce4_e5b9).rotate_left(29);
    place.as_flattened().iter().fold(0, mix)
}

fn solid_name(scene: &Scene, solid: usize) -> String {
    match scene.meshes.get(solid) {
        Some(mesh) => format!("mesh {} (`{}`)", solid + 1, mesh.name),
        None => {
            let i = solid - scene.meshes.len();
            let material = scene.spheres.get(i).map_or("", |s| &scene.materials[s.material].name);
            format!("sphere {} (`{material}`)", i + 1)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::procedural::shapes::{cuboid, empty, glass, sphere};
    use crate::scene::{Fresnel, Material};

    fn two_blocks(gap: f64) -> Scene {
        let mut s = empty(vec![glass(1.5, Fresnel::Exact), glass(1.33, Fresnel::Exact)]);
        s.meshes = vec![
            cuboid(DVec3::ZERO, DVec3::ONE, 0),
            cuboid(DVec3::new(1.0 + gap, 0.0, 0.0), DVec3::new(2.0, 1.0, 1.0), 1),
        ];
        s
    }

    #[test]
    fn shared_faces_and_spheres_are_named_once_a_pair() {
        let found = warnings(&two_blocks(0.0));
        assert_eq!(found.len(), 1);
        assert!(found[0].starts_with("mesh 1 (`mesh`) and mesh 2 (`mesh`) share a surface"), "{found:?}");
        // Closer than single precision tells apart.
        assert_eq!(warnings(&two_blocks(1e-12)).len(), 1);
        let mut s = two_blocks(1e-3);
        assert_eq!(warnings(&s), Vec::<String>::new());
        s.spheres = vec![sphere([5.0, 0.0, 0.0], 1.0, 0), sphere([5.0, 0.0, 0.0], 1.0, 1)];
        assert!(warnings(&s)[0].starts_with("sphere 1 (`glass`) and sphere 2 (`glass`)"));
    }

    #[test]
    fn opaque_surfaces_may_coincide() {
        let mut s = two_blocks(0.0);
        s.materials[1] = Material { secondary: 0.0, ..s.materials[1].clone() };
        assert_eq!(warnings(&s), Vec::<String>::new());
    }
}

//! Surfaces of two solids in the same place, where it is undefined which a ray crosses first and so
//! which matter lies between.

use crate::frame::LocalFrame;
use crate::scene::Scene;
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};

/// Corners in cells of `CELLS` to the local unit, sorted.
type Place = Vec<[i64; 3]>;
/// Cells of 16u, about what a ray's start is moved off a surface: two surfaces in one such cell are
/// crossed at once.
const CELLS: f64 = 1_048_576.0;

/// One sentence for each pair of refracting solids that share a triangle or a sphere. Faces that
/// overlap without being the same triangle are not looked for.
pub fn warnings(scene: &Scene) -> Vec<String> {
    let frame = LocalFrame::of(scene);
    let mut owner: BTreeMap<Place, usize> = BTreeMap::new();
    let mut pairs = BTreeSet::new();
    for (solid, place) in surfaces(scene, &frame) {
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
                "{} and {} share a surface: what light crosses first there is undefined; \
                 let them overlap and give one a higher `priority`, or leave a gap",
                name(a),
                name(b)
            )
        })
        .collect()
}

/// Solids are numbered meshes first, then spheres.
fn surfaces<'a>(scene: &'a Scene, frame: &'a LocalFrame) -> impl Iterator<Item = (usize, Place)> + 'a {
    let refracts = |material: usize| scene.materials[material].refracts();
    let faces = scene.meshes.iter().enumerate().flat_map(move |(solid, mesh)| {
        mesh.faces.iter().filter(move |f| refracts(f.material)).map(move |face| {
            let mut corners: Place =
                face.vertices.iter().map(|v| place(frame.point(mesh.vertices[*v as usize]))).collect();
            corners.sort_unstable();
            (solid, corners)
        })
    });
    let first = scene.meshes.len();
    let spheres =
        scene.spheres.iter().enumerate().filter(move |(_, s)| refracts(s.material)).map(move |(i, s)| {
            let radius = DVec3::splat(frame.length(s.radius));
            (first + i, vec![place(frame.point(s.center)), place(radius)])
        });
    faces.chain(spheres)
}

fn place(p: DVec3) -> [i64; 3] {
    (p * CELLS).round().to_array().map(|x| x as i64)
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
    use crate::scene::{Fresnel, Material};
    use crate::stress::shapes::{cuboid, empty, glass, sphere};

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

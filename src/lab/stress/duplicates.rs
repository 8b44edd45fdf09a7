//! Coincident triangles and the order of primitives.

use super::case::{Case, Figure, Harness, Random};
use crate::render::RenderError;
use crate::scene::procedural::shapes::{empty, matte, mesh, room};
use crate::scene::{Face, Mesh, Scene};
use glam::DVec3;

/// Cases of this file.
pub const CASES: &[Case] = &[
    Case {
        name: "coincident",
        does: "400 pairs of coincident triangles in two colours, listed in two orders, and 10^5 copies of one triangle, the first in another colour",
        stands_for: "z-fighting that changes with the traversal order; Embree's OverlappingGeometry",
        bound: "exact: at equal t the first primitive in the scene file is visible (numerics.md, Boxes)",
        run: coincident,
    },
    Case {
        name: "order",
        does: "a room with coincident decals, with its objects shuffled, and with its meshes split into one object per face",
        stands_for: "images that change when the same objects are listed in another order",
        bound: "exact: the least t is visible, at equal t the first decal, whatever the order of the rest (numerics.md, Boxes)",
        run: order,
    },
];

/// Shuffles (Fisher, Yates; Durstenfeld 1964).
fn shuffle<T>(items: &mut [T], random: &mut Random) {
    for i in (1..items.len()).rev() {
        items.swap(i, ((i + 1) as f64 * random.unit()) as usize);
    }
}

/// Pairs of coincident triangles all over the view: the first of a pair is green, the second red.
/// `seed` determines their order.
fn decals(seed: u32, count: usize) -> Mesh {
    let mut random = Random::new(11);
    let spot = |r: &mut Random| {
        let c = DVec3::new(r.range(-2.0, 2.0), r.range(-2.0, 2.0), r.range(-1.0, 1.0));
        [c, c + 0.5 * r.direction(), c + 0.5 * r.direction()]
    };
    let mut spots: Vec<[DVec3; 3]> = (0..count).map(|_| spot(&mut random)).collect();
    shuffle(&mut spots, &mut Random::new(seed));
    // All first copies, then all second copies in another order, so that a hierarchy may store a
    // second copy before its first.
    let first: Vec<u32> = (0..count as u32).collect();
    let mut second = first.clone();
    shuffle(&mut second, &mut Random::new(seed + 100));
    let faces: Vec<[u32; 3]> =
        [first, second].concat().iter().map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let mut m = mesh(spots.into_iter().flatten().collect(), &faces, 0);
    m.faces.iter_mut().skip(count).for_each(|f| f.material = 1);
    m
}

fn colours() -> Scene {
    let mut scene = empty(vec![matte([0.0, 1.0, 0.0], 1.0), matte([1.0, 0.0, 0.0], 1.0)]);
    scene.camera.fov = 0.7;
    scene
}

/// Many copies of one triangle. Only the first is green.
fn pile(copies: usize) -> Scene {
    let mut scene = colours();
    let corners = vec![DVec3::new(-1.5, -1.0, 0.3), DVec3::new(1.4, -1.2, -0.4), DVec3::new(0.1, 1.6, 0.2)];
    let mut m = mesh(corners, &vec![[0, 1, 2]; copies], 1);
    m.faces[0].material = 0;
    scene.meshes = vec![m];
    scene.camera.width = 16;
    scene.camera.height = 16;
    scene
}

fn coincident(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let (mut wrong, mut seen) = (0, 0);
    let mut add = |h: &mut Harness<'_>, scene: &Scene| {
        let picture = h.picture(scene)?;
        wrong += picture.linear.iter().filter(|p| p[0] > 0.0).count();
        wrong += (picture.counters.stack_overflow + picture.counters.loop_cap) as usize;
        seen += picture.linear.iter().filter(|p| p[0] + p[1] > 0.0).count();
        Ok::<(), RenderError>(())
    };
    for seed in 20..22 {
        let mut scene = colours();
        scene.meshes = vec![decals(seed, 400)];
        add(h, &scene)?;
    }
    for copies in [33, 100_000] {
        add(h, &pile(copies))?;
    }
    Ok(Figure::count(wrong, seen, "pixels show a later copy, or overflowed"))
}

/// One object per face.
fn split(m: &Mesh) -> Vec<Mesh> {
    m.faces.iter().map(|f| Mesh { faces: vec![*f], ..m.clone() }).collect()
}

fn order(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let mut scene = room();
    // Off the axis, where the room's edges would pass through pixel centres and either wall would
    // be right.
    scene.camera.look_from = DVec3::new(0.13, 0.07, 14.0);
    let decals = decals(30, 120);
    // Pairs as objects of their own: the first green, the second red.
    let copy = |i: usize, material: usize| Face { material, ..decals.faces[i] };
    let pairs: Vec<Mesh> =
        (0..120).map(|i| Mesh { faces: vec![copy(i, 1), copy(i, 0)], ..decals.clone() }).collect();
    let boxes = std::mem::take(&mut scene.meshes);
    scene.meshes = [boxes.clone(), pairs.clone()].concat();
    let reference = h.picture(&scene)?.linear;
    let mut different = 0;
    for seed in 40..43 {
        let mut random = Random::new(seed);
        let mut other = scene.clone();
        other.meshes = [boxes.iter().flat_map(split).collect(), pairs.clone()].concat();
        shuffle(&mut other.meshes, &mut random);
        shuffle(&mut other.polygons, &mut random);
        shuffle(&mut other.spheres, &mut random);
        let picture = h.picture(&other)?.linear;
        different += picture.iter().zip(&reference).filter(|(a, b)| a != b).count();
    }
    Ok(Figure::count(different, 3 * reference.len(), "pixels differ"))
}

//! Walks that take more steps than one dispatch may: each ray meets tens of thousands of boxes.

use super::case::{Case, Figure, Harness, Random};
use super::hierarchy::differences;
use crate::lab::probe::ProbeRay;
use crate::render::RenderError;
use crate::scene::Scene;
use crate::scene::procedural::shapes::{empty, light, matte, mesh, polygon};
use glam::DVec3;

/// Cases of this file.
pub const CASES: &[Case] = &[
    Case {
        name: "needles",
        does: "a bundle of 70,000 hair-thin triangles; rays along it, across it and out of it: brute force against the hierarchy",
        stands_for: "hair: traversals that a cap on steps ends, on lavapipe silently",
        bound: "exact in id, t, weights and position, whatever a walk takes (numerics.md, Boxes)",
        run: needles,
    },
    Case {
        name: "overlapping-boxes",
        does: "70,000 triangles along the diagonals of one cube, so that every box is most of it; rays anywhere: brute force against the hierarchy",
        stands_for: "hierarchies that cull nothing",
        bound: "exact in id, t, weights and position, whatever a walk takes (numerics.md, Boxes)",
        run: overlapping_boxes,
    },
    Case {
        name: "fan",
        does: "one polygon of 200,000 corners; rays at its first corner, at all of it, and in its plane: brute force against the hierarchy",
        stands_for: "CAD faces fanned from one corner, which lose pixels",
        bound: "exact in id, t, weights and position, whatever a walk takes (numerics.md, Boxes)",
        run: fan,
    },
    Case {
        name: "stacked-triangles",
        does: "70,000 triangles in one plane, over each other but for the last bits of a corner; rays at them from both sides: brute force against the hierarchy",
        stands_for: "objects that were pasted many times, which lose hits or show another copy",
        bound: "exact in id, t, weights and position: at equal t the first in the scene file is hit (numerics.md, Boxes)",
        run: stacked_triangles,
    },
    Case {
        name: "hair-and-lights",
        does: "a floor below an upright bundle of 12,000 hair-thin triangles under 20 lights: brute force against the hierarchy",
        stands_for: "a cap on steps that all lights of a pass share: shadows that vanish where lights are many",
        bound: "exact: the same picture, and no ray is given up (numerics.md, Boxes)",
        run: hair_and_lights,
    },
];

fn triangles(corners: Vec<DVec3>) -> Scene {
    let mut scene = empty(vec![matte([1.0; 3], 1.0)]);
    let faces: Vec<[u32; 3]> = (0..corners.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    scene.meshes = vec![mesh(corners, &faces, 0)];
    scene
}

/// Hair-thin triangles along y, from -1 to 1, within `spread` of the axis.
fn bundle(count: usize, spread: f64, stream: u32) -> Vec<DVec3> {
    let mut r = Random::new(stream);
    let hair = |_| {
        let (x, z) = (r.range(-spread, spread), r.range(-spread, spread));
        let root = DVec3::new(x, -1.0, z);
        let tip = root + DVec3::new(r.range(-0.1, 0.1) * spread, 2.0, r.range(-0.1, 0.1) * spread);
        [root, tip, tip + DVec3::new(2e-4, 0.0, 1e-4)]
    };
    (0..count).flat_map(hair).collect()
}

/// Steps of a dispatch in a second run, in which every form of walk goes on many times.
const FEW: u32 = 1000;

/// Brute force against the hierarchy on rays of the world.
fn compare(h: &mut Harness<'_>, scene: &Scene, rays: &[[DVec3; 2]]) -> Result<Figure, RenderError> {
    let rays: Vec<ProbeRay> = rays
        .iter()
        .map(|[from, at]| {
            let [from, at] = [*from, *at].map(|p| h.local(scene, p));
            ProbeRay::new(from, h.round((at - from).normalize()))
        })
        .collect();
    let [brute, hierarchy] = h.probe_both(scene, &rays)?;
    let hits = brute.hits.iter().flatten().count();
    let parts = h.probe_in_parts(scene, &rays, FEW)?;
    let wrong = differences(&brute, &hierarchy) + differences(&brute, &parts);
    let wrong = wrong + usize::from(hits < rays.len() / 16);
    Ok(Figure::count(wrong, rays.len(), "rays differ from brute force"))
}

fn needles(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let scene = triangles(bundle(70_000, 0.2, 200));
    let mut r = Random::new(201);
    let spot = |r: &mut Random, y: f64| DVec3::new(r.range(-0.19, 0.19), y, r.range(-0.19, 0.19));
    let rays: Vec<[DVec3; 2]> = (0..96)
        .map(|i| match i % 3 {
            0 => [spot(&mut r, 3.0), spot(&mut r, -1.0)],
            1 => [spot(&mut r, -0.99), spot(&mut r, 1.0)],
            _ => [r.direction() * 2.0, spot(&mut r, 0.3)],
        })
        .collect();
    compare(h, &scene, &rays)
}

fn overlapping_boxes(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let mut r = Random::new(202);
    let diagonal = |i: usize| {
        let corner =
            DVec3::new(if i & 1 == 0 { 1.0 } else { -1.0 }, if i & 2 == 0 { 1.0 } else { -1.0 }, 1.0);
        let (from, to) = (-corner + r.direction() * 0.3, corner + r.direction() * 0.3);
        [from, to, to + r.direction() * 1e-4]
    };
    let scene = triangles((0..70_000).flat_map(diagonal).collect());
    let mut r = Random::new(203);
    let rays: Vec<[DVec3; 2]> =
        (0..96).map(|i| [r.direction() * 2.0, r.direction() * if i % 2 == 0 { 0.1 } else { 0.7 }]).collect();
    compare(h, &scene, &rays)
}

fn fan(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let corner = |i: u32| {
        let a = f64::from(i) / 200_000.0 * std::f64::consts::TAU;
        DVec3::new(a.cos(), 0.6 * a.sin() + 0.1 * a.cos(), 0.8 * a.sin())
    };
    let corners: Vec<[f64; 3]> = (0..200_000).map(|i| corner(i).to_array()).collect();
    let mut scene = empty(vec![matte([1.0; 3], 1.0)]);
    scene.polygons = vec![polygon(&corners, 0)];
    let mut r = Random::new(204);
    let first = corner(0);
    let rays: Vec<[DVec3; 2]> = (0..48)
        .map(|i| {
            let on = corner((r.unit() * 200_000.0) as u32);
            match i % 3 {
                // Close to the corner that all triangles share.
                0 => [DVec3::new(1.0, 2.0, -3.0) + r.direction(), first + (on - first) * r.range(1e-4, 1e-2)],
                1 => [DVec3::new(1.0, 2.0, -3.0) + r.direction(), first + (on - first) * r.unit()],
                // From beyond a corner through the first, all but in the plane.
                _ => [on * 1.5 + DVec3::Z * 1e-3, first + r.direction() * 1e-3],
            }
        })
        .collect();
    compare(h, &scene, &rays)
}

fn stacked_triangles(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    // No two have the same corners: of such the host keeps a few.
    let [a, b, c] = [DVec3::new(-1.0, -0.7, 0.1), DVec3::new(1.1, -0.5, -0.2), DVec3::new(0.1, 1.2, 0.4)];
    let copy = |i: u32| [a, b + (b - a) * (f64::from(i) * 2e-7), c];
    let scene = triangles((0..70_000).flat_map(copy).collect());
    let mut r = Random::new(205);
    let rays: Vec<[DVec3; 2]> = (0..64).map(|_| [r.direction() * 3.0, r.direction() * 0.5]).collect();
    compare(h, &scene, &rays)
}

fn hair_and_lights(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let mut scene = triangles(bundle(12_000, 0.2, 206));
    scene.materials[0] = matte([0.8; 3], 0.1);
    let s = 0.25;
    scene.polygons = vec![polygon(&[[-s, -1.1, s], [s, -1.1, s], [s, -1.1, -s], [-s, -1.1, -s]], 0)];
    let mut r = Random::new(207);
    scene.lights =
        (0..20).map(|_| light([r.range(-0.3, 0.3), r.range(3.0, 4.0), r.range(-0.3, 0.3)], 1.0)).collect();
    // From below the hair, at the floor.
    (scene.camera.look_from, scene.camera.look_at) =
        (DVec3::new(0.9, -0.75, 0.0), DVec3::new(0.0, -1.1, 0.0));
    scene.camera.fov = 0.15;
    (scene.camera.width, scene.camera.height) = (12, 4);
    scene.render.depth = 1;
    let [brute, hierarchy] = h.picture_both(&scene)?;
    let parts = h.picture_in_parts(&scene, FEW)?;
    let lost = |c: &crate::report::Counters| (c.loop_cap + c.stack_overflow) as usize;
    let differs = |other: &[[f32; 3]]| brute.linear.iter().zip(other).filter(|(a, b)| a != b).count();
    let wrong = differs(&hierarchy.linear) + differs(&parts.linear);
    let given_up = lost(&brute.counters) + lost(&hierarchy.counters) + lost(&parts.counters);
    let lit = hierarchy.rays.shadow as usize;
    let wrong = wrong + given_up + usize::from(lit < 20 * 12);
    Ok(Figure::count(wrong, brute.linear.len(), "pixels differ from brute force"))
}

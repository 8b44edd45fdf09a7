//! Ray/triangle: no holes, no specks, no false hits.

use super::case::{Case, Figure, Harness, Random};
use super::shapes::{empty, matte, mesh};
use crate::defect::Defect;
use crate::probe::ProbeRay;
use crate::render::RenderError;
use crate::scene::Scene;
use glam::DVec3;

/// Cases of this file.
pub const CASES: &[Case] = &[Case {
    name: "watertight",
    does: "a closed mesh of 16x16 quads with vertices at radius 1 + 5 xi, hit from inside at random, at vertices, at edges",
    stands_for: "light through the seams of closed meshes: pbrt's watertightness test, Embree issues 181 and 381",
    bound: "exact: neighbours compute an edge with the same roundings (Woop, Benthin, Wald 2013)",
    guards: &[Defect::MoellerTrumbore],
    run: watertight,
}];

/// A sphere of `n` x `n` quads whose vertices lie at radius 1 + `rough` * xi.
fn rough_sphere(n: usize, rough: f64) -> Scene {
    let mut random = Random::new(1);
    let mut vertices = Vec::new();
    for i in 0..=n {
        for j in 0..n {
            // Poles and the seam share their vertices, so the mesh is closed.
            let theta = std::f64::consts::PI * i as f64 / n as f64;
            let phi = 2.0 * std::f64::consts::PI * j as f64 / n as f64;
            let d = DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
            vertices.push(d * (1.0 + rough * random.unit()));
        }
    }
    let at = |i: usize, j: usize| {
        let j = if i == 0 || i == n { 0 } else { j % n };
        (i * n + j) as u32
    };
    let mut faces = Vec::new();
    for i in 0..n {
        for j in 0..n {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            faces.extend(
                [[a, b, c], [a, c, d]].into_iter().filter(|f| f[0] != f[1] && f[1] != f[2] && f[0] != f[2]),
            );
        }
    }
    let mut scene = empty(vec![matte([1.0; 3], 1.0)]);
    scene.meshes = vec![mesh(vertices, &faces, 0)];
    scene
}

fn watertight(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let scene = rough_sphere(16, 5.0);
    let mut random = Random::new(2);
    let frame = h.frame(&scene);
    let m = &scene.meshes[0];
    let vertex = |i: u32| h.local(&scene, m.vertices[i as usize]);
    let mut rays = Vec::new();
    for i in 0..90_000 {
        // Well inside: the mesh never comes nearer to its centre than radius 1.
        let origin = h.round(frame.point(random.direction() * 0.5));
        let face = m.faces[(random.unit() * m.faces.len() as f64) as usize].vertices;
        let target = match i % 3 {
            0 => origin + random.direction(),
            1 => vertex(face[0]),
            _ => {
                let s = random.unit();
                vertex(face[0]) * s + vertex(face[1]) * (1.0 - s)
            }
        };
        rays.push(ProbeRay::new(origin, h.round(target - origin)));
    }
    let hits = h.probe(&scene, &rays)?.hits;
    Ok(Figure::none(hits.iter().filter(|h| h.is_none()).count(), format!("misses of {} rays", rays.len())))
}

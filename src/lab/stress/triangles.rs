//! Ray-triangle intersection: no light leaks through closed surfaces.

use super::case::{Case, Figure, Harness, Random};
use super::exact::{Corners, local_triangles};
use crate::lab::probe::ProbeRay;
use crate::render::RenderError;
use crate::scene::procedural::shapes::{empty, matte, mesh, polygon};
use crate::scene::{Mesh, Scene};
use glam::DVec3;

/// Cases of this file.
pub const CASES: &[Case] = &[
    Case {
        name: "watertight",
        does: "a closed mesh of 16x16 quads with vertices at random radii from 1 to 6, hit from inside at random, at vertices and at edges",
        stands_for: "light leaks through the edges of closed meshes: pbrt's watertightness test, Embree issues 181 and 381",
        bound: "exact: neighbouring triangles compute their common edge with the same roundings (Woop, Benthin, Wald 2013)",
        run: watertight,
    },
    Case {
        name: "far-watertight",
        does: "tessellated spheres of 50 and 200 segments and a 12x12 plane at (148376, 1234, -223423), hit at random, at vertices and at edges",
        stands_for: "Embree's WatertightTest, which allows 2e-5 of the rays to leak",
        bound: "exact, as for `watertight`, at any position",
        run: far_watertight,
    },
    Case {
        name: "seams",
        does: "a rotated box of 2 x 2 x h, h = 1, 1e-3, 1e-5, of long thin polygons and single-quad meshes that share positions only, hit from inside",
        stands_for: "light leaks where separate objects meet, and between thin strips",
        bound: "exact: equal positions round to equal vertices, so the box stays closed",
        run: seams,
    },
    Case {
        name: "flat-boxes",
        does: "flat, axis-aligned grids, hit at vertices and edges from 1 to 10^4 radii away",
        stands_for: "false misses of the slab test for flat boxes: Ize 2013, tinybvh 286, Embree PR 589",
        bound: "exact: the box test includes its error of 14u (numerics.md, Boxes), the triangle test is watertight",
        run: flat_boxes,
    },
];

/// A closed mesh of `n` x `n` quads with vertices at `radius` + `rough` * xi around `center`.
fn ball(n: usize, center: DVec3, radius: f64, rough: f64) -> Mesh {
    let mut random = Random::new(1);
    let mut vertices = Vec::new();
    for i in 0..=n {
        for j in 0..n {
            // Poles and the seam share their vertices, so the mesh is closed.
            let theta = std::f64::consts::PI * i as f64 / n as f64;
            let phi = 2.0 * std::f64::consts::PI * j as f64 / n as f64;
            let d = DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
            vertices.push(center + d * (radius + rough * random.unit()));
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
    mesh(vertices, &faces, 0)
}

/// A flat sheet of `n` x `n` quads, corner `at`, sides `x` and `y`.
fn sheet(n: usize, at: DVec3, x: DVec3, y: DVec3) -> Mesh {
    let mut vertices = Vec::new();
    for i in 0..=n {
        for j in 0..=n {
            vertices.push(at + x * (i as f64 / n as f64) + y * (j as f64 / n as f64));
        }
    }
    let id = |i: usize, j: usize| (i * (n + 1) + j) as u32;
    let mut faces = Vec::new();
    for i in 0..n {
        for j in 0..n {
            let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
            faces.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh(vertices, &faces, 0)
}

fn of_meshes(meshes: Vec<Mesh>) -> Scene {
    let mut scene = empty(vec![matte([1.0; 3], 1.0)]);
    scene.meshes = meshes;
    scene
}

/// A vertex, or a point of an edge.
fn seam_point(triangles: &[Corners], random: &mut Random, vertex: bool) -> DVec3 {
    let corners = triangles[(random.unit() * triangles.len() as f64) as usize];
    let first = (random.unit() * 3.0) as usize;
    let s = if vertex { 1.0 } else { random.unit() };
    corners[first] * s + corners[(first + 1) % 3] * (1.0 - s)
}

fn count_misses(h: &mut Harness<'_>, scene: &Scene, rays: &[ProbeRay]) -> Result<Figure, RenderError> {
    let hits = h.probe(scene, rays)?.hits;
    Ok(Figure::count(hits.iter().filter(|h| h.is_none()).count(), rays.len(), "rays missed"))
}

/// The sum of counts that must all be zero.
fn total(parts: Vec<Figure>, of: usize) -> Figure {
    Figure::count(parts.iter().map(|f| f.value as usize).sum(), of, "rays missed")
}

fn watertight(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let scene = of_meshes(vec![ball(16, DVec3::ZERO, 1.0, 5.0)]);
    let mut random = Random::new(2);
    let (frame, local) = (h.local_frame(&scene), local_triangles(h, &scene));
    let mut rays = Vec::new();
    for i in 0..90_000 {
        // Well inside: the mesh is nowhere closer to its centre than 1.
        let origin = h.round(frame.point(random.direction() * 0.5));
        let target = match i % 3 {
            0 => origin + random.direction(),
            k => seam_point(&local, &mut random, k == 1),
        };
        rays.push(ProbeRay::new(origin, h.round(target - origin)));
    }
    count_misses(h, &scene, &rays)
}

fn far_watertight(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let place = DVec3::new(148_376.0, 1234.0, -223_423.0);
    let plane = sheet(
        50,
        place + DVec3::new(3.0, -6.0, -6.0),
        DVec3::new(0.0, 12.0, 0.0),
        DVec3::new(0.0, 0.0, 12.0),
    );
    let scenes = [ball(50, place, 2.0, 0.0), ball(200, place, 2.0, 0.0), plane].map(|m| of_meshes(vec![m]));
    let (mut parts, mut count) = (Vec::new(), 0);
    for (which, scene) in scenes.iter().enumerate() {
        let mut random = Random::new(3);
        let (frame, local) = (h.local_frame(scene), local_triangles(h, scene));
        let mut rays = Vec::new();
        for i in 0..24_000 {
            let cube =
                |r: &mut Random| DVec3::new(r.range(-1.0, 1.0), r.range(-1.0, 1.0), r.range(-1.0, 1.0));
            let origin = h.round(frame.point(place + cube(&mut random)));
            let mut way = cube(&mut random);
            if which == 2 {
                way.x = 1.0;
            }
            let mut target = origin + way;
            if i % 3 > 0 {
                target = seam_point(&local, &mut random, i % 3 == 1);
                // The rim of the plane is open: a ray aimed at it may pass outside.
                let rim = |p: DVec3| which == 2 && (p.y.abs() > 0.3 || p.z.abs() > 0.3);
                while rim(target) {
                    target = seam_point(&local, &mut random, i % 3 == 1);
                }
            }
            rays.push(ProbeRay::new(origin, h.round(target - origin)));
        }
        count += rays.len();
        parts.push(count_misses(h, scene, &rays)?);
    }
    Ok(total(parts, count))
}

/// A point of the unit box, stretched to 2 x 2 x `height` and rotated.
fn turned(p: DVec3, height: f64) -> DVec3 {
    let q = DVec3::new(2.0 * p.x - 1.0, 2.0 * p.y - 1.0, height * (p.z - 0.5));
    let q = DVec3::new(0.6 * q.x - 0.8 * q.y, 0.8 * q.x + 0.6 * q.y, q.z);
    DVec3::new(0.28 * q.x - 0.96 * q.z, q.y, 0.96 * q.x + 0.28 * q.z)
}

/// The surface of the box as strips along y, each a separate object.
fn strips(height: f64, count: usize) -> Scene {
    let mut scene = of_meshes(Vec::new());
    let mut random = Random::new(5);
    let mut cuts: Vec<f64> = (1..count).map(|_| random.unit()).collect();
    cuts.extend([0.0, 1.0]);
    cuts.sort_by(f64::total_cmp);
    let quad = |p: [[f64; 3]; 4]| p.map(|p| turned(DVec3::from(p), height));
    let mut quads = Vec::new();
    for w in cuts.windows(2) {
        let (x0, x1) = (w[0], w[1]);
        for s in [0.0, 1.0] {
            quads.push(quad([[x0, 0.0, s], [x1, 0.0, s], [x1, 1.0, s], [x0, 1.0, s]]));
            quads.push(quad([[x0, s, 0.0], [x1, s, 0.0], [x1, s, 1.0], [x0, s, 1.0]]));
        }
    }
    for s in [0.0, 1.0] {
        quads.push(quad([[s, 0.0, 0.0], [s, 1.0, 0.0], [s, 1.0, 1.0], [s, 0.0, 1.0]]));
    }
    for (i, q) in quads.into_iter().enumerate() {
        if i % 2 == 0 {
            scene.polygons.push(polygon(&q.map(|v| v.to_array()), 0));
        } else {
            scene.meshes.push(mesh(q.to_vec(), &[[0, 1, 2], [0, 2, 3]], 0));
        }
    }
    scene
}

fn seams(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let (mut parts, mut count) = (Vec::new(), 0);
    for height in [1.0, 1e-3, 1e-5] {
        let scene = strips(height, 24);
        let mut random = Random::new(6);
        let local = local_triangles(h, &scene);
        let mut rays = Vec::new();
        for i in 0..24_000 {
            let p = |r: &mut Random| DVec3::new(r.range(0.2, 0.8), r.range(0.2, 0.8), r.range(0.3, 0.7));
            let origin = h.local(&scene, turned(p(&mut random), height));
            let target = match i % 4 {
                0 => origin + random.direction(),
                // Between the sheets, nearly in their plane.
                1 => h.local(&scene, turned(p(&mut random), height)),
                k => seam_point(&local, &mut random, k == 2),
            };
            rays.push(ProbeRay::new(origin, h.round(target - origin)));
        }
        count += rays.len();
        parts.push(count_misses(h, &scene, &rays)?);
    }
    Ok(total(parts, count))
}

fn flat_boxes(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let (mut parts, mut count) = (Vec::new(), 0);
    for axis in 0..3 {
        let pick = |i: usize| DVec3::AXES[(axis + i) % 3];
        let scene = of_meshes(vec![sheet(12, -pick(1) - pick(2), 2.0 * pick(1), 2.0 * pick(2))]);
        let mut random = Random::new(7);
        let local = local_triangles(h, &scene);
        let mut rays = Vec::new();
        for i in 0..16_000 {
            let mut target = seam_point(&local, &mut random, i % 2 == 0);
            // The rim is open, and the rounding of a distant ray may carry it past.
            while target.abs().max_element() > 0.3 {
                target = seam_point(&local, &mut random, i % 2 == 0);
            }
            let mut way = random.direction();
            while way[axis].abs() < 0.1 {
                way = random.direction();
            }
            let origin = h.round(target + way * [1.0, 30.0, 1e3, 1e4][i / 2 % 4]);
            rays.push(ProbeRay::new(origin, h.round(target - origin)));
        }
        count += rays.len();
        parts.push(count_misses(h, &scene, &rays)?);
    }
    Ok(total(parts, count))
}

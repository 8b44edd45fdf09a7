//! Extreme triangles: tiny, thin, edge-on, without area, distant, huge.

use super::case::{Case, Figure, Harness, Random};
use super::exact::{Verdict, inclusive, local_triangles, verdict};
use crate::lab::probe::ProbeRay;
use crate::render::RenderError;
use crate::scene::Scene;
use crate::scene::procedural::shapes::{cuboid, empty, matte, mesh, moved, room};
use glam::DVec3;

/// Cases of this file.
pub const CASES: &[Case] = &[
    Case {
        name: "tiny-triangles",
        does: "triangles with legs of 2e-4, 1e-10 and 1e-18 alone at distance 1, with legs of 2^-12 to 2^-60 in the middle of a unit scene, and rotated ones of 2^-15 all over it",
        stands_for: "a determinant epsilon that loses small triangles: tinybvh PR 283",
        bound: "no miss where the ray is inside by more than Woop's roundings, 26u of the coordinates; t within 4u along an axis, where only t rounds (numerics.md, Triangles)",
        run: |h| Ok(tiny_triangle(h)?.worse(tiny_in_scene(h)?)),
    },
    Case {
        name: "slivers",
        does: "triangles of length 1 and height 1e-3, 1e-4, 1e-5 in all orientations",
        stands_for: "lost or misplaced hits on slivers, and noisy normals",
        bound: "no miss; relative error of t within 64u/h (weights have an error of u/h, numerics.md, Triangles); stored normal within 4u of f64",
        run: slivers,
    },
    Case {
        name: "no-area",
        does: "pbrt's BadCase triangle, and 500 triangles with three collinear vertices",
        stands_for: "pbrt's Triangle.BadCases: hits on a triangle without area",
        bound: "exact: ignored and counted, never hit (numerics.md, Triangles)",
        run: no_area,
    },
    Case {
        name: "in-plane",
        does: "rays in a triangle's plane and along its edges; rays along the faces and edges of a cube",
        stands_for: "NaN and false hits at zero determinants; -0 in the wrong octant (tinybvh 282)",
        bound: "exact, since small dyadic numbers do not round: the triangle is missed, the side of the cube is hit at its t",
        run: in_plane,
    },
    Case {
        name: "hit-point",
        does: "a unit triangle at (98304.7531, -50000.2718, 70000.5772), hit by 256 rays from distance 1",
        stands_for: "Embree's TriangleHit",
        bound: "weights, t and hit point within 16 ulp, normal exact (numerics.md, Triangles)",
        run: hit_point,
    },
    Case {
        name: "huge-coordinates",
        does: "the room scaled by 10^12, 10^18, 10^20, 10^30, 10^150, 10^-30 and 10^-150, compared with the same numbers times a power of two",
        stands_for: "overflow: Woop's test returns t = NaN for coordinates of 1e19 in f32",
        bound: "exact: the same image, finite, with all counters zero (numerics.md, Triangles)",
        run: huge_coordinates,
    },
];

fn one_mesh(vertices: Vec<DVec3>, faces: &[[u32; 3]]) -> Scene {
    let mut scene = empty(vec![matte([1.0; 3], 1.0)]);
    scene.meshes = vec![mesh(vertices, faces, 0)];
    scene
}

/// Separate triangles.
fn soup(triangles: &[[DVec3; 3]]) -> Scene {
    let faces: Vec<[u32; 3]> = (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    one_mesh(triangles.concat(), &faces)
}

/// Two triangles that make the local frame equal to the world: the scene's box is [-0.5, 0.5]^3.
fn frame_keepers() -> [[DVec3; 3]; 2] {
    [-0.5, 0.5].map(|s| {
        let p = DVec3::splat(s);
        [p, p - DVec3::X * s / 64.0, p - DVec3::Y * s / 64.0]
    })
}

fn tiny_triangle(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let mut worst = Figure::new(0.0, 4.0 * h.u(), "relative error of t");
    for s in [2e-4, 1e-10, 1e-18] {
        let scene = one_mesh(vec![DVec3::ZERO, DVec3::X * s, DVec3::Y * s], &[[0, 1, 2]]);
        let frame = h.local_frame(&scene);
        let origin = h.local(&scene, DVec3::new(s / 3.0, s / 3.0, -1.0));
        let hit = h.probe(&scene, &[ProbeRay::new(origin, DVec3::Z)])?.hits[0];
        let t = hit.map_or(f64::NAN, |h| h.t);
        let expected = frame.point(DVec3::ZERO).z - origin.z;
        let error = (t / expected - 1.0).abs();
        let error = if error.is_nan() { f64::INFINITY } else { error };
        worst = worst.worse(Figure::new(error, 4.0 * h.u(), format!("relative error of t, legs {s:e}")));
    }
    Ok(worst)
}

fn tiny_in_scene(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let u = h.u();
    let (mut missed, mut sure) = (0, 0);
    // In the middle, where numbers are densest: a ray along an axis is not rounded.
    for k in [12, 20, 33, 47, 60] {
        let s = 2f64.powi(-k);
        let mut triangles = vec![[DVec3::ZERO, DVec3::X * s, DVec3::Y * s]];
        triangles.extend(frame_keepers());
        let scene = soup(&triangles);
        for z in [-0.5, -0.125, 0.375] {
            let o = h.round(DVec3::new(s / 3.0, s / 3.0, z));
            let hit = h.probe(&scene, &[ProbeRay::new(o, DVec3::Z * -z.signum())])?.hits[0];
            let good = hit.is_some_and(|hit| hit.id == 0 && (hit.t / z.abs() - 1.0).abs() <= 4.0 * u);
            missed += usize::from(!good);
            sure += 1;
        }
    }
    let mut random = Random::new(50);
    let mut triangles = frame_keepers().to_vec();
    for _ in 0..400 {
        let c = DVec3::new(random.range(-0.45, 0.45), random.range(-0.45, 0.45), random.range(-0.45, 0.45));
        triangles.push([c; 3].map(|c| c + 2f64.powi(-15) * random.direction()));
    }
    let scene = soup(&triangles);
    let local = local_triangles(h, &scene);
    let mut rays = Vec::new();
    for i in 0..20_000 {
        let [a, b, c] = local[2 + i % 400];
        let origin = h.round(random.direction() * random.range(0.0, 0.9));
        rays.push((2 + i % 400, ProbeRay::new(origin, h.round((a + b + c) / 3.0 - origin))));
    }
    let batch: Vec<ProbeRay> = rays.iter().map(|r| r.1).collect();
    for ((id, ray), hit) in rays.iter().zip(h.probe(&scene, &batch)?.hits) {
        let Verdict::Hit(t) = verdict(&local[*id], ray.origin, ray.direction, u) else { continue };
        sure += 1;
        // A hit in front of it is allowed, a hit behind it is not.
        let along = |p: &DVec3| (*p - ray.origin).dot(ray.direction) / ray.direction.length_squared();
        let ends = local[*id].iter().map(along);
        let far = ends.fold(t, f64::max) * (1.0 + 16.0 * u) + 16.0 * u;
        missed += usize::from(!hit.is_some_and(|hit| hit.t <= far && (hit.id == *id as u32 || hit.t <= t)));
    }
    let enough = sure > 5_000;
    Ok(Figure::count(missed + usize::from(!enough), sure, "certain hits missed"))
}

fn slivers(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let u = h.u();
    let mut worst = Figure::new(0.0, 0.0, "");
    for height in [1e-3, 1e-4, 1e-5] {
        let mut random = Random::new(60);
        let count = 40;
        let triangles: Vec<[DVec3; 3]> = (0..count)
            .map(|_| {
                let a = random.direction() * 0.3;
                let along = random.direction();
                let side = along.cross(random.direction()).normalize() * height;
                [a, a + along, a + along * random.range(0.2, 0.8) + side]
            })
            .collect();
        let scene = soup(&triangles);
        let local = local_triangles(h, &scene);
        let mut rays = Vec::new();
        for i in 0..8_000 {
            let [a, b, c] = local[i % count];
            let (v, w) = (random.range(0.2, 0.4), random.range(0.2, 0.4));
            let target = a + v * (b - a) + w * (c - a);
            let n = (b - a).cross(c - a).normalize();
            let mut way = random.direction();
            while way.dot(n).abs() < 0.3 {
                way = random.direction();
            }
            let origin = h.round(target + way * random.range(0.2, 1.0));
            rays.push(ProbeRay::new(origin, h.round(target - origin)));
        }
        let hits = h.probe(&scene, &rays)?.hits;
        let (mut missed, mut sure) = (0, 0);
        let (mut t_error, mut normal_error) = (0f64, 0f64);
        for (i, (ray, hit)) in rays.iter().zip(hits).enumerate() {
            let Verdict::Hit(t) = verdict(&local[i % count], ray.origin, ray.direction, u) else { continue };
            sure += 1;
            let Some(hit) = hit else {
                missed += 1;
                continue;
            };
            let [a, b, c] = local[hit.id as usize];
            let n = (b - a).cross(c - a).normalize();
            normal_error = normal_error.max((hit.normal - n * n.dot(hit.normal).signum()).length());
            if hit.id as usize == i % count {
                t_error = t_error.max((hit.t / t - 1.0).abs());
            } else {
                missed += usize::from(hit.t > t * (1.0 + 64.0 * u / height));
            }
        }
        let few = usize::from(sure < 1_000);
        worst = worst
            .worse(Figure::count(missed + few, sure, &format!("certain hits missed, height {height:e}")))
            .worse(Figure::new(
                t_error,
                64.0 * (u + 2f64.powi(-53)) / height,
                format!("relative error of t, height {height:e}"),
            ))
            .worse(Figure::new(
                normal_error,
                4.0 * u + 8.0 * 2f64.powi(-53) / height,
                format!("error of the normal, height {height:e}"),
            ));
    }
    Ok(worst)
}

fn no_area(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let (x, z) = (-1113.45459, -56.2431908);
    // The numbers of pbrt's test.
    let bad = [-79.049614, -87.0922699, -79.2090149].map(|y| DVec3::new(x, y, z).as_vec3().as_dvec3());
    let mut triangles = vec![bad];
    let alone = soup(&triangles);
    let ray = |h: &Harness<'_>, scene: &Scene| {
        let o = DVec3::new(-1081.47925, 99.9999542, 87.7701111);
        let d = DVec3::new(-32.1072998, -183.355865, -144.607635);
        let scale = h.local_frame(scene).length(1.0);
        ProbeRay::new(h.local(scene, o), h.round(d * scale))
    };
    let rays = [ray(h, &alone)];
    let mut wrong = h.probe(&alone, &rays)?.hits.iter().flatten().count();
    wrong += usize::from(h.picture(&alone)?.counters.degenerate_triangles != 1);
    // Multiples of 1/16, so that the vertices stay collinear in the local frame.
    triangles = frame_keepers().to_vec();
    let mut random = Random::new(70);
    let mut rays = Vec::new();
    let grid =
        |r: &mut Random, n: f64| (DVec3::new(r.range(-n, n), r.range(-n, n), r.range(-n, n))).round() / 64.0;
    for i in 0..500 {
        let (a, step) = (grid(&mut random, 10.0), grid(&mut random, 3.0));
        // Two or three vertices may coincide.
        let k = [[0.0, 1.0, 2.0], [0.0, 3.0, 1.0], [1.0, 0.0, 0.0], [2.0, 2.0, 0.0]][i % 4];
        triangles.push(k.map(|k| a + step * k));
        for _ in 0..8 {
            let origin = h.round(random.direction() * 0.4);
            let target = a + step * random.range(0.0, 2.0);
            rays.push(ProbeRay::new(origin, h.round(target - origin)));
        }
    }
    let scene = soup(&triangles);
    wrong += h.probe(&scene, &rays)?.hits.iter().flatten().filter(|h| h.id > 1).count();
    wrong += usize::from(h.picture(&scene)?.counters.degenerate_triangles != 500);
    Ok(Figure::count(wrong, rays.len() + 1, "rays hit, or triangles not counted"))
}

/// Rays in the plane of a tilted triangle with exact arithmetic: the largest component of the
/// direction is a power of two.
fn rays_in_plane(tri: &[DVec3; 3]) -> Vec<ProbeRay> {
    let (e1, e2) = (tri[1] - tri[0], tri[2] - tri[0]);
    let mut rays = Vec::new();
    for i in -4..=4 {
        for j in -4..=4 {
            let d = f64::from(i) * e1 + f64::from(j) * e2;
            let m = d.abs().max_element();
            if m == 0.0 || m.log2().fract() != 0.0 {
                continue;
            }
            for k in 0..=4 {
                // Through points of the first edge and beyond it, its corners among them.
                let through = tri[0] + e1 * (f64::from(k - 1) / 2.0);
                rays.push(ProbeRay::new(through - 2.0 * d, d));
                rays.push(ProbeRay::new(through, d));
            }
        }
    }
    rays
}

fn in_plane(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let (mut wrong, mut count) = (0, 0);
    let v = |x: f64, y: f64, z: f64| DVec3::new(x, y, z) / 4.0;
    for tri in [
        [v(0.0, 0.0, 0.0), v(1.0, 0.0, -1.0), v(0.0, 1.0, -1.0)],
        [v(0.0, 0.0, 1.0), v(1.0, 0.0, 1.0), v(0.0, 1.0, 1.0)],
        [v(-1.0, 1.0, 0.0), v(1.0, 1.0, 1.0), v(0.0, 1.0, -1.0)],
        [v(1.0, 0.0, 0.0), v(1.0, 1.0, 0.5), v(1.0, -1.0, 1.0)],
    ] {
        let mut all = frame_keepers().to_vec();
        all.push(tri);
        let rays = rays_in_plane(&tri);
        let hits = h.probe(&soup(&all), &rays)?.hits;
        count += rays.len();
        wrong += hits.iter().flatten().filter(|h| h.id == 2 || !h.t.is_finite()).count();
    }
    let mut cube = empty(vec![matte([1.0; 3], 1.0)]);
    cube.meshes = vec![cuboid(DVec3::splat(-0.5), DVec3::splat(0.5), 0)];
    let local = local_triangles(h, &cube);
    let mut rays = Vec::new();
    for axis in 0..3 {
        for way in [-1.0, 1.0] {
            for (a, b) in (0..81).map(|i| (f64::from(i % 9 - 4) / 8.0, f64::from(i / 9 - 4) / 8.0)) {
                for zero in [0.0, -0.0] {
                    let mut d = DVec3::splat(zero);
                    d[axis] = way;
                    let mut o = DVec3::ZERO;
                    o[axis] = -way;
                    o[(axis + 1) % 3] = a;
                    o[(axis + 2) % 3] = b;
                    rays.push(ProbeRay::new(o, d));
                }
            }
        }
    }
    count += rays.len();
    for (ray, hit) in rays.iter().zip(h.probe(&cube, &rays)?.hits) {
        let all = local.iter().filter_map(|t| inclusive(t, ray.origin, ray.direction));
        wrong += usize::from(hit.map_or(f64::INFINITY, |h| h.t) != all.fold(f64::INFINITY, f64::min));
    }
    Ok(Figure::count(wrong, count, "rays wrong"))
}

fn hit_point(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let place = DVec3::new(98304.7531, -50000.2718, 70000.5772);
    let scene = one_mesh([DVec3::ZERO, DVec3::X, DVec3::Y].map(|v| v + place).to_vec(), &[[0, 1, 2]]);
    let frame = h.local_frame(&scene);
    let scale = frame.length(1.0);
    let (origin, corner) = (h.local(&scene, place - DVec3::Z), frame.point(place));
    let grid = |i: usize| (i % 16) as f64 / 32.0 + 1.0 / 64.0;
    let ways: Vec<[f64; 2]> = (0..256).map(|i| [grid(i), grid(i / 16)]).collect();
    let rays: Vec<ProbeRay> =
        ways.iter().map(|w| ProbeRay::new(origin, DVec3::new(w[0], w[1], 1.0) * scale)).collect();
    let hits = h.probe(&scene, &rays)?.hits;
    let ulp = 2.0 * h.u();
    let mut worst = 0f64;
    for (w, hit) in ways.iter().zip(hits) {
        let Some(hit) = hit else { return Ok(Figure::new(f64::INFINITY, 16.0, "a ray missed")) };
        let point = corner + DVec3::new(w[0], w[1], 0.0) * scale;
        let errors = [
            (hit.t - 1.0).abs(),
            (hit.uv[0] - w[0]).abs(),
            (hit.uv[1] - w[1]).abs(),
            (hit.position - point).abs().max_element(),
            if hit.normal == -DVec3::Z { 0.0 } else { f64::INFINITY },
        ];
        worst = errors.into_iter().fold(worst, f64::max);
    }
    Ok(Figure::new(worst / ulp, 16.0, "ulp, error of weights, t and hit point"))
}

fn huge_coordinates(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let room = room();
    let mut wrong = 0;
    for (exponent, back) in
        [(12, -40), (18, -60), (20, -66), (30, -100), (150, -498), (-30, 100), (-150, 498)]
    {
        let scene = moved(&room, 10f64.powi(exponent), DVec3::ZERO);
        let unit = moved(&scene, 2f64.powi(back), DVec3::ZERO);
        let (a, b) = (h.picture(&scene)?, h.picture(&unit)?);
        let bad = |p: &[f32; 3]| p.iter().any(|c| !c.is_finite());
        wrong += a.linear.iter().zip(&b.linear).filter(|(p, q)| p != q || bad(p)).count();
        wrong += usize::from(a.counters != crate::report::Counters::default());
    }
    Ok(Figure::none(wrong, "pixels or counters differ"))
}

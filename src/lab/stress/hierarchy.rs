//! The hierarchy finds the same hits as brute force, bit for bit, for any ray.

use super::case::{Case, Figure, Harness, Random};
use super::exact::{inclusive, local_triangles};
use crate::kernel::abi;
use crate::lab::probe::{ProbeHit, ProbeRay, Probed};
use crate::render::RenderError;
use crate::scene::Scene;
use crate::scene::procedural::shapes::{cuboid, empty, matte, mesh, polygon, sphere};
use glam::DVec3;

/// Cases of this file.
pub const CASES: &[Case] = &[
    Case {
        name: "hierarchy",
        does: "1, 32, 33 and 700 triangles, slivers, axis-aligned ones and spheres; slivers behind a wall; random, corner and grazing rays: brute force against the hierarchy and the default",
        stands_for: "hits lost or moved by a hierarchy: svenstaro bvh 149, tinybvh 286",
        bound: "exact in id, t, weights and position: a hierarchy only culls (numerics.md, Boxes)",
        run: equals_brute_force,
    },
    Case {
        name: "axis-rays",
        does: "26 axis and diagonal directions, each zero as +0 and -0, from every face, edge and corner of 27 boxes and of their padded bounds",
        stands_for: "0 * inf = NaN in slab tests, -0 in the wrong octant: tinybvh 282, svenstaro bvh 140, warp 1530",
        bound: "exact: with dyadic numbers, brute force, hierarchy and exact arithmetic agree in t (numerics.md, Boxes)",
        run: axis_rays,
    },
    Case {
        name: "no-extent",
        does: "triangles of denormal and of zero size over a floor, in flat boxes",
        stands_for: "svenstaro bvh 140: a box of extent 5.693442e-39 gives NaN",
        bound: "exact: triangles without area are counted, rays stop within 2^-19 of a triangle or of the floor, and nothing is NaN (numerics.md, Boxes)",
        run: no_extent,
    },
    Case {
        name: "unusable-rays",
        does: "rays with a NaN or infinity in any component among valid rays; also zero, huge and opposite-signed components",
        stands_for: "Embree's NaNTest and InfTest: a ray that never ends or corrupts its neighbours",
        bound: "exact: invalid rays are counted and hit nothing, and the hits of valid rays do not change (numerics.md, Boxes)",
        run: unusable_rays,
    },
    Case {
        name: "nested",
        does: "64 concentric spheres of radius 2^-i over a floor of size 2^10, seen from between any two of them",
        stands_for: "the teapot in a stadium: traversal stacks that overflow, spheres that vanish",
        bound: "no overflow (B7); for radii of at least 2^-60 in the local frame, whose square f32 can hold (2^-39 where denormals are flushed): the right sphere, and t within 16u |o| (1 + tan a) for an angle of incidence a (the vector across the ray has an error of 4u |o|)",
        run: nested,
    },
];

/// True if two hits are equal in every bit.
fn same(a: &Option<ProbeHit>, b: &Option<ProbeHit>) -> bool {
    let bits = |h: &ProbeHit| {
        let p = h.position.to_array().map(f64::to_bits);
        (h.id, h.t.to_bits(), h.uv.map(f64::to_bits), p)
    };
    a.as_ref().map(bits) == b.as_ref().map(bits)
}

/// Rays whose hits differ, and walks that were given up.
pub(super) fn differences(a: &Probed, b: &Probed) -> usize {
    let overflows = |p: &Probed| {
        (p.counters[abi::COUNTER_STACK_OVERFLOW as usize] + p.counters[abi::COUNTER_LOOP_CAP as usize])
            as usize
    };
    a.hits.iter().zip(&b.hits).filter(|(a, b)| !same(a, b)).count() + overflows(a) + overflows(b)
}

fn spot(r: &mut Random) -> DVec3 {
    DVec3::new(r.range(-0.5, 0.5), r.range(-0.5, 0.5), r.range(-0.5, 0.5))
}

/// A triangle of one of four kinds.
fn odd_triangle(kind: usize, r: &mut Random) -> [DVec3; 3] {
    let a = spot(r);
    let axis = DVec3::AXES[(r.unit() * 3.0) as usize];
    match kind % 4 {
        0 => [a, a + r.direction() * 0.2, a + r.direction() * 0.2],
        // Flat: no extent along the axis.
        1 => [a, a + r.direction() * 0.3, a + r.direction() * 0.3].map(|p| p - axis * (p - a).dot(axis)),
        // A sliver along an axis: its weights, and with them t, are noise.
        2 => [a, a + axis * 0.4, a + axis * r.range(0.1, 0.3) + r.direction() * 3e-7],
        _ => [a, a + r.direction() * 0.5, a + r.direction() * 1e-6],
    }
}

fn jumble(count: usize, spheres: usize, stream: u32) -> Scene {
    let mut r = Random::new(stream);
    let mut scene = empty(vec![matte([1.0; 3], 1.0)]);
    let corners: Vec<DVec3> = (0..count).flat_map(|i| odd_triangle(i, &mut r)).collect();
    let faces: Vec<[u32; 3]> = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    scene.meshes = vec![mesh(corners, &faces, 0)];
    for _ in 0..spheres {
        let radius = 10f64.powf(r.range(-4.5, -0.7));
        scene.spheres.push(sphere(spot(&mut r).to_array(), radius, 0));
    }
    scene
}

fn jumble_rays(h: &Harness<'_>, scene: &Scene, count: usize, r: &mut Random) -> Vec<ProbeRay> {
    let local = local_triangles(h, scene);
    (0..count)
        .map(|i| {
            let [a, b, c] = local[(r.unit() * local.len() as f64) as usize];
            let (v, w) = (r.unit(), r.unit());
            let within = a + (b - a) * v.min(1.0 - w) + (c - a) * w.min(1.0 - v);
            let along = (b - a) * r.range(-1.0, 1.0) + (c - a) * r.range(-1.0, 1.0);
            let mut origin = h.round(r.direction() * r.range(0.0, 1.0));
            let target = match i % 5 {
                0 => origin + r.direction(),
                1 => a,
                2 => within,
                // Grazing: nearly in the plane.
                3 => {
                    origin = h.round(within - along * 2.0 + r.direction() * 10f64.powf(r.range(-8.0, -2.0)));
                    within
                }
                // Across the long side at a slant: within the plane of the sliver's axis.
                _ => {
                    let axis = DVec3::AXES[(r.unit() * 3.0) as usize];
                    origin = h.round(within + axis * 0.7 + (b - a) * r.range(-1.0, 1.0));
                    within
                }
            };
            ProbeRay::new(origin, h.round(target - origin))
        })
        .filter(|r| r.direction != DVec3::ZERO)
        .collect()
}

/// Slivers along x close behind a wall. For rays that cross both at a slant, the t of the sliver
/// may lie before the wall unless it is clamped to the sliver's box.
fn curtain(h: &Harness<'_>) -> (Scene, Vec<ProbeRay>) {
    let mut r = Random::new(70);
    let mut scene = empty(vec![matte([1.0; 3], 1.0)]);
    scene.polygons =
        vec![polygon(&[[-0.5, 0.0, -0.5], [-0.5, 0.0, 0.5], [0.5, 0.0, 0.5], [0.5, 0.0, -0.5]], 0)];
    let mut corners = Vec::new();
    for _ in 0..60 {
        let a = DVec3::new(-0.45, r.range(0.001, 0.01), r.range(-0.1, 0.1));
        let c = a + DVec3::X * r.range(0.3, 0.6) + r.direction() * 1e-7;
        corners.extend([a, a + DVec3::X * 0.9, c]);
    }
    let faces: Vec<[u32; 3]> = (0..60).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    scene.meshes = vec![mesh(corners, &faces, 0)];
    let local = local_triangles(h, &scene);
    let rays = (0..12_000)
        .map(|i| {
            let [a, b, c] = local[2 + i % 60];
            let (v, w) = (r.range(0.2, 0.5), r.range(0.2, 0.5));
            let target = a + v * (b - a) + w * (c - a);
            let way = DVec3::new(if i % 2 == 0 { 1.0 } else { -1.0 }, r.range(0.3, 1.0), r.range(-0.2, 0.2));
            let origin = h.round(target - way * 0.4);
            ProbeRay::new(origin, h.round(target - origin))
        })
        .collect();
    (scene, rays)
}

fn equals_brute_force(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let (mut different, mut count) = (0, 0);
    // Around the number of primitives from which the hierarchy is used, and far more.
    let sizes = [(1, 0), (16, 16), (16, 17), (600, 100)];
    for (i, (triangles, spheres)) in sizes.into_iter().enumerate() {
        let scene = jumble(triangles, spheres, 80 + i as u32);
        let n = if triangles > 500 { 4_000 } else { 1_500 };
        let rays = jumble_rays(h, &scene, n, &mut Random::new(90 + i as u32));
        let [brute, walk] = h.probe_both(&scene, &rays)?;
        let own = h.probe(&scene, &rays)?;
        count += rays.len();
        different += differences(&brute, &walk) + differences(&brute, &own);
    }
    let (scene, rays) = curtain(h);
    let [brute, walk] = h.probe_both(&scene, &rays)?;
    count += rays.len();
    different += differences(&brute, &walk);
    // An empty scene.
    let rays = [ProbeRay::new(DVec3::ZERO, DVec3::X), ProbeRay::new(DVec3::ONE, -DVec3::ONE)];
    for probed in h.probe_both(&empty(vec![matte([1.0; 3], 1.0)]), &rays)? {
        different += probed.hits.iter().flatten().count();
    }
    Ok(Figure::count(different, count, "rays differ"))
}

/// 26 directions; each zero component as +0 and as -0.
fn directions() -> Vec<DVec3> {
    let values = [-1.0, -0.0, 0.0, 1.0];
    (0..64)
        .map(|i| DVec3::new(values[i % 4], values[i / 4 % 4], values[i / 16]))
        .filter(|d| *d != DVec3::ZERO)
        .collect()
}

fn axis_rays(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let mut scene = empty(vec![matte([1.0; 3], 1.0)]);
    let (mut centers, half) = (Vec::new(), 0.125);
    for i in 0..27 {
        let c = DVec3::new(f64::from(i % 3 - 1), f64::from(i / 3 % 3 - 1), f64::from(i / 9 - 1)) * 0.375;
        centers.push(c);
        scene.meshes.push(cuboid(c - half, c + half, 0));
    }
    let pad = 2f64.powi(-19);
    let mut rays = Vec::new();
    for (k, c) in centers.iter().enumerate() {
        // On the box itself, and on its padded bounds.
        let reach = if k % 2 == 0 { half } else { half + pad };
        for i in (0..27).filter(|i| *i != 13) {
            let side = DVec3::new(f64::from(i % 3 - 1), f64::from(i / 3 % 3 - 1), f64::from(i / 9 - 1));
            for d in directions() {
                rays.push(ProbeRay::new(h.round(*c + side * reach), d));
            }
        }
    }
    let local = local_triangles(h, &scene);
    let [brute, walk] = h.probe_both(&scene, &rays)?;
    let mut wrong = differences(&brute, &walk);
    for (ray, hit) in rays.iter().zip(&walk.hits) {
        let all = local.iter().filter_map(|t| inclusive(t, ray.origin, ray.direction));
        let expected = all.fold(f64::INFINITY, f64::min);
        wrong += usize::from(hit.map_or(f64::INFINITY, |h| h.t) != expected);
    }
    Ok(Figure::count(wrong, rays.len(), "rays wrong"))
}

fn no_extent(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let mut scene = empty(vec![matte([1.0; 3], 1.0)]);
    scene.polygons =
        vec![polygon(&[[-0.5, -0.5, 0.0], [0.5, -0.5, 0.0], [0.5, 0.5, 0.0], [-0.5, 0.5, 0.0]], 0)];
    // Heights are symmetric about the floor, so that the local frame stays the same.
    let (mut corners, mut z, mut degenerate) = (Vec::new(), vec![0.0], 0);
    for (i, s) in [5.693442e-39, 1e-42, 1e-310, 0.0, 1e-20, 1e-38].into_iter().enumerate() {
        for side in [-1.0, 1.0] {
            let height = side * (i + 1) as f64 / 16.0;
            corners.push([[0.0, 0.0, height], [s, 0.0, height], [0.0, s, height]].map(DVec3::from));
            z.push(height);
            let held = h.round(DVec3::X * s).x;
            // In f64 an area of 1e-620 is 0.
            degenerate += u64::from(held * held == 0.0);
        }
    }
    let faces: Vec<[u32; 3]> = (0..corners.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    scene.meshes = vec![mesh(corners.concat(), &faces, 0)];
    let mut random = Random::new(100);
    let mut rays = Vec::new();
    for i in 0..4_000 {
        let s = [0.0, 1e-39, 2e-39, 1e-21, 3e-39][i % 5];
        let o = DVec3::new(s, s, if i % 2 == 0 { -0.5 } else { 0.5 });
        let d = if i % 3 == 0 { random.direction() } else { DVec3::new(0.0, -0.0, -2.0 * o.z) };
        rays.push(ProbeRay::new(h.round(o), h.round(d)));
    }
    let [brute, walk] = h.probe_both(&scene, &rays)?;
    let mut wrong = differences(&brute, &walk);
    // The weights of denormal triangles are noise, but t stays within the box.
    let pad = 2f64.powi(-19) + 4.0 * 2f64.powi(-24);
    for (ray, hit) in rays.iter().zip(&brute.hits).filter(|(r, _)| r.direction.x == 0.0) {
        let at = |h: &ProbeHit| ray.origin.z + h.t * ray.direction.z;
        let on_one = |h: &ProbeHit| z.iter().any(|z| (z - at(h)).abs() <= pad);
        wrong += usize::from(!hit.is_some_and(|h| on_one(&h)));
    }
    wrong += brute.hits.iter().flatten().filter(|h| !h.t.is_finite() || !h.position.is_finite()).count();
    wrong += usize::from(h.picture(&scene)?.counters.degenerate_triangles != degenerate);
    Ok(Figure::count(wrong, rays.len(), "rays wrong or not counted"))
}

fn unusable_rays(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let scene = jumble(200, 50, 110);
    let mut r = Random::new(111);
    let good = jumble_rays(h, &scene, 4_000, &mut r);
    let clean = h.probe(&scene, &good)?;
    let (mut rays, mut unusable) = (Vec::new(), 0);
    for (i, ray) in good.iter().enumerate() {
        rays.push(*ray);
        let value = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -f64::NAN][i / 6 % 4];
        let mut bad = *ray;
        match i % 6 {
            k @ 0..3 => bad.origin[k] = value,
            k => bad.direction[k - 3] = value,
        }
        unusable += 1;
        rays.push(bad);
    }
    let mut wrong = 0;
    for probed in h.probe_both(&scene, &rays)? {
        wrong += probed.hits.chunks(2).zip(&clean.hits).filter(|(pair, hit)| !same(&pair[0], hit)).count();
        wrong += probed.hits.chunks(2).filter(|pair| pair[1].is_some()).count();
        wrong += usize::from(probed.counters[abi::COUNTER_NAN_RAYS as usize] != unusable);
    }
    // Finite, but they overflow: they may hit or miss, but must end with a finite t.
    let big = if h.u() < 1e-10 { 1e300 } else { 3e38 };
    let extremes = [0.0, -0.0, big, -big, 1.0 / big];
    let mut odd = Vec::new();
    for i in 0..125 {
        let v = DVec3::new(extremes[i % 5], extremes[i / 5 % 5], extremes[i / 25]);
        odd.push(ProbeRay::new(good[i].origin, v));
        odd.push(ProbeRay::new(v, good[i].direction));
        odd.push(ProbeRay::new(v, -v));
    }
    for probed in h.probe_both(&scene, &odd)? {
        let strange = |r: &ProbeRay, h: &ProbeHit| !h.t.is_finite() || r.direction == DVec3::ZERO;
        wrong += odd.iter().zip(&probed.hits).filter(|(r, hit)| hit.is_some_and(|h| strange(r, &h))).count();
        wrong += probed.counters[abi::COUNTER_LOOP_CAP as usize] as usize;
    }
    Ok(Figure::count(wrong, rays.len() + odd.len(), "rays wrong"))
}

/// Least positive root of |o + t d|^2 = r^2; `None` if there is none or the ray is too close to the
/// silhouette to decide.
fn sphere_ahead(o: DVec3, d: DVec3, r: f64) -> Result<Option<f64>, ()> {
    let a = d.length_squared();
    let along = -o.dot(d) / a;
    let across = (o + along * d).length();
    if (across / r - 1.0).abs() < 1e-3 || (o.length() / r - 1.0).abs() < 1e-3 {
        return Err(());
    }
    if across > r {
        return Ok(None);
    }
    let reach = ((r - across) * (r + across) / a).sqrt();
    Ok([along - reach, along + reach].into_iter().find(|t| *t > 0.0))
}

fn nested(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let mut scene = empty(vec![matte([1.0; 3], 1.0)]);
    let s = 1024.0;
    scene.polygons = vec![polygon(&[[-s, -1.0, s], [s, -1.0, s], [s, -1.0, -s], [-s, -1.0, -s]], 0)];
    for i in 0..64 {
        scene.spheres.push(sphere([0.0; 3], 2f64.powi(-i), 0));
    }
    let frame = h.local_frame(&scene);
    let center = frame.point(DVec3::ZERO);
    let mut random = Random::new(120);
    let mut rays = Vec::new();
    for i in 0..64 * 100 {
        let radius = frame.length(2f64.powi(-(i / 100)));
        let from = center + random.direction() * radius * random.range(0.55, 0.95);
        rays.push(ProbeRay::new(h.round(from), h.round(random.direction())));
    }
    let probed = h.probe(&scene, &rays)?;
    let (mut wrong, mut sure, mut worst) = (0, 0, 0f64);
    let least = h.least_radius();
    let judged = (0..64).filter(|i| frame.length(2f64.powi(-i)) >= least).count();
    for (ray, hit) in rays.iter().zip(&probed.hits) {
        let o = ray.origin - center;
        let all: Result<Vec<_>, ()> =
            (0..64).map(|i| sphere_ahead(o, ray.direction, frame.length(2f64.powi(-i)))).collect();
        let Ok(all) = all else { continue };
        let nearest = all.iter().enumerate().filter_map(|(i, t)| t.map(|t| (i, t)));
        let Some((i, t)) = nearest.min_by(|a, b| a.1.total_cmp(&b.1)) else { continue };
        if frame.length(2f64.powi(-(i as i32))) < least {
            continue;
        }
        sure += 1;
        match hit {
            Some(hit) if hit.id as usize == i + 2 => {
                // The vector across the ray carries 4u |o|, the half chord that over its cosine.
                let r = frame.length(2f64.powi(-(i as i32)));
                let along = -o.dot(ray.direction) / ray.direction.length_squared();
                let across = (o + along * ray.direction).length();
                let condition = 1.0 + across / ((r - across) * (r + across)).sqrt();
                worst = worst.max((hit.t - t).abs() / (o.length() * condition * h.u()));
            }
            _ => wrong += 1,
        }
    }
    wrong += probed.counters[abi::COUNTER_STACK_OVERFLOW as usize] as usize;
    wrong += probed.counters[abi::COUNTER_LOOP_CAP as usize] as usize;
    wrong += usize::from(sure < 60 * judged || judged < 25);
    let counters = h.picture(&scene)?.counters;
    wrong += (counters.stack_overflow + counters.loop_cap) as usize;
    Ok(Figure::count(wrong, sure, "rays wrong, or overflowed").worse(Figure::new(
        worst,
        16.0,
        "units of roundoff u, relative error of t",
    )))
}

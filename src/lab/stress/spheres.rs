//! Ray-sphere intersection: far, near, tiny, huge, from inside, at the rim.

use super::case::{Case, Figure, Harness, Random};
use super::roots::{Pass, pass};
use crate::lab::probe::{ProbeHit, ProbeRay};
use crate::render::RenderError;
use crate::scene::procedural::shapes::{empty, glass, matte, mirror, polygon, sphere};
use crate::scene::{Fresnel, Scene};
use crate::units::grouped;
use glam::DVec3;

/// Cases of this file.
pub const CASES: &[Case] = &[
    Case {
        name: "sphere-distance",
        does: "a unit sphere hit all over from 10 to 10^7 radii away",
        stands_for: "the quadratic formula of POV-Ray and others, which loses a quarter of the hits from 10^4 radii",
        bound: "no wrong hit where |b - r| > 4u D; t within 16u t in single precision and 8u t in double-length, plus the effect of 4u D on the root (numerics.md, Spheres)",
        run: distance,
    },
    Case {
        name: "sphere-planet",
        does: "a planet of radius 10^6 seen from heights 10^-4 to 10^2, and a bead of radius 10^-3 seen from distance 10^3",
        stands_for: "planets in single precision, where t is wrong by 9 % (numerics.md, Spheres); beads that vanish",
        bound: "8u t (numerics.md, Spheres), plus the effect of 16u^2 of the distance from the rim on the root; no wrong hit farther from the rim",
        run: planet,
    },
    Case {
        name: "sphere-roots",
        does: "all four intersections with two spheres, one ray after the other; rays from the centre, from just inside, and from the surface inward and outward",
        stands_for: "renderers that always take the smaller root: rays never leave a glass sphere",
        bound: "16u t and the ray offset from intersection to intersection, 8u r for chords (numerics.md, Spheres), from near the surface as for `sphere-distance`; a wrong hit counts as infinite",
        run: roots,
    },
    Case {
        name: "sphere-rim",
        does: "rays near the rim, at b = r (1 -+ 2^-k), k = 1..30, from 2 to 10^4 radii",
        stands_for: "ragged silhouettes from cancellation in the discriminant",
        bound: "exact where |b - r| > 4u D (numerics.md, Spheres)",
        run: rim,
    },
    Case {
        name: "sphere-reintersect",
        does: "rays that leave spheres of radius 10^U(-4,4) at positions 10^U(-8,8) on both sides, down to grazing",
        stands_for: "shadow acne on spheres: pbrt's FullSphere.Reintersect",
        bound: "exact: no outward ray and every inward ray hits its own sphere (numerics.md, Spheres)",
        run: reintersect,
    },
];

/// A single sphere at the origin, seen from `eye`.
fn lone(radius: f64, eye: DVec3) -> Scene {
    let mut s = empty(vec![matte([1.0; 3], 1.0)]);
    s.spheres = vec![sphere([0.0; 3], radius, 0)];
    s.camera.look_from = eye;
    s
}

/// Allowed error of t, and the distance from the rim within which a ray may hit or miss.
struct Tolerance {
    t: f64,
    band: f64,
}

/// In single precision the line's distance b from the centre has an error of 4u D; in double-length
/// an error of (16u^2 + 4 * 2^-53) times the distance to the rim. So r^2 - b^2 has an error of e =
/// 2b that, and |sqrt(x + e) - sqrt(x)| <= min(sqrt e, e / sqrt x). |f|^2 - r^2 has an error of 4u
/// D (D + r) in single precision, which t = (|f|^2 - r^2) / q inherits; plus 12 roundings.
fn tolerance(u: f64, p: &Pass, r: f64, wide: bool) -> Tolerance {
    let b = r + p.gap;
    let way = (p.distance * p.distance - b * b).max(0.0).sqrt();
    let off = match wide {
        true => (16.0 * u * u).max(2f64.powi(-51)).min(16.0 * u) * (way + (p.distance - r).abs()),
        false => 4.0 * u * p.distance,
    };
    let Some(t) = p.roots.into_iter().find(|t| *t > 0.0) else { return Tolerance { t: 0.0, band: off } };
    let root = (p.roots[1] - p.roots[0]) / 2.0;
    let e = 2.0 * b * off + if wide { 0.0 } else { 4.0 * u * r * r };
    let lack = if wide { 0.0 } else { 4.0 * u * p.distance * (p.distance + r) / (way + root) };
    let relative = if wide { 8.0 } else { 12.0 };
    Tolerance { t: relative * u * t + lack + e.sqrt().min(e / root), band: off }
}

/// Rays from `origin` toward points of sphere 0, at least 10^-3 of the radius from its rim.
fn toward_disc(
    h: &Harness<'_>,
    scene: &Scene,
    origin: DVec3,
    n: usize,
    random: &mut Random,
) -> Vec<ProbeRay> {
    let (center, radius, _) = h.local_sphere(scene, 0);
    (0..n)
        .map(|_| {
            let target = center + radius * (1.0 - 1e-3) * random.unit().sqrt() * random.direction();
            ProbeRay::new(origin, h.round((target - origin).normalize()))
        })
        .collect()
}

/// Compares hits on sphere 0 with exact ones: number of wrong hits, and greatest error of t /
/// allowed error.
fn judge(h: &mut Harness<'_>, scene: &Scene, rays: &[ProbeRay]) -> Result<(usize, f64), RenderError> {
    let (center, radius, wide) = h.local_sphere(scene, 0);
    let hits = h.probe(scene, rays)?.hits;
    let u = h.u();
    let (mut wrong, mut worst) = (0, 0.0f64);
    for (ray, hit) in rays.iter().zip(&hits) {
        let p = pass(ray.origin, ray.direction, center, radius);
        let may = tolerance(u, &p, radius, wide);
        if p.gap.abs() <= may.band {
            continue;
        }
        let expected = p.roots.into_iter().find(|t| *t > 0.0);
        match (hit, expected) {
            (None, None) => {}
            (Some(hit), Some(t)) => worst = worst.max((hit.t - t).abs() / may.t),
            _ => wrong += 1,
        }
    }
    Ok((wrong, worst))
}

/// The number of wrong hits if there are any, otherwise the error of t.
fn verdict(wrong: usize, worst: f64, rays: usize) -> Figure {
    if wrong > 0 {
        return Figure::count(wrong, rays, "rays wrong");
    }
    Figure::share(worst, &format!("worst of {} rays", grouped(rays as u64)))
}

fn distance(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let mut random = Random::new(20);
    let (mut wrong, mut worst, mut count) = (0, 0.0f64, 0);
    for k in 1..=7 {
        let mut scene = lone(1.0, random.direction() * 10f64.powi(k));
        if k > 4 {
            // An object behind the camera makes the local frame as large as the distance.
            let behind =
                [1.5, 1.6, 1.7].map(|f| (scene.camera.look_from * f + random.direction()).to_array());
            scene.polygons = vec![polygon(&behind, 0)];
        }
        let eye = h.local(&scene, scene.camera.look_from);
        let rays = toward_disc(h, &scene, eye, 4000, &mut random);
        let (w, t) = judge(h, &scene, &rays)?;
        (wrong, worst, count) = (wrong + w, worst.max(t), count + rays.len());
    }
    Ok(verdict(wrong, worst, count))
}

fn planet(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let mut random = Random::new(21);
    let (mut wrong, mut worst, mut count) = (0, 0.0f64, 0);
    for height in [1e-4, 1e-2, 1.0, 1e2] {
        let radius = 1e6;
        let up = random.direction();
        let scene = lone(radius, up * (radius + height));
        let eye = h.local(&scene, scene.camera.look_from);
        let dip = (2.0 * height / radius).sqrt();
        let rays: Vec<ProbeRay> = (0..4000)
            .map(|i| {
                let side = up.cross(random.direction()).normalize();
                // Straight down, anywhere below, and around the horizon.
                let angle = match i % 3 {
                    0 => random.range(0.0, 1.5),
                    1 => dip * (1.0 + 2f64.powi(-(i % 20))),
                    _ => dip * (1.0 - 2f64.powi(-(i % 20))),
                };
                let down = if i % 3 == 0 { std::f64::consts::FRAC_PI_2 - angle } else { angle };
                ProbeRay::new(eye, h.round((side * down.cos() - up * down.sin()).normalize()))
            })
            .collect();
        let (w, t) = judge(h, &scene, &rays)?;
        (wrong, worst, count) = (wrong + w, worst.max(t), count + rays.len());
    }
    // The bead: a floor of size 10^3 keeps the local frame large.
    let mut scene = lone(1e-3, DVec3::new(600.0, 500.0, 700.0));
    let l = 1000.0;
    scene.polygons = vec![polygon(&[[-l, -1.0, -l], [-l, -1.0, l], [l, -1.0, l], [l, -1.0, -l]], 0)];
    let eye = h.local(&scene, scene.camera.look_from);
    let rays = toward_disc(h, &scene, eye, 4000, &mut random);
    let rays: Vec<ProbeRay> = rays.into_iter().filter(|r| certain_hit(h, &scene, r)).collect();
    let hits = h.probe(&scene, &rays)?.hits;
    let (center, radius, _) = h.local_sphere(&scene, 0);
    for (ray, hit) in rays.iter().zip(&hits) {
        let t = pass(ray.origin, ray.direction, center, radius).roots[0];
        match hit {
            Some(hit) if hit.id == 2 => worst = worst.max((hit.t - t).abs() / (8.0 * h.u() * t)),
            _ => wrong += 1,
        }
    }
    Ok(verdict(wrong, worst, count + rays.len()))
}

/// True if the ray hits sphere 0 away from its rim.
fn certain_hit(h: &Harness<'_>, scene: &Scene, ray: &ProbeRay) -> bool {
    let (center, radius, _) = h.local_sphere(scene, 0);
    pass(ray.origin, ray.direction, center, radius).gap < -1e-3 * radius
}

fn rim(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let mut random = Random::new(22);
    let (mut wrong, mut worst, mut count) = (0, 0.0f64, 0);
    for d in [2.0, 10.0, 1e2, 1e3, 1e4] {
        let scene = lone(1.0, random.direction() * d);
        let eye = h.local(&scene, scene.camera.look_from);
        let (center, radius, _) = h.local_sphere(&scene, 0);
        let axis = (center - eye).normalize();
        let reach = (center - eye).length();
        let rays: Vec<ProbeRay> = (0..3000)
            .map(|i| {
                let k = 1 + i / 2 % 30;
                let b = radius * (1.0 + 2f64.powi(-k) * if i % 2 == 0 { 1.0 } else { -1.0 });
                let side = axis.cross(random.direction()).normalize();
                let sin = (b / reach).min(1.0);
                ProbeRay::new(eye, h.round(side * sin + axis * (1.0 - sin * sin).sqrt()))
            })
            .collect();
        let (w, t) = judge(h, &scene, &rays)?;
        (wrong, worst, count) = (wrong + w, worst.max(t), count + rays.len());
    }
    Ok(verdict(wrong, worst, count))
}

/// Error of a hit expected on primitive `id` at `t`; infinite if it is missing.
fn error_at(hit: &Option<ProbeHit>, id: u32, t: f64) -> f64 {
    match hit {
        Some(hit) if hit.id == id => (hit.t - t).abs(),
        _ => f64::INFINITY,
    }
}

fn roots(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let two = two_roots(h)?;
    let one = inside_roots(h)?;
    Ok(Figure::share(two.max(one), "worst of 6,005 rays"))
}

/// Two glass spheres of radius 1 at z = 0 and 3: a ray through their centres hits z = -1, 1, 2, 4.
fn two_roots(h: &mut Harness<'_>) -> Result<f64, RenderError> {
    let mut scene = empty(vec![glass(1.5, Fresnel::Exact)]);
    scene.spheres = vec![sphere([0.0; 3], 1.0, 0), sphere([0.0, 0.0, 3.0], 1.0, 0)];
    let frame = h.local_frame(&scene);
    let mut ray = ProbeRay::new(h.local(&scene, DVec3::new(0.0, 0.0, -5.0)), DVec3::Z);
    // Each new ray starts at the ray offset, 16u (|c| + r), which the chord does not contain.
    let reach = (0..2).map(|i| h.local_sphere(&scene, i)).map(|s| s.0.length() + s.1).fold(0.0, f64::max);
    let mut worst = 0.0f64;
    for (id, z) in [(0, -1.0), (0, 1.0), (1, 2.0), (1, 4.0)] {
        let probed = h.probe(&scene, &[ray])?;
        let t = frame.point(DVec3::new(0.0, 0.0, z)).z - ray.origin.z;
        worst = worst.max(error_at(&probed.hits[0], id, t) / (16.0 * h.u() * t + 16.0 * h.u() * reach));
        let Some(child) = probed.children.iter().find(|c| c.refracted) else { return Ok(f64::INFINITY) };
        ray = ProbeRay { skip: child.skip, ..ProbeRay::new(child.origin, child.direction) };
    }
    let last = h.probe(&scene, &[ray])?.hits[0];
    Ok(if last.is_some() { f64::INFINITY } else { worst })
}

/// From the centre, from (1 - 2^-20) r, and from the surface, in units of the radius.
fn inside_roots(h: &mut Harness<'_>) -> Result<f64, RenderError> {
    let mut scene = empty(vec![matte([1.0; 3], 1.0), matte([1.0; 3], 1.0)]);
    scene.spheres = vec![sphere([0.0; 3], 1.0, 0), sphere([0.0; 3], 1e-3, 1)];
    scene.spheres[1].center = DVec3::new(5.0, 0.0, 0.0);
    let (center, radius, _) = h.local_sphere(&scene, 0);
    let mut random = Random::new(23);
    let mut rays = Vec::new();
    for i in 0..6000 {
        let (n, w) = (random.direction(), h.round(random.direction()));
        let ray = |p: DVec3, skip| ProbeRay { skip, ..ProbeRay::new(h.round(p), w) };
        rays.push(match i % 3 {
            0 => ray(center, None),
            1 => ray(center + n * radius * (1.0 - 2f64.powi(-20)), None),
            _ => ray(center + n * radius, Some(0)),
        });
    }
    let hits = h.probe(&scene, &rays)?.hits;
    let mut worst = 0.0f64;
    for (ray, hit) in rays.iter().zip(&hits) {
        let (f, d) = (ray.origin - center, ray.direction);
        let chord = -2.0 * f.dot(d) / d.length_squared();
        // Where rounding decides between inside and outside, either is right.
        if ray.skip.is_some() && chord.abs() <= 64.0 * h.u() * (ray.origin.abs().max_element() + radius) {
            continue;
        }
        if ray.skip.is_some() && chord < 0.0 {
            worst = if hit.is_some_and(|h| h.id == 0) { f64::INFINITY } else { worst };
            continue;
        }
        let p = pass(ray.origin, d, center, radius);
        let (t, bound) = match ray.skip {
            Some(_) => (chord, 8.0 * h.u() * radius),
            None => (p.roots[1], tolerance(h.u(), &p, radius, false).t),
        };
        worst = worst.max(error_at(hit, 0, t) / bound);
    }
    Ok(worst)
}

/// A glass sphere of radius 10^U(-4,4) at a position of size 10^U(-8,8), and a distant mirror
/// triangle that determines the size of the local frame.
fn stray_ball(random: &mut Random) -> Scene {
    let mut scene = empty(vec![glass(1.5, Fresnel::Exact), mirror(1.0, 0.0)]);
    let radius = 10f64.powf(random.range(-4.0, 4.0));
    let mut far = || 10f64.powf(random.range(-8.0, 8.0)) * if random.unit() < 0.5 { -1.0 } else { 1.0 };
    let center = DVec3::new(far(), far(), far());
    scene.spheres = vec![sphere(center.to_array(), radius, 0)];
    // Up to 4096 radii the sphere is tested in f32, beyond in double-length arithmetic.
    let size = radius * 10f64.powf(random.range(0.0, 4.5));
    let corner = center + DVec3::splat(size);
    scene.polygons = vec![polygon(
        &[corner.to_array(), (corner + DVec3::X * size).to_array(), (corner + DVec3::Y * size).to_array()],
        1,
    )];
    scene.camera.look_from = center + DVec3::new(0.0, 0.0, 3.0 * radius);
    scene.camera.look_at = center;
    scene
}

fn reintersect(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let mut random = Random::new(24);
    let (mut wrong, mut count) = (0, 0);
    for _ in 0..60 {
        let scene = stray_ball(&mut random);
        let own = 1; // after the triangle
        let (center, radius, _) = h.local_sphere(&scene, 0);
        let rays: Vec<ProbeRay> = (0..150)
            .map(|_| {
                let n = random.direction();
                let origin = h.round(center + n * radius * random.range(1.5, 6.0));
                let target = center + random.direction() * radius * 0.999 * random.unit().sqrt();
                ProbeRay {
                    media: Some([0; 2]),
                    ..ProbeRay::new(origin, h.round((target - origin).normalize()))
                }
            })
            .collect();
        let probed = h.probe(&scene, &rays)?;
        let mut next = Vec::new();
        for child in &probed.children {
            let Some(hit) = probed.hits[child.parent].filter(|hit| hit.id == own) else { continue };
            let side = if child.refracted { -hit.normal } else { hit.normal };
            let tangent = side.cross(random.direction()).normalize();
            if !child.refracted {
                // Exactly on the surface: the kernel knows which sphere the ray leaves.
                let d = h.round((tangent + side).normalize());
                next.push((false, ProbeRay { skip: Some(own), ..ProbeRay::new(hit.position, d) }));
            }
            for k in [0, 2, 6, 10, 14, 18, 22] {
                let d = h.round((tangent + side * 2f64.powi(-k)).normalize());
                // Outward of the sphere as rounded in the kernels.
                if d.dot(side) > 0.0 {
                    next.push((
                        child.refracted,
                        ProbeRay { skip: child.skip, ..ProbeRay::new(child.origin, d) },
                    ));
                }
            }
        }
        let again: Vec<ProbeRay> = next.iter().map(|n| n.1).collect();
        let hits = h.probe(&scene, &again)?.hits;
        wrong += next.iter().zip(&hits).filter(|(n, hit)| hit.is_some_and(|h| h.id == own) != n.0).count();
        count += again.len();
    }
    Ok(Figure::count(wrong, count, "rays wrong at their own sphere"))
}

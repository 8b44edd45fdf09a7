//! Shapes that touch, stand on one another or nearly coincide; silhouettes and horizons.

use super::case::{Case, Figure, Harness};
use super::pixels::{blur, lit, sphere_hit, wrong_pixels};
use crate::render::RenderError;
use crate::scene::Scene;
use crate::scene::procedural::shapes::{empty, light, matte, polygon, sphere};
use glam::DVec3;

/// Cases of this file.
pub const CASES: &[Case] = &[
    Case {
        name: "silhouette",
        does: "the outline of a sphere that fills the image, seen from 1.001 to 10^6 radii",
        stands_for: "outlines at atan(r/D) instead of asin(r/D); distant spheres with broken outlines",
        bound: "exact, except within 0.02 pixels of the outline (numerics.md, Closed forms)",
        run: silhouette,
    },
    Case {
        name: "horizon",
        does: "the horizon of a planet of radius 10^6 from heights 0.01 and 1",
        stands_for: "planets in single precision: a horizon with steps, or none",
        bound: "exact, except within 0.02 pixels of the horizon at acos(r/(r+h)) (numerics.md, Spheres)",
        run: horizon,
    },
    Case {
        name: "planet-shadow",
        does: "a sphere and its shadow on a planet of radius 10^6",
        stands_for: "shadow acne and detached shadows at planetary scale",
        bound: "exact, except within 0.02 pixels and the ray offset of edges",
        run: planet_shadow,
    },
    Case {
        name: "touching",
        does: "a sphere on a floor under a light, and two touching spheres, seen close to the point of contact",
        stands_for: "light that leaks through the point where a sphere touches the floor (tantalum, issue 3)",
        bound: "exact, except within 0.02 pixels and the ray offset of edges (numerics.md, Spawn origins)",
        run: touching,
    },
    Case {
        name: "concentric",
        does: "two concentric spheres with radii from 0 to 64 ulp apart, lit from the side",
        stands_for: "shells thinner than the ray epsilon: black rings and moire",
        bound: "exact, except within 0.02 pixels of edges: the inner sphere is never visible and casts no shadow on the outer",
        run: concentric,
    },
    Case {
        name: "huge-and-tiny",
        does: "spheres of radius 10^-3 to 10 on a sphere of radius 10^4, one light overhead",
        stands_for: "scenes with very different scales: shadow acne on large objects, holes in small ones",
        bound: "exact, except within 0.02 pixels and the ray offset of edges",
        run: huge_and_tiny,
    },
];

/// Class of a point on matte spheres under one light: lit or not; 3 for the background.
fn spheres_lit(scene: &Scene, o: DVec3, d: DVec3) -> u8 {
    let nearest = |o: DVec3, d: DVec3, skip: usize| {
        (0..scene.spheres.len())
            .filter(|i| *i != skip)
            .filter_map(|i| {
                sphere_hit(o, d, scene.spheres[i].center, scene.spheres[i].radius).map(|t| (i, t))
            })
            .min_by(|a, b| a.1.total_cmp(&b.1))
    };
    let Some((i, t)) = nearest(o, d, usize::MAX) else { return 0 };
    let (p, s) = (o + t * d, scene.spheres[i]);
    let n = (p - s.center) / s.radius;
    let to = scene.lights[0].position - p;
    let shadowed = nearest(p, to.normalize(), i).is_some_and(|(_, t)| t < to.length());
    u8::from(n.dot(to) > 0.0 && !shadowed)
}

/// Counts wrong pixels of a scene of matte spheres.
fn wrong_spheres(h: &mut Harness<'_>, scene: &Scene, blur: f64) -> Result<(usize, usize), RenderError> {
    let picture = h.picture(scene)?;
    Ok(wrong_pixels(scene, &picture, blur, |o, d| spheres_lit(scene, o, d), lit))
}

fn figure(counts: impl IntoIterator<Item = (usize, usize)>) -> Figure {
    let (wrong, judged) = counts.into_iter().fold((0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
    // A picture with edges everywhere proves nothing.
    if judged < 1000 {
        return Figure::new(f64::NAN, 0.0, format!("only {judged} pixels compared"));
    }
    Figure::count(wrong, judged, "pixels wrong")
}

fn silhouette(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let mut counts = Vec::new();
    for d in [1.001, 1.1, 2.0, 10.0, 1e3, 1e4, 1e6] {
        let mut scene = empty(vec![matte([1.0; 3], 1.0)]);
        scene.spheres = vec![sphere([0.0; 3], 1.0, 0)];
        scene.camera.look_from = DVec3::new(0.6, 0.48, 0.64) * d;
        // The view is rotated so that the outline passes through the middle of the image.
        let angle = (1.0f64 / d).asin();
        scene.camera.fov = angle * 1.2;
        let back = -scene.camera.look_from.normalize();
        let side = back.cross(DVec3::Y).normalize();
        scene.camera.look_at = scene.camera.look_from + back * angle.cos() + side * angle.sin();
        let picture = h.picture(&scene)?;
        let hit = |o: DVec3, d: DVec3| u8::from(sphere_hit(o, d, DVec3::ZERO, 1.0).is_some());
        counts.push(wrong_pixels(&scene, &picture, 0.02, hit, lit));
    }
    Ok(figure(counts))
}

fn horizon(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let r = 1e6;
    let mut counts = Vec::new();
    for height in [0.01, 1.0] {
        let mut scene = empty(vec![matte([1.0; 3], 1.0)]);
        scene.spheres = vec![sphere([0.0, -r, 0.0], r, 0)];
        scene.camera.look_from = DVec3::new(0.0, height, 0.0);
        let dip = (r / (r + height)).acos();
        scene.camera.look_at = scene.camera.look_from + DVec3::new(0.0, -dip.sin(), -dip.cos());
        scene.camera.fov = 0.01;
        let picture = h.picture(&scene)?;
        let below = |_: DVec3, d: DVec3| u8::from((-d.y).asin() > dip);
        counts.push(wrong_pixels(&scene, &picture, 0.02, below, lit));
    }
    Ok(figure(counts))
}

fn planet_shadow(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let r = 1e6;
    let mut scene = empty(vec![matte([1.0; 3], 0.0)]);
    scene.spheres = vec![sphere([0.0, -r, 0.0], r, 0), sphere([0.0, 0.1, 0.0], 0.1, 0)];
    scene.lights = vec![light([1.0, 1.5, 0.5], 10.0)];
    scene.camera.look_from = DVec3::new(0.3, 0.7, 0.9);
    scene.camera.look_at = DVec3::new(-0.03, 0.05, 0.0);
    scene.camera.fov = 0.6;
    let blur = blur(h, &scene, 0.6 / 64.0);
    Ok(figure([wrong_spheres(h, &scene, blur)?]))
}

fn touching(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let mut counts = Vec::new();
    // A quad as floor, so that a sphere touches it in a point; small compared with an epsilon of
    // 0.1.
    let size = 0.04;
    let mut scene = empty(vec![matte([1.0; 3], 0.0)]);
    let l = 2.0 * size;
    scene.polygons = vec![polygon(&[[-l, 0.0, -l], [-l, 0.0, l], [l, 0.0, l], [l, 0.0, -l]], 0)];
    scene.spheres = vec![sphere([0.0, 0.5 * size, 0.0], 0.5 * size, 0)];
    for position in [[0.0, 3.0, 0.0], [1.0, 3.0, 0.5]] {
        for (from, fov) in [([0.0, 0.3, 2.0], 0.6), ([0.2, 0.05, 1.0], 0.2)] {
            scene.lights = vec![light(position.map(|x: f64| x * size), 10.0)];
            scene.camera.look_from = DVec3::from(from) * size;
            scene.camera.look_at = DVec3::ZERO;
            scene.camera.fov = fov;
            let blur = blur(h, &scene, scene.camera.look_from.length() * fov / 64.0);
            let picture = h.picture(&scene)?;
            counts.push(wrong_pixels(&scene, &picture, blur, |o, d| on_floor(&scene, l, o, d), lit));
        }
    }
    // Two spheres, with light and camera on opposite sides of the point of contact.
    scene.polygons.clear();
    scene.spheres = vec![sphere([-0.5, 0.0, 0.0], 0.5, 0), sphere([0.5, 0.0, 0.0], 0.5, 0)];
    scene.lights = vec![light([0.3, 0.2, -3.0], 10.0)];
    scene.camera.look_from = DVec3::new(0.0, 0.1, 1.5);
    scene.camera.fov = 0.3;
    let blur = blur(h, &scene, 0.3 / 64.0);
    counts.push(wrong_spheres(h, &scene, blur)?);
    Ok(figure(counts))
}

/// Class of a point on a floor y = 0 of half size `l` or on one sphere: lit or not.
fn on_floor(scene: &Scene, l: f64, o: DVec3, d: DVec3) -> u8 {
    let s = scene.spheres[0];
    let t = -o.y / d.y;
    let p = o + t * d;
    let floor = t > 0.0 && p.x.abs() < l && p.z.abs() < l;
    let ball = sphere_hit(o, d, s.center, s.radius);
    if let Some(t) = ball.filter(|b| !floor || *b < t) {
        let p = o + t * d;
        return u8::from((p - s.center).dot(scene.lights[0].position - p) > 0.0);
    }
    if !floor {
        return 0;
    }
    let to = scene.lights[0].position - p;
    u8::from(sphere_hit(p, to.normalize(), s.center, s.radius).is_none())
}

fn concentric(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let mut counts = Vec::new();
    for ulps in [0, 1, 2, 5, 16, 64] {
        let mut scene = empty(vec![matte([1.0, 0.0, 0.0], 0.0), matte([0.0, 1.0, 0.0], 0.0)]);
        let inner = 0.75 * (1.0 - f64::from(ulps) * 2.0 * h.u());
        scene.spheres = vec![sphere([0.0; 3], 0.75, 0), sphere([0.0; 3], inner, 0)];
        scene.lights = vec![light([3.0, 2.0, 4.0], 10.0)];
        scene.camera.look_from = DVec3::new(0.0, 0.0, 4.0);
        scene.camera.fov = 0.4;
        let picture = h.picture(&scene)?;
        let outer = Scene { spheres: vec![scene.spheres[0]], ..scene.clone() };
        counts.push(wrong_pixels(&scene, &picture, 0.02, |o, d| spheres_lit(&outer, o, d), lit));
    }
    Ok(figure(counts))
}

fn huge_and_tiny(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let r = 1e4;
    let mut counts = Vec::new();
    for size in [1e-3, 1e-1, 10.0] {
        let mut scene = empty(vec![matte([1.0; 3], 0.0)]);
        scene.spheres = vec![sphere([0.0, -r, 0.0], r, 0), sphere([0.0, size, 0.0], size, 0)];
        scene.lights = vec![light([8.0 * size, 12.0 * size, 3.0 * size], 10.0)];
        scene.camera.look_from = DVec3::new(2.0, 5.0, 8.0) * size;
        scene.camera.look_at = DVec3::ZERO;
        scene.camera.fov = 0.6;
        let blur = blur(h, &scene, 5.0 * size / 64.0);
        counts.push(wrong_spheres(h, &scene, blur)?);
    }
    Ok(figure(counts))
}

//! Rays through solids: slabs, lenses, nested solids.

use super::case::{Case, Figure, Harness, Random};
use super::optics::{follow, worst};
use crate::lab::probe::ProbeRay;
use crate::render::RenderError;
use crate::scene::procedural::shapes::{cuboid, empty, glass, matte, sphere};
use crate::scene::{Fresnel, Material, Scene};
use crate::settings::Settings;
use glam::DVec3;

/// Cases of this file.
pub const CASES: &[Case] = &[
    Case {
        name: "slab",
        does: "rays through a pane leave it parallel, shifted by t sin a (1 - cos a / (n cos b))",
        stands_for: "distorted or displaced images behind windows",
        bound: "parallel within 8u (1 + n) / cos a; shift within 16u + 4u / cos a and twice both ray offsets (numerics.md, Refraction)",
        run: slab,
    },
    Case {
        name: "ball-lens",
        does: "rays through a glass sphere turn by 2 (a - b) and keep their distance from the centre",
        stands_for: "spheres whose far side is missed, so that rays never leave them",
        bound: "64u n / cos a: 16u for each normal and 8u for each refraction and ray origin, times n / cos a at the \
                exit (numerics.md, Refraction)",
        run: ball_lens,
    },
    Case {
        name: "nested-media",
        does: "water and glass that overlap with either priority, that leave a gap, and one inside the other",
        stands_for: "dark rings where a drink meets its glass: renderers with a single inside flag, or that take the last solid entered",
        bound: "n sin a is constant within 16u at each surface; hidden surfaces change no bit (numerics.md, Media)",
        run: nested_media,
    },
    Case {
        name: "eye-in-solids",
        does: "cameras in glass, in water, in both, in neither: the relative index at the first surface",
        stands_for: "underwater cameras that refract as if in air",
        bound: "exact: the ratio of two f32 numbers, rounded once (2 ulp in Vulkan)",
        run: eye_in_solids,
    },
    Case {
        name: "shells",
        does: "8 and 10 nested shells of glass, seen from outside and from their centre",
        stands_for: "lists of media that silently overflow and continue with the wrong index",
        bound: "exact: an overflow is counted if and only if a ray enters more than 8 (numerics.md, Media)",
        run: shells,
    },
];

/// Rays from above through the origin, `cosine` at least 0.1.
fn slanted(h: &mut Harness<'_>, scene: &Scene, from: f64, count: usize) -> Vec<ProbeRay> {
    let mut random = Random::new(41);
    let frame = h.local_frame(scene);
    (0..count)
        .map(|_| {
            let c = random.range(0.1, 1.0);
            let turn = random.range(0.0, std::f64::consts::TAU);
            let s = (1.0 - c * c).sqrt();
            let d = DVec3::new(s * turn.cos(), s * turn.sin(), -c);
            let origin = DVec3::new(0.013, 0.007, from) - d * 0.2;
            ProbeRay { media: Some([0, 0]), ..ProbeRay::new(h.round(frame.point(origin)), h.round(d)) }
        })
        .collect()
}

fn slab(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let u = h.u();
    let mut figure = Figure::new(0.0, 1.0, "of the allowed error");
    for n in [1.33f64, 1.5, 2.42] {
        let n = f64::from(n as f32);
        let mut scene = empty(vec![glass(n, Fresnel::Constant(0.0))]);
        scene.meshes = vec![cuboid(DVec3::new(-8.0, -8.0, -0.25), DVec3::new(8.0, 8.0, 0.25), 0)];
        let thickness = h.local_frame(&scene).length(0.5);
        let rays = slanted(h, &scene, 0.25, 4000);
        let within: Vec<ProbeRay> = follow(h, &scene, &rays)?.into_iter().flatten().collect();
        // The exit lies farther from the middle than the entry, and its offset is larger.
        let mut offsets = vec![0.0; rays.len()];
        for side in [&rays, &within] {
            let hits = h.probe(&scene, side)?.hits;
            hits.iter().zip(&mut offsets).for_each(|(x, sum)| *sum += x.map_or(0.0, |x| x.offset.length()));
        }
        let after: Vec<ProbeRay> = follow(h, &scene, &within)?.into_iter().flatten().collect();
        if after.len() != rays.len() {
            return Ok(Figure::new(f64::INFINITY, 1.0, "rays lost in the pane"));
        }
        for ((ray, out), offset) in rays.iter().zip(&after).zip(&offsets) {
            let d = ray.direction.normalize();
            let c = -d.z;
            let error = (out.direction - d).length() / (8.0 * u * (1.0 + n) / c);
            figure = worst(figure, error, format!("of the allowed error (parallel, index {n:.2})"));
            let (s, beyond) = ((1.0 - c * c).sqrt(), (1.0 - (1.0 - c * c) / (n * n)).sqrt());
            let expected = thickness * s * (1.0 - c / (n * beyond));
            let across = out.origin - ray.origin;
            let shift = (across - d * across.dot(d)).length();
            // A hit is off its plane by some 2u, so along the ray by 2u / cos a before the ray bends, twice; and each
            // offset moves the origin by as much as the hit may be off within its plane.
            let error = (shift - expected).abs() / (16.0 * u + 4.0 * u / c + 2.0 * offset);
            figure = worst(figure, error, format!("of the allowed error (shift, index {n:.2})"));
        }
    }
    Ok(figure)
}

fn ball_lens(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let u = h.u();
    let mut figure = Figure::new(0.0, 1.0, "of the allowed error");
    for n in [0.8f64, 1.33, 1.5, 2.42] {
        let n = f64::from(n as f32);
        let mut scene = empty(vec![glass(n, Fresnel::Constant(0.0))]);
        scene.spheres = vec![sphere([0.0; 3], 1.0, 0)];
        // With one sphere only, the camera determines the local frame.
        scene.camera.look_from = DVec3::Z * 2.0;
        scene.camera.look_at = DVec3::ZERO;
        let frame = h.local_frame(&scene);
        let centre = h.local(&scene, DVec3::ZERO);
        let mut random = Random::new(42);
        let rays: Vec<ProbeRay> = (0..4000)
            .map(|_| {
                let d = random.direction();
                let side = d.any_orthonormal_vector() * random.range(0.0, 0.9 * n.min(1.0));
                ProbeRay {
                    media: Some([0, 0]),
                    ..ProbeRay::new(h.round(frame.point(side - d * 1.5)), h.round(d))
                }
            })
            .collect();
        let within: Vec<ProbeRay> = follow(h, &scene, &rays)?.into_iter().flatten().collect();
        let after: Vec<ProbeRay> = follow(h, &scene, &within)?.into_iter().flatten().collect();
        if after.len() != rays.len() {
            return Ok(Figure::new(
                f64::INFINITY,
                1.0,
                format!("{} of {} rays enter, {} leave, index {n}", within.len(), rays.len(), after.len()),
            ));
        }
        for (ray, out) in rays.iter().zip(&after) {
            let impact = |r: &ProbeRay| {
                (r.origin - centre).cross(r.direction.normalize()).length() / frame.length(1.0)
            };
            let height = impact(ray);
            let (a, b) = (height.asin(), (height / n).asin());
            let bound = 64.0 * u * n.max(1.0 / n) / a.cos().min(b.cos());
            let d = ray.direction.normalize();
            // The angle from its sine and cosine: acos alone loses half the digits at 0.
            let turned = d.cross(out.direction).length().atan2(d.dot(out.direction));
            let error = (turned - 2.0 * (a - b).abs()).abs() / bound;
            figure = worst(figure, error, format!("of the allowed error (angle, index {n:.2})"));
            let error = (impact(out) - height).abs() / bound;
            figure = worst(
                figure,
                error,
                format!("of the allowed error (distance from the centre, index {n:.2})"),
            );
        }
    }
    Ok(figure)
}

/// Two solids that a ray from above crosses.
struct Layers {
    /// Bottom and top of the glass, and of the water.
    faces: [[f64; 2]; 2],
    priorities: [i32; 2],
    /// Index below each surface, from the top; 0 = the surface is hidden.
    beyond: [f64; 4],
}

const GLASS: f64 = 1.5;
const WATER: f64 = 1.33;

const LAYERS: [Layers; 6] = [
    // Overlapping: glass has the higher priority, then water, then the last one entered.
    Layers { faces: [[-0.1, 0.5], [-0.5, 0.1]], priorities: [1, 0], beyond: [GLASS, 0.0, WATER, 1.0] },
    Layers { faces: [[-0.1, 0.5], [-0.5, 0.1]], priorities: [0, 1], beyond: [GLASS, WATER, 0.0, 1.0] },
    Layers { faces: [[-0.1, 0.5], [-0.5, 0.1]], priorities: [5, 5], beyond: [GLASS, WATER, WATER, 1.0] },
    // A gap of air.
    Layers { faces: [[0.0001, 0.5], [-0.5, 0.0]], priorities: [1, 0], beyond: [GLASS, 1.0, WATER, 1.0] },
    // Water inside glass with the higher priority for water, and for glass.
    Layers { faces: [[-0.5, 0.5], [-0.2, 0.2]], priorities: [0, 0], beyond: [GLASS, WATER, GLASS, 1.0] },
    Layers { faces: [[-0.5, 0.5], [-0.2, 0.2]], priorities: [0, -1], beyond: [GLASS, 0.0, 0.0, 1.0] },
];

fn layered(layers: &Layers) -> Scene {
    let material = |n, priority| Material { priority, ..glass(n, Fresnel::Exact) };
    let mut s = empty(vec![material(GLASS, layers.priorities[0]), material(WATER, layers.priorities[1])]);
    let block = |[lo, hi]: [f64; 2], m| cuboid(DVec3::new(-8.0, -8.0, lo), DVec3::new(8.0, 8.0, hi), m);
    s.meshes = vec![block(layers.faces[0], 0), block(layers.faces[1], 1)];
    s
}

fn nested_media(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let u = h.u();
    let mut figure = Figure::new(0.0, 1.0, "of the allowed error");
    for (i, layers) in LAYERS.iter().enumerate() {
        let scene = layered(layers);
        let start = slanted(h, &scene, 0.5, 1000);
        let mut rays = start.clone();
        for (face, beyond) in layers.beyond.iter().enumerate() {
            let next: Vec<ProbeRay> = follow(h, &scene, &rays)?.into_iter().flatten().collect();
            if next.len() != start.len() {
                return Ok(Figure::new(
                    f64::INFINITY,
                    1.0,
                    format!("rays lost at face {face} of layers {i}"),
                ));
            }
            for ((first, before), after) in start.iter().zip(&rays).zip(&next) {
                let error = if *beyond == 0.0 {
                    f64::from(u8::from(after.direction != before.direction)) * 2.0
                } else {
                    let d = first.direction.normalize();
                    let n = f64::from(*beyond as f32);
                    let along = |v: DVec3| DVec3::new(v.x, v.y, 0.0);
                    // Each surface so far adds its own 16u, in units of n sin.
                    (n * along(after.direction) - along(d)).length() / (16.0 * u * GLASS * (face + 1) as f64)
                };
                figure = worst(figure, error, format!("of the allowed error (at face {face} of layers {i})"));
            }
            rays = next;
        }
    }
    Ok(figure)
}

fn eye_in_solids(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let u = h.u();
    let mut figure = Figure::new(0.0, 1.0, "of the allowed error");
    // Water has the higher priority in the overlap: its far face is the first visible surface.
    let overlapping = layered(&LAYERS[1]);
    let within = layered(&LAYERS[4]);
    let cases = [
        (&overlapping, 2.0, [1.0, GLASS]),
        (&overlapping, 0.3, [GLASS, WATER]),
        (&overlapping, 0.0, [1.0, 1.0]),
        (&overlapping, -0.3, [WATER, 1.0]),
        (&within, 0.4, [GLASS, WATER]),
        (&within, 0.0, [WATER, GLASS]),
        (&within, -0.4, [GLASS, 1.0]),
    ];
    for (scene, z, [here, beyond]) in cases {
        let mut scene = scene.clone();
        scene.camera.look_from = DVec3::new(0.013, 0.007, z);
        scene.camera.look_at = DVec3::new(0.013, 0.007, z - 1.0);
        let ray = ProbeRay::new(h.local(&scene, scene.camera.look_from), DVec3::NEG_Z);
        let eta = h.probe(&scene, &[ray])?.hits[0].map_or(f64::NAN, |hit| hit.eta);
        let expected = f64::from(here as f32) / f64::from(beyond as f32);
        let error = (eta - expected).abs() / (expected * 5.0 * u);
        figure = worst(figure, error, format!("of the allowed error (camera at z = {z})"));
    }
    Ok(figure)
}

fn shells(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let mut wrong = 0;
    for (count, eye) in [(8u32, 40.0), (10, 40.0), (8, 0.0), (10, 0.0)] {
        let mut scene =
            empty((0..count).map(|i| glass(1.1 + 0.1 * f64::from(i), Fresnel::Constant(0.0))).collect());
        scene.materials.push(matte([1.0; 3], 1.0));
        let radius = |i: u32| f64::from(count - i);
        scene.spheres = (0..count).map(|i| sphere([0.0; 3], radius(i), i as usize)).collect();
        scene.render.background = DVec3::ONE;
        scene.camera.look_from = DVec3::Z * eye;
        scene.camera.look_at = DVec3::NEG_Z;
        scene.camera.fov = 0.01;
        let settings = Settings { width: 4, height: 4, depth: 2 * count + 2, ..h.settings(&scene) };
        let picture = h.picture_with(&scene, &settings)?;
        let lit = picture.linear.iter().all(|p| *p == [1.0; 3]);
        let counted = picture.counters.media_overflow > 0;
        wrong += usize::from(counted != (count > 8)) + usize::from(count == 8 && !lit);
    }
    Ok(Figure::count(wrong, 4, "views wrong"))
}

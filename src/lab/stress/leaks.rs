//! Light leaks and missing light: contacts, thin gaps, corners, lights on surfaces.

use super::case::{Case, Figure, Harness, Random};
use super::origins::{escapes, plate, turned_box};
use super::pixels::{blur, lit, wrong_pixels};
use crate::lab::probe::ProbeRay;
use crate::render::RenderError;
use crate::scene::procedural::shapes::{cuboid, empty, glass, light, matte};
use crate::scene::{Fresnel, Scene};
use glam::DVec3;

/// Cases of this file.
pub const CASES: &[Case] = &[
    Case {
        name: "contact-shadow",
        does: "a wall 10^-3 thick on a floor, lit at 45 degrees; the base of its shadow seen from the side",
        stands_for: "shadows detached from their object: an epsilon of 0.1 is 2 pixels here",
        bound: "exact, except within 0.02 pixels and the ray offset, (4u |p| + 24u ext) sqrt 3, of edges (numerics.md, Spawn origins)",
        run: contact_shadow,
    },
    Case {
        name: "thin-gap",
        does: "a floor seen through a clear sheet that lies 10^-5 of the scene's size above it and casts a shadow",
        stands_for: "ray epsilons larger than a gap",
        bound: "exact: no light passes a gap larger than twice the ray offset, 8u |p| + 48u ext = 4 10^-6 (numerics.md, Spawn origins)",
        run: thin_gap,
    },
    Case {
        name: "corner-escape",
        does: "a closed, rotated mirror box, hit exactly at its edges and corners: paths of 12 bounces",
        stands_for: "light that escapes where walls meet",
        bound: "exact: no path escapes (numerics.md, Spawn origins)",
        run: corner_escape,
    },
    Case {
        name: "dark-room",
        does: "a closed room without lights, pixel centres exactly on its edges, and eight bright lights just outside its corners",
        stands_for: "bright seams along the edges of rooms",
        bound: "exact: every pixel is black",
        run: dark_room,
    },
    Case {
        name: "light-at-surface",
        does: "lights 8u above a floor, on it, on its corner, on a sphere, at the camera",
        stands_for: "fireflies and NaN pixels from a division by the square of a zero distance",
        bound: "exact: every pixel is finite, and the clamped light is counted (numerics.md, Shading)",
        run: light_contact,
    },
    Case {
        name: "light-on-ceiling",
        does: "the floor below a light exactly on the ceiling of a room, axis-aligned and rotated",
        stands_for: "speckled floors: the ceiling shadows its own lamp where t rounds below 1",
        bound: "exact: every floor pixel is lit, since nothing is strictly between it and the light",
        run: light_on_ceiling,
    },
];

/// True if the segment from p to q meets the box.
fn box_between(p: DVec3, q: DVec3, lo: DVec3, hi: DVec3) -> bool {
    let d = q - p;
    let (mut near, mut far) = (0.0f64, 1.0f64);
    for i in 0..3 {
        let (a, b) = ((lo[i] - p[i]) / d[i], (hi[i] - p[i]) / d[i]);
        near = near.max(a.min(b));
        far = far.min(a.max(b));
    }
    near < far
}

fn contact_shadow(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let (lo, hi, l) = (DVec3::new(0.499, 0.0, -0.5), DVec3::new(0.5, 1.0, 0.5), 4.0);
    let mut scene = empty(vec![matte([1.0, 0.0, 0.0], 0.0), matte([0.0; 3], 0.0)]);
    scene.polygons = vec![plate(l, 0.0, 0)];
    scene.meshes = vec![cuboid(lo, hi, 1)];
    let (mut wrong, mut judged) = (0, 0);
    for (from, at, fov) in [([3.0, 2.5, 1.0], [0.8, 0.0, 0.0], 0.6), ([1.2, 0.3, 0.1], [0.5, 0.0, 0.0], 0.1)]
    {
        // From behind the wall: the shadow starts at the edge x = 0.5 and reaches x = 1.5.
        scene.lights = vec![light([-9.5, 11.0, 0.3], 100.0)];
        scene.camera.look_from = from.into();
        scene.camera.look_at = at.into();
        scene.camera.fov = fov;
        let distance = (scene.camera.look_from - scene.camera.look_at).length();
        let blur = blur(h, &scene, distance * fov / 64.0);
        let picture = h.picture(&scene)?;
        let source = scene.lights[0].position;
        let class = |o: DVec3, d: DVec3| {
            let t = -o.y / d.y;
            let p = o + t * d;
            let floor = t > 0.0 && p.x.abs() < l && p.z.abs() < l && !box_between(o, p, lo, hi);
            u8::from(floor && !box_between(p, source, lo, hi))
        };
        let r = wrong_pixels(&scene, &picture, blur, class, lit);
        (wrong, judged) = (wrong + r.0, judged + r.1);
    }
    Ok(Figure::count(wrong, judged, "pixels wrong"))
}

fn thin_gap(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let mut wrong = 0;
    let gaps = [1.0, 0.05, 1e-2, 1e-4, 1e-5, 5e-6];
    for gap in gaps {
        let mut scene = empty(vec![matte([1.0; 3], 0.0), glass(1.0, Fresnel::Constant(0.0))]);
        // Half diagonal near 1: the gap is in units of the scene.
        scene.polygons = vec![plate(0.7, 0.0, 0), plate(0.7, gap, 1)];
        scene.lights = vec![light([0.2, 3.0, 0.1], 10.0)];
        scene.camera.look_from = DVec3::new(0.1, 0.4 + gap, 1.5);
        scene.camera.look_at = DVec3::ZERO;
        scene.camera.fov = 0.3;
        scene.render.depth = 2;
        let picture = h.picture(&scene)?;
        wrong += picture.linear.iter().filter(|c| lit(**c) != 0).count();
    }
    Ok(Figure::count(wrong, gaps.len() * 64 * 64, "pixels lit"))
}

fn corner_escape(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let scene = turned_box();
    let (paths, bounces) = (6000, 12);
    let mut random = Random::new(40);
    let corners: Vec<DVec3> = scene.meshes[0].vertices.iter().map(|v| h.local(&scene, *v)).collect();
    let rays = (0..paths)
        .map(|i| {
            let a = (random.unit() * 8.0) as usize;
            let s = random.unit();
            // A corner, or an edge of the box: corners whose numbers differ in one bit.
            let b = a ^ (1 << (i / 3 % 3));
            let target = if i % 3 == 0 { corners[a] } else { corners[a] * (1.0 - s) + corners[b] * s };
            let origin = h.local(&scene, random.direction() * 0.4);
            ProbeRay::new(origin, h.round((target - origin).normalize()))
        })
        .collect();
    let escaped = escapes(h, &scene, rays, bounces)?;
    Ok(Figure::count(escaped, paths, &format!("paths of {bounces} bounces escaped")))
}

fn dark_room(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let mut scene = empty(vec![matte([1.0; 3], 0.0)]);
    scene.meshes = vec![cuboid(DVec3::splat(-1.0), DVec3::ONE, 0)];
    for i in 0..8 {
        let sign = |bit: usize| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
        scene.lights.push(light([1.5 * sign(0), 1.2 * sign(1), 1.7 * sign(2)], 1e6));
    }
    scene.camera.look_from = DVec3::ZERO;
    scene.camera.look_at = DVec3::NEG_Z;
    // Pixels on the diagonals look along (s, s, -1): onto the edges where s > 1.
    scene.camera.fov = 2.0 * 3f64.atan();
    scene.render.background = DVec3::ONE;
    let mut bright = 0;
    let turned = turned_room(&scene);
    for scene in [&scene, &turned] {
        bright += h.picture(scene)?.linear.iter().filter(|c| lit(**c) != 0).count();
    }
    Ok(Figure::count(bright, 2 * 64 * 64, "pixels not black"))
}

/// Room, lights and camera rotated by (0.6, 0.8) and (0.28, 0.96), so that no wall is parallel to
/// an axis.
fn turned_room(scene: &Scene) -> Scene {
    let mut s = scene.clone();
    let turn = |v: DVec3| {
        let w = DVec3::new(0.6 * v.x - 0.8 * v.y, 0.8 * v.x + 0.6 * v.y, v.z);
        DVec3::new(w.x, 0.28 * w.y - 0.96 * w.z, 0.96 * w.y + 0.28 * w.z)
    };
    s.meshes.iter_mut().flat_map(|m| &mut m.vertices).for_each(|v| *v = turn(*v));
    s.polygons.iter_mut().flat_map(|p| &mut p.vertices).for_each(|v| *v = turn(*v));
    s.polygons.iter_mut().for_each(|p| p.normal = turn(p.normal));
    s.lights.iter_mut().for_each(|l| l.position = turn(l.position));
    s.camera.look_from = turn(s.camera.look_from);
    s.camera.look_at = turn(s.camera.look_at);
    s.camera.up = turn(s.camera.up);
    s
}

fn light_contact(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let mut base = empty(vec![matte([1.0, 0.5, 0.0], 0.1)]);
    base.polygons = vec![plate(1.0, 0.0, 0)];
    base.spheres = vec![crate::scene::procedural::shapes::sphere([0.5, 0.5, 0.0], 0.25, 0)];
    // An odd number of pixels, so that the middle one looks exactly at the light.
    (base.camera.width, base.camera.height) = (65, 65);
    let eye = DVec3::new(0.0, 1.5, 2.0);
    base.camera.look_from = eye;
    let (mut infinite, mut clamped) = (0, 0);
    // Closer than the ray offset, farther than rounding: 8u in a scene of size 1.
    let tiny = 8.0 * h.u();
    for place in
        [[-0.3, tiny, 0.1], [0.0; 3], [0.25, 0.0, 0.25], [1.0, 0.0, 1.0], [0.5, 0.75, 0.0], eye.to_array()]
    {
        let mut scene = base.clone();
        scene.lights = vec![light(place, 1.0)];
        if place[1] == tiny {
            // Straight down, so that the middle ray hits the floor right below the light.
            scene.camera.look_from = DVec3::new(-0.3, 2.0, 0.1);
            scene.camera.up = DVec3::NEG_Z;
        }
        scene.camera.look_at = if place == eye.to_array() { DVec3::ZERO } else { place.into() };
        let picture = h.picture(&scene)?;
        infinite += picture.linear.iter().filter(|c| lit(**c) == 2).count();
        clamped += picture.counters.clamped_lights;
    }
    if clamped == 0 {
        return Ok(Figure::new(f64::INFINITY, 0.0, "the clamped light was not counted"));
    }
    Ok(Figure::none(infinite, "pixels not finite"))
}

fn light_on_ceiling(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let mut scene = empty(vec![matte([1.0; 3], 0.0), matte([0.0; 3], 0.0)]);
    scene.polygons = vec![plate(3.0, 0.0, 0), plate(3.0, 2.3, 1)];
    scene.lights = vec![light([0.37, 2.3, -0.11], 10.0)];
    scene.camera.look_from = DVec3::new(0.1, 2.0, 0.2);
    scene.camera.look_at = DVec3::ZERO;
    scene.camera.fov = 1.5;
    let turned = turned_room(&scene);
    let mut black = 0;
    for scene in [&scene, &turned] {
        black += h.picture(scene)?.linear.iter().filter(|c| lit(**c) != 1).count();
    }
    Ok(Figure::count(black, 2 * 64 * 64, "pixels black"))
}

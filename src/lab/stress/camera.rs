//! Cameras at degenerate positions.

use super::case::{Case, Figure, Harness};
use crate::render::RenderError;
use crate::scene::Scene;
use crate::scene::procedural::shapes::{empty, light, matte, polygon, room};
use crate::settings::Settings;
use glam::{DQuat, DVec3};

/// Cases of this file.
pub const CASES: &[Case] = &[
    Case {
        name: "field-of-view",
        does: "a rotated board of stripes that fills horizontal fields of view from 179 to 1e-5 degrees: every edge in the right pixel",
        stands_for: "distant cameras whose ray origins are rounded to a coarse grid: CAD views with long lenses break up",
        bound: "edges within 0.05 pixels, of 512 (numerics.md, Camera); at 179 degrees the rounding of the corners, 8u tan, is half of that",
        run: field_of_view,
    },
    Case {
        name: "eye-places",
        does: "a camera on a vertex, on a wall, on a sphere, at a sphere's centre, at the light, looking along walls, with an up vector almost along the view",
        stands_for: "black, white or noisy frames when a camera path touches geometry",
        bound: "exact: every pixel is finite and no ray has a NaN (numerics.md, Camera)",
        run: eye_places,
    },
];

const WIDTH: u32 = 512;
const HEIGHT: u32 = 8;
/// Width of a stripe, pixels.
const STRIPE: u32 = 8;

/// Position of edge `i` in pixels: a twentieth of a pixel from a pixel's centre, on alternating
/// sides.
fn edge(i: u32) -> f64 {
    f64::from(STRIPE * i) + 0.5 + if i.is_multiple_of(2) { 0.05 } else { -0.05 }
}

/// Stripes of 0.2 and 0.8 on a rotated plane one metre wide that fills a horizontal field of view.
fn striped(degrees: f64) -> Scene {
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.7);
    let mut s = empty(vec![matte([0.2; 3], 1.0), matte([0.8; 3], 1.0)]);
    // Half the width of the board is 1/2 metre.
    let aspect = f64::from(WIDTH) / f64::from(HEIGHT);
    let half = (degrees / 2.0).to_radians().tan();
    s.camera.fov = 2.0 * (half / aspect).atan();
    let distance = 0.5 / half;
    s.camera.look_from = turn * (DVec3::Z * distance);
    s.camera.look_at = DVec3::ZERO;
    s.camera.up = turn * DVec3::Y;
    let across = |pixels: f64| pixels / f64::from(WIDTH) - 0.5;
    for i in 0..WIDTH / STRIPE {
        let x0 = if i == 0 { -0.6 } else { across(edge(i)) };
        let x1 = if i + 1 == WIDTH / STRIPE { 0.6 } else { across(edge(i + 1)) };
        let mut quad =
            polygon(&[[x0, -0.1, 0.0], [x1, -0.1, 0.0], [x1, 0.1, 0.0], [x0, 0.1, 0.0]], (i % 2) as usize);
        quad.vertices.iter_mut().for_each(|v| *v = turn * *v);
        quad.normal = turn * quad.normal;
        s.polygons.push(quad);
    }
    s
}

fn field_of_view(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let mut wrong = 0;
    let angles = [179.0, 120.0, 10.0, 1.0, 0.1, 1e-2, 1e-3, 1e-4, 1e-5];
    for degrees in angles {
        let scene = striped(degrees);
        let settings = Settings { width: WIDTH, height: HEIGHT, ..h.settings(&scene) };
        let picture = h.picture_with(&scene, &settings)?.linear;
        for row in picture.chunks(WIDTH as usize) {
            wrong += (0..WIDTH)
                .filter(|x| {
                    let stripe = (1..WIDTH / STRIPE).filter(|i| edge(*i) <= f64::from(*x) + 0.5).count();
                    row[*x as usize] != [if stripe % 2 == 0 { 0.2f32 } else { 0.8 }; 3]
                })
                .count();
        }
    }
    let pixels = (WIDTH * HEIGHT) as usize * angles.len();
    Ok(Figure::count(wrong, pixels, "pixels on the wrong side of an edge"))
}

fn eye_places(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let mut wrong = 0;
    let mut count = 0;
    let ball = DVec3::new(2.0, -3.0, -1.0);
    let bulb = DVec3::new(0.0, 4.0, 1.0);
    let ahead = DVec3::new(0.0, 0.0, -1.0);
    let places = [
        // A corner of the room, a point on its floor and on its mirror.
        (DVec3::splat(-5.0), DVec3::ONE),
        (DVec3::new(1.0, -5.0, 1.0), ahead),
        (DVec3::new(1.0, -5.0, 1.0), DVec3::Y),
        (DVec3::new(1.0, -5.0, 1.0), DVec3::NEG_Y),
        (DVec3::new(0.5, 0.5, -5.0), DVec3::X),
        (DVec3::new(0.5, 0.5, -5.0), DVec3::Z),
        // A vertex, an edge and a face of the box.
        (DVec3::new(-1.3, -2.4, -1.0), ahead),
        (DVec3::new(-2.0, -2.4, -1.0), DVec3::new(1.0, 0.0, 0.0)),
        (DVec3::new(-2.0, -2.4, -2.0), DVec3::NEG_Y),
        // On the glass sphere, at its centre, and just inside it.
        (ball + DVec3::Z * 1.9, ahead),
        (ball + DVec3::Z * 1.9, DVec3::X),
        (ball, ahead),
        (ball + DVec3::Z * (1.9 - 1e-12), DVec3::Z),
        (bulb, ahead),
        (bulb, DVec3::NEG_Y),
    ];
    for (from, toward) in places {
        for up in [DVec3::Y, toward + DVec3::new(1e-6, 2e-6, 1e-6), DVec3::new(1e-30, 2e-30, 3e-30)] {
            if up.cross(toward).length() <= up.length() * 1e-9 {
                continue;
            }
            let mut scene = room();
            scene.camera.look_from = from;
            scene.camera.look_at = from + toward;
            scene.camera.up = up;
            scene.camera.fov = 2.0;
            // One more light at the camera, and one very close to it.
            scene.lights.push(light(from.to_array(), 1.0));
            scene.lights.push(light((from + DVec3::Y * 1e-15).to_array(), 1.0));
            let settings = Settings { width: 24, height: 24, depth: 3, ..h.settings(&scene) };
            let picture = h.picture_with(&scene, &settings)?;
            wrong += picture.linear.iter().filter(|p| p.iter().any(|x| !x.is_finite() || *x < 0.0)).count();
            wrong += picture.counters.nan_rays as usize;
            count += picture.linear.len();
        }
    }
    // A light on a plane, seen from the plane: its distance must be clamped.
    let mut scene = empty(vec![matte([1.0; 3], 0.0)]);
    scene.polygons =
        vec![polygon(&[[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]], 0)];
    scene.camera.look_from = DVec3::Z * 0.5;
    scene.lights = vec![light([0.0, 0.0, 1e-30], 1.0)];
    let settings = Settings { width: 33, height: 33, ..h.settings(&scene) };
    let picture = h.picture_with(&scene, &settings)?;
    wrong += picture.linear.iter().filter(|p| p.iter().any(|x| !x.is_finite())).count();
    Ok(Figure::count(wrong, count + picture.linear.len(), "pixels and rays wrong"))
}

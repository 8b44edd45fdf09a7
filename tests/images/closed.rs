//! Closed forms (numerics.md, Closed forms), rendered on the device.

use crate::common::build::{Add, clear, glass, matte, mirror, scene, v};
use crate::common::{render, renderer, scenes, small};
use glam::DVec3;
use whitted::render::Renderer;
use whitted::scene::{Fresnel, Scene};
use whitted::settings::Settings;

/// The ray from `from` to `at`, the middle of a one-pixel image.
fn probe(renderer: &mut Renderer, scene: &Scene, from: DVec3, at: DVec3, depth: u32) -> [f32; 3] {
    let mut scene = scene.clone();
    scene.look(from, at);
    let settings = Settings { width: 1, height: 1, samples: 1, depth, ..Settings::of(&scene) };
    render(renderer, &scene, &settings).linear[0]
}

#[test]
fn light_falls_with_the_square_of_distance_exactly() {
    let mut renderer = renderer();
    // A triangle around the origin, met at weights 3/8 and 1/2: every number on the way is exact.
    let mut s = scene();
    let white = s.material(matte());
    s.polygon(&[v(-2.0, -2.0, 0.0), v(2.0, -2.0, 0.0), v(-1.0, 2.0, 0.0)], white);
    for k in -6..8 {
        let height = 2f64.powi(k);
        let mut lit = s.clone();
        lit.light(DVec3::Z * height, v(9.0, 3.5, 0.75));
        let found = probe(&mut renderer, &lit, DVec3::Z * 4.0, DVec3::ZERO, 1);
        let expected = [9.0, 3.5, 0.75].map(|i: f64| (i / (height * height)) as f32);
        assert_eq!(found, expected, "at 2^{k}");
    }
}

#[test]
fn a_furnace_hides_its_mirrors() {
    let mut renderer = renderer();
    let (_, s) = scenes().into_iter().find(|(name, _)| name == "furnace").unwrap();
    let background = s.render.background.as_vec3().to_array();
    let image = render(&mut renderer, &s, &small(&s, 64, 4, 5));
    assert!(image.report.rays.reflection > 1000, "the sphere is out of the picture");
    assert!(image.linear.iter().all(|p| *p == background), "a mirror shows in uniform light");
}

#[test]
fn a_furnace_hides_glass_but_for_rounding() {
    let mut renderer = renderer();
    for fresnel in [Fresnel::Schlick, Fresnel::Exact] {
        let mut s = scene();
        let ball = s.material(glass(1.5, fresnel));
        s.sphere(v(0.0, 0.0, 4.0), 1.0, ball);
        // Opaque shading adds nothing; each cut ray loses its light, so the depth must be large.
        s.render.background = DVec3::ONE;
        s.render.depth = 12;
        s.camera.fov = 0.3;
        let settings = Settings { width: 24, height: 24, samples: 1, ..Settings::of(&s) };
        for p in &render(&mut renderer, &s, &settings).linear {
            // Inside, each reflection keeps at most a share of 0.1 near the middle of the ball;
            // what is cut after 12 is below 1e-9, the sums round a few times.
            assert!((p[0] - 1.0).abs() < 2e-6, "{p:?} with {fresnel:?}");
        }
    }
}

#[test]
fn a_plane_mirror_shows_the_mirrored_scene() {
    let mut renderer = renderer();
    let side = |sign: f64, with_mirror: bool| {
        let mut s = scene();
        let white = s.material(matte());
        let red = s.material(whitted::scene::Material { diffuse: v(0.9, 0.2, 0.1), ambient: 0.2, ..matte() });
        let silver = s.material(mirror(1.0));
        let at = |x: f64, y: f64, z: f64| v(x, y, sign * z);
        s.rectangle(at(0.0, -2.0, 9.0), v(7.0, 0.0, 0.0), v(0.0, 0.0, 4.0), white);
        s.rectangle(at(0.0, 0.0, 12.0), v(7.0, 0.0, 0.0), v(0.0, 5.0, 0.0), white);
        s.sphere(at(-1.0, -0.5, 8.0), 1.25, red);
        s.sphere(at(1.7, -1.0, 7.0), 0.9, white);
        s.light(at(3.0, 4.0, 6.0), DVec3::splat(20.0));
        if with_mirror {
            s.rectangle(DVec3::ZERO, v(3.0, 0.0, 0.0), v(0.0, 3.0, 0.0), silver);
        }
        s.look(v(0.2, 0.1, 4.0), v(0.1, -0.1, 0.0));
        s.camera.fov = 0.7;
        let settings = Settings { width: 64, height: 48, samples: 2, depth: 2, ..Settings::of(&s) };
        (s, settings)
    };
    let (seen, settings) = side(1.0, true);
    let (mirrored, _) = side(-1.0, false);
    let [a, b] = [seen, mirrored].map(|s| render(&mut renderer, &s, &settings).linear);
    // Two hits, each off by up to 16 * 2^-24 of the scene's 12 metres; a light 3 metres away or more,
    // whose law of inverse squares and cosine make four times that of it: 3e-5.
    let far = |a: &[f32; 3], b: &[f32; 3]| (0..3).any(|c| (a[c] - b[c]).abs() > 3e-5 * (0.01 + b[c]));
    let different = a.iter().zip(&b).filter(|(a, b)| far(a, b)).count();
    // Rounding may move an edge: some 400 pixels of edges and shadow edges, bound of numerics.md, Bounds in tests.
    assert!(different <= 5, "{different} pixels differ from the mirrored scene");
    let shifted = a[1..].iter().zip(&b).filter(|(a, b)| far(a, b)).count();
    assert!(shifted > 1000, "an image shifted by one pixel passes");
}

#[test]
fn a_slab_shifts_what_lies_beneath() {
    let mut renderer = renderer();
    let light = v(1.5, 1.0, 0.5);
    let mut bare = scene();
    let white = bare.material(matte());
    bare.rectangle(DVec3::ZERO, v(0.0, 0.0, 7.0), v(7.0, 0.0, 0.0), white);
    bare.light(light, DVec3::splat(5.0));
    let mut slab = bare.clone();
    let ice = slab.material(clear(1.5));
    slab.cuboid(v(-5.0, 2.0, -5.0), v(5.0, 3.0, 5.0), ice);
    let under = |x: f64| {
        let to = light - v(x, 0.0, 0.0);
        5.0 * to.y / to.length().powi(3)
    };
    for slope in [0.0, 0.1, 0.45, 0.9, 1.1] {
        let eye = v(0.01, 6.0, 0.0);
        let sine = slope / f64::hypot(1.0, slope) / 1.5;
        let shifted = 0.01 + 5.0 * slope + sine / (1.0 - sine * sine).sqrt();
        let found = probe(&mut renderer, &slab, eye, eye + v(slope, -1.0, 0.0), 3)[0];
        let expected = under(shifted);
        // Three hits, each off by up to 16 * 2^-24 of the scene's 10 metres; the light is 1 metre
        // above the floor, and its law of inverse squares and cosine make four times that of it.
        assert!((f64::from(found) / expected - 1.0).abs() < 1.1e-4, "slope {slope}: {found}, not {expected}");
        let straight = probe(&mut renderer, &bare, eye, eye + v(slope, -1.0, 0.0), 3)[0];
        assert!(slope == 0.0 || (straight / found - 1.0).abs() > 1e-2, "slope {slope}: no shift");
    }
}

#[test]
fn light_leaves_glass_up_to_the_critical_angle() {
    let mut renderer = renderer();
    let mut s = scene();
    let ice = s.material(clear(1.5));
    s.cuboid(DVec3::splat(-50.0), DVec3::splat(50.0), ice);
    s.render.background = DVec3::ONE;
    // Across the angle, 64 pixels wide and 0.6 degrees to each side, off the faces' diagonals.
    let critical = (1.0f64 / 1.5).asin();
    let forward = v(critical.sin(), 0.0, critical.cos());
    s.look(v(0.1, 0.3, 0.0), v(0.1, 0.3, 0.0) + forward);
    s.camera.fov = 2.0 * (0.01f64 / 64.0).atan();
    let settings = Settings { width: 64, height: 1, samples: 1, depth: 2, ..Settings::of(&s) };
    let image = render(&mut renderer, &s, &settings).linear;
    let right = forward.cross(DVec3::Y).normalize();
    let mut out = 0;
    for (x, found) in image.iter().enumerate() {
        let direction = forward + right * (0.01 * ((x as f64 + 0.5) / 32.0 - 1.0));
        let leaves = direction.normalize().x < 1.0 / 1.5;
        out += u32::from(leaves);
        assert_eq!(found[0], if leaves { 1.0 } else { 0.0 }, "pixel {x}");
    }
    assert_eq!(out, 32);
}

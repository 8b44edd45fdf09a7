//! Reflection: mirror images, series, furnaces.

use crate::build::{Add, assert_close, glowing, matte, mirror, probe, scene, v};
use glam::DVec3;
use whitted::reference::oracle::Oracle;
use whitted::scene::{Camera, Material, Scene};
use whitted::settings::Settings;

/// Things in front of a wall at z = 0, mirrored behind it where `flip` is -1.
fn things(flip: f64) -> Scene {
    let mut s = scene();
    let white = s.material(Material { diffuse: v(0.9, 0.6, 0.3), ..glowing(0.2) });
    let at = |x: f64, y: f64, z: f64| v(x, y, z * flip);
    s.sphere(at(0.3, -0.2, 2.0), 0.5, white);
    s.sphere(at(-0.7, 0.2, 1.5), 0.3, white);
    s.polygon(&[at(-4.0, -1.0, 0.5), at(4.0, -1.0, 0.5), at(4.0, -1.0, 4.0), at(-4.0, -1.0, 4.0)], white);
    s.light(at(1.0, 3.0, 2.5), v(5.0, 6.0, 7.0));
    // High above all the things, so that none is seen but in the wall.
    s.camera = Camera {
        look_from: v(0.1, 2.5, 4.0),
        look_at: DVec3::ZERO,
        fov: 0.2,
        width: 60,
        height: 50,
        ..s.camera
    };
    s
}

#[test]
fn a_plane_mirror_shows_the_mirrored_scene() {
    let mut real = things(1.0);
    let silver = real.material(mirror(1.0));
    real.rectangle(DVec3::ZERO, DVec3::X * 9.0, DVec3::Y * 9.0, silver);
    let settings = Settings { samples: 2, depth: 2, ..Settings::of(&real) };
    let seen = Oracle::new(&real).render(&settings);
    let wall = [Some(2), Some(3)];
    assert!(seen.first_hit.iter().all(|id| wall.contains(id)));
    let image = things(-1.0);
    let expected = Oracle::new(&image).render(&Settings { depth: 1, ..settings });
    let mut lit = 0;
    for (a, b) in seen.linear.iter().zip(&expected.linear) {
        assert!((*a - *b).length() < 1e-12, "{a} {b}");
        lit += usize::from(a.length() > 0.1);
    }
    assert!(lit > 500, "only {lit} pixels show anything");
}

#[test]
fn facing_mirrors_give_a_geometric_series() {
    for rho in [0.5, 0.9, 0.99] {
        let mut s = scene();
        let silver = s.material(Material { secondary: rho, ..glowing(0.7) });
        s.rectangle(v(0.0, 0.0, -1.0), DVec3::X * 1e3, DVec3::Y * 1e3, silver);
        s.rectangle(v(0.0, 0.0, 1.0), DVec3::X * 1e3, DVec3::Y * 1e3, silver);
        for depth in [1, 2, 3, 10, 60] {
            let seen = probe(&s, DVec3::ZERO, v(0.3, 0.2, 1.0), depth).radiance.x;
            let own = (1.0 - rho) * 0.7;
            let expected = own * (1.0 - rho.powi(depth as i32)) / (1.0 - rho);
            assert_close(seen, expected, 1e-16 * f64::from(8 * (depth + 1)));
        }
    }
}

#[test]
fn a_mirror_ball_vanishes_in_a_uniform_furnace() {
    let mut s = scene();
    let silver = s.material(mirror(1.0));
    s.sphere(v(0.0, 0.0, 4.0), 1.0, silver);
    s.render.background = v(0.25, 0.5, 0.75);
    s.camera.fov = 0.6;
    let settings = Settings { width: 40, height: 40, samples: 2, depth: 2, ..Settings::of(&s) };
    let image = Oracle::new(&s).render(&settings);
    assert!(image.linear.iter().all(|&c| c == s.render.background));
    assert_eq!(image.rays.reflection, image.first_hit.iter().flatten().count() as u64);
    assert_eq!((image.rays.refraction, image.rays.shadow), (0, 0));
}

#[test]
fn inside_a_closed_mirror_box_nothing_escapes() {
    for far in [0.0, 1e4] {
        let mut s = scene();
        let silver = s.material(mirror(1.0));
        let at = v(far, -far, far / 3.0);
        s.cuboid(at - v(1.0, 1.1, 1.2), at + v(1.3, 1.0, 0.9), silver);
        s.render.background = DVec3::ONE;
        for i in 0..200 {
            let a = f64::from(i) * 0.37;
            let seen = probe(&s, at, at + v(a.sin(), (1.7 * a).cos(), (2.3 * a).sin() + 0.01), 60);
            assert_eq!(seen.radiance, DVec3::ZERO);
        }
    }
}

#[test]
fn from_the_centre_of_a_mirror_sphere_all_pixels_are_alike() {
    let mut s = scene();
    let silver = s.material(Material { secondary: 0.5, ..glowing(0.6) });
    s.sphere(v(3.0, -2.0, 1.0), 7.0, silver);
    s.look(v(3.0, -2.0, 1.0), DVec3::ZERO);
    s.camera.fov = 2.0;
    let settings = Settings { width: 16, height: 16, samples: 2, depth: 6, ..Settings::of(&s) };
    let image = Oracle::new(&s).render(&settings);
    let expected = 0.6 * (1.0 - 0.5f64.powi(6));
    assert!(image.linear.iter().all(|c| (c.x - expected).abs() < 1e-15));
    assert_eq!(image.rays.reflection, 16 * 16 * 2 * 5);
}

#[test]
fn a_ray_from_the_centre_comes_back_to_it() {
    // A lamp the size of 1e-9 beside the eye is missed by the first ray and met by the second.
    let mut s = scene();
    let silver = s.material(mirror(1.0));
    let lamp = s.material(glowing(1.0));
    s.sphere(DVec3::ZERO, 5.0, silver);
    s.sphere(v(0.0, 0.0, -1e-9), 0.9e-9, lamp);
    for at in [DVec3::Z, v(0.3, 0.2, 1.0), v(-0.5, 0.4, 0.9)] {
        assert_eq!([1, 2].map(|depth| probe(&s, DVec3::ZERO, at, depth).radiance.x), [0.0, 1.0]);
    }
}

#[test]
fn a_sphere_reaches_to_the_tangent_not_to_its_radius() {
    let (r, d) = (2.0f64, 5.0f64);
    let mut s = scene();
    let white = s.material(matte());
    s.sphere(DVec3::Z * d, r, white);
    let hit = |angle: f64| probe(&s, DVec3::ZERO, v(angle.sin(), 0.0, angle.cos()), 1).first_hit;
    let edge = (r / d).asin();
    assert_eq!(hit(edge - 1e-14), Some(0));
    assert_eq!(hit(edge + 1e-14), None);
    assert_eq!(hit((r / d).atan()), Some(0));
}

#[test]
fn reflections_off_tilted_shading_normals_stay_outside() {
    let mut s = scene();
    let silver = s.material(mirror(1.0));
    s.cuboid(v(-1.0, -1.0, 4.0), v(1.0, 1.0, 6.0), silver);
    s.meshes[0].normals = vec![v(0.9, 0.0, -0.19f64.sqrt()), v(-0.9, 0.0, -0.19f64.sqrt())];
    s.meshes[0].faces.iter_mut().for_each(|f| f.normals = Some([0, 1, 0]));
    s.render.background = DVec3::ONE;
    for i in 0..500 {
        let x = f64::from(i) / 251.0 - 0.995;
        assert_eq!(probe(&s, v(-40.0 * x, 0.0, 0.0), v(x, 0.3 * x, 4.0), 2).radiance, DVec3::ONE, "{x}");
    }
}

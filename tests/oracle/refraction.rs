//! Refraction: slabs, ball lenses, critical angles, media in media.

use crate::build::{Add, assert_close, clear, glass, matte, probe, scene, v};
use glam::DVec3;
use whitted::reference::oracle::Oracle;
use whitted::scene::{Fresnel, Material, Scene};
use whitted::settings::Settings;

/// Where the screen stands.
pub const SCREEN: f64 = 50.0;

/// Where the ray from `from` to `at` lands on the screen z = 50, for rays in the plane y = 0. One light
/// 5 before the screen is the ruler: its cosine and inverse square give the distance from its foot.
pub fn landing(scene: &Scene, from: DVec3, at: DVec3, depth: u32) -> f64 {
    let (foot, height) = (-60.0, 5.0);
    let mut s = scene.clone();
    let screen = s.material(matte());
    s.rectangle(DVec3::Z * SCREEN, DVec3::X * 50.0, DVec3::Y * 50.0, screen);
    s.light(v(foot, 0.0, SCREEN - height), DVec3::ONE);
    let seen = probe(&s, from, at, depth).radiance.x;
    assert!(seen > 0.0, "the ray misses the screen");
    foot + ((height / seen).powf(2.0 / 3.0) - height * height).sqrt()
}

/// Sideways step of a ray at `angle` in a layer of `thickness` and `index`.
pub fn step(thickness: f64, angle: f64, index: f64) -> f64 {
    let sin = angle.sin() / index;
    thickness * sin / (1.0 - sin * sin).sqrt()
}

#[test]
fn the_ruler_measures() {
    for x in [-20.0, 0.0, 13.25, 40.0] {
        assert_close(landing(&scene(), v(-1.0, 0.0, 2.0), v(x, 0.0, SCREEN), 1), x, 1e-12);
    }
}

#[test]
fn a_slab_shifts_rays_and_keeps_their_direction() {
    for (degrees, n, t) in [(0.0, 1.5, 1.0), (20.0, 1.5, 2.0), (40.0, 1.33, 0.5), (41.0, 2.42, 3.0)] {
        let angle = f64::to_radians(degrees);
        let mut s = scene();
        let pane = s.material(clear(n));
        s.cuboid(v(-30.0, -30.0, 2.0), v(30.0, 30.0, 2.0 + t), pane);
        let at = v(angle.tan(), 0.0, 1.0);
        let x = landing(&s, DVec3::ZERO, at, 3);
        assert_close(x, (SCREEN - t) * angle.tan() + step(t, angle, n), 1e-12);
        // The shift at right angles to the ray, as textbooks give it.
        let cos_t = (1.0 - (angle.sin() / n).powi(2)).sqrt();
        let shift = t * angle.sin() * (1.0 - angle.cos() / (n * cos_t));
        assert_close((SCREEN * angle.tan() - x) * angle.cos(), shift, 1e-12);
    }
}

#[test]
fn a_ball_lens_deviates_by_twice_the_difference_of_angles() {
    for (height, n) in [(0.1f64, 1.5f64), (0.5, 1.5), (-0.8, 1.33), (0.6, 2.42), (0.3, 0.8)] {
        let mut s = scene();
        let lens = s.material(clear(n));
        s.sphere(v(0.0, 0.0, 5.0), 1.0, lens);
        let x = landing(&s, v(height, 0.0, 0.0), v(height, 0.0, 1.0), 3);
        let (incident, transmitted) = (height.asin(), (height / n).asin());
        // It enters at angle `incident` from -z; its chord spans pi - 2 `transmitted`.
        let out = 2.0 * transmitted - incident;
        let leaves = v(out.sin(), 0.0, out.cos());
        let deviation = 2.0 * (incident - transmitted);
        let expected = leaves.x - (SCREEN - 5.0 - leaves.z) * deviation.tan();
        assert_close(x, expected, 1e-11);
    }
}

#[test]
fn near_its_axis_a_ball_lens_has_its_focus_at_one_and_a_half_radii() {
    let mut s = scene();
    let lens = s.material(clear(1.5));
    s.sphere(v(0.0, 0.0, 5.0), 1.0, lens);
    let mut last = f64::INFINITY;
    for height in [1e-1, 1e-2, 1e-3] {
        let x = landing(&s, v(height, 0.0, 0.0), v(height, 0.0, 1.0), 3);
        let error = (x / height + (SCREEN - 6.5) / 1.5).abs();
        assert!(error < last / 90.0, "{error} after {last}");
        last = error;
    }
}

#[test]
fn total_reflection_begins_at_the_critical_angle() {
    for n in [1.5f64, 1.33, 2.42] {
        let mut s = scene();
        let pane = s.material(clear(n));
        s.cuboid(v(-30.0, -30.0, -1.0), v(30.0, 30.0, 2.0), pane);
        s.render.background = DVec3::ONE;
        let critical = (1.0 / n).asin();
        for k in 1..=13 {
            for (sign, expected) in [(-1.0, 1.0), (1.0, 0.0)] {
                let angle = critical + sign * 10f64.powi(-k);
                let at = v(angle.sin(), 0.0, angle.cos());
                let seen = probe(&s, DVec3::ZERO, at, 2).radiance.x;
                assert_eq!(seen, expected, "n {n}, critical angle {sign:+} 1e-{k}");
            }
        }
    }
}

#[test]
fn fresnel_splits_the_light_at_a_surface() {
    let angle = 0.7f64;
    let expect = |n1: f64, n2: f64| {
        let cos_t = (1.0 - (n1 / n2 * angle.sin()).powi(2)).sqrt();
        let s = (n1 * angle.cos() - n2 * cos_t) / (n1 * angle.cos() + n2 * cos_t);
        let p = (n2 * angle.cos() - n1 * cos_t) / (n2 * angle.cos() + n1 * cos_t);
        (s * s + p * p) / 2.0
    };
    // The reflected ray leaves the box, the refracted one is cut inside it.
    let seen = |fresnel: Fresnel| {
        let mut s = scene();
        let pane = s.material(glass(1.5, fresnel));
        s.cuboid(v(-30.0, -30.0, 2.0), v(30.0, 30.0, 3.0), pane);
        s.render.background = DVec3::ONE;
        probe(&s, DVec3::ZERO, v(angle.tan(), 0.0, 1.0), 2).radiance.x
    };
    assert_close(seen(Fresnel::Exact), expect(1.0, 1.5), 1e-15);
    assert_close(seen(Fresnel::Schlick), 0.04 + 0.96 * (1.0 - angle.cos()).powi(5), 1e-15);
    assert_eq!(seen(Fresnel::Constant(0.375)), 0.375);
}

#[test]
fn a_glass_ball_in_a_furnace_hides_only_what_the_depth_cuts() {
    for height in [0.0f64, 0.5, 0.99, 0.999_999] {
        let mut s = scene();
        let ball = s.material(glass(1.5, Fresnel::Exact));
        s.sphere(v(0.0, 0.0, 5.0), 1.0, ball);
        s.render.background = DVec3::ONE;
        let cos_i = (1.0 - height * height).sqrt();
        let cos_t = (1.0 - (height / 1.5).powi(2)).sqrt();
        let rs = (cos_i - 1.5 * cos_t) / (cos_i + 1.5 * cos_t);
        let rp = (1.5 * cos_i - cos_t) / (1.5 * cos_i + cos_t);
        let r = (rs * rs + rp * rp) / 2.0;
        for depth in 2..12 {
            let seen = probe(&s, v(height, 0.0, 0.0), v(height, 0.0, 1.0), depth).radiance.x;
            // Inside, every bounce meets the surface at the same angle and keeps r of what is left.
            assert_close(seen, 1.0 - (1.0 - r) * r.powi(depth as i32 - 2), 2e-9 * cos_i + 1e-11);
        }
    }
}

#[test]
fn a_sheet_passes_light_straight_on() {
    let mut s = scene();
    let pane = s.material(clear(1.7));
    s.rectangle(v(0.0, 0.0, 3.0), DVec3::X * 9.0, DVec3::Y * 9.0, pane);
    s.rectangle(v(0.0, 0.0, 7.0), v(9.0, 0.0, 4.0), DVec3::Y * 9.0, pane);
    assert_close(landing(&s, DVec3::ZERO, v(0.4, 0.0, 1.0), 3), 0.4 * SCREEN, 1e-12);
    s.materials[pane] = glass(1.5, Fresnel::Exact);
    s.render.background = DVec3::ONE;
    assert_close(probe(&s, DVec3::ZERO, DVec3::Z, 2).radiance.x, 0.04, 1e-16);
}

#[test]
fn secondary_weight_mixes_own_and_refracted_light() {
    let mut s = scene();
    let tinted = s.material(Material {
        diffuse: v(0.5, 0.25, 1.0),
        ambient: 0.5,
        secondary: 0.75,
        ..glass(1.0, Fresnel::Constant(0.25))
    });
    s.rectangle(v(0.0, 0.0, 3.0), DVec3::X, DVec3::Y, tinted);
    s.render.background = DVec3::splat(0.5);
    let own = v(0.5, 0.25, 1.0) * 0.5 * 0.25;
    assert_eq!(probe(&s, DVec3::ZERO, DVec3::Z, 1).radiance, own);
    assert_eq!(probe(&s, DVec3::ZERO, DVec3::Z, 2).radiance, own + DVec3::splat(0.375));
}

#[test]
fn a_sheet_of_air_in_glass_reflects_all_beyond_the_critical_angle() {
    let mut s = scene();
    let block = s.material(clear(1.5));
    let gap = s.material(glass(1.0, Fresnel::Exact));
    s.cuboid(v(-9.0, -9.0, -9.0), v(9.0, 9.0, 9.0), block);
    s.rectangle(DVec3::Z, DVec3::X * 8.0, DVec3::Y * 8.0, gap);
    for (degrees, expected) in [(41.0f64, (1, 1)), (42.0, (1, 0))] {
        let angle = degrees.to_radians();
        s.look(DVec3::ZERO, v(angle.sin(), 0.0, angle.cos()));
        let rays = Oracle::new(&s).render(&Settings { depth: 2, ..Settings::of(&s) }).rays;
        assert_eq!((rays.reflection, rays.refraction), expected, "{degrees}");
    }
}

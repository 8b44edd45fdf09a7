//! Overlapping solids: the one of highest priority fills the space.

use crate::build::{Add, assert_close, clear, glowing, probe, scene, v};
use crate::refraction::{SCREEN, landing, step};
use glam::DVec3;
use whitted::scene::{Material, Scene};

const GLASS: f64 = 1.5;
const WATER: f64 = 1.33;

/// Glass from z = 2 to 4 and water from z = 3.5 to 6, in the given order of entry into the scene.
fn overlapping(glass: i32, water: i32) -> Scene {
    let mut s = scene();
    let glass = s.material(Material { priority: glass, ..clear(GLASS) });
    let water = s.material(Material { priority: water, ..clear(WATER) });
    s.cuboid(v(-30.0, -30.0, 2.0), v(30.0, 30.0, 4.0), glass);
    s.cuboid(v(-30.0, -30.0, 3.5), v(30.0, 30.0, 6.0), water);
    s
}

#[test]
fn the_higher_priority_takes_the_overlap() {
    for (glass, water, border) in [(1, 0, 4.0), (0, 1, 3.5), (-3, -7, 4.0), (0, 0, 3.5)] {
        for degrees in [0.0f64, 10.0, 40.0] {
            let angle = degrees.to_radians();
            let x = landing(&overlapping(glass, water), DVec3::ZERO, v(angle.tan(), 0.0, 1.0), 5);
            let expected = (SCREEN - 4.0) * angle.tan()
                + step(border - 2.0, angle, GLASS)
                + step(6.0 - border, angle, WATER);
            assert_close(x, expected, 1e-12);
        }
    }
}

#[test]
fn an_eye_in_both_starts_in_the_higher() {
    // From within the overlap along +z: the rest of the glass, then water, or water alone.
    for (glass, water, in_glass) in [(1, 0, 0.25), (0, 1, 0.0)] {
        let sin = 0.4f64;
        let index = if glass > water { GLASS } else { WATER };
        let from = v(0.0, 0.0, 3.75);
        let at = from + v(sin, 0.0, (1.0 - sin * sin).sqrt());
        let x = landing(&overlapping(glass, water), from, at, 4);
        // The angle outside, where sin is `index` times as large.
        let angle = (sin * index).asin();
        let expected =
            step(in_glass, angle, GLASS) + step(2.25 - in_glass, angle, WATER) + (SCREEN - 6.0) * angle.tan();
        assert_close(x, expected, 1e-12);
    }
}

#[test]
fn a_hidden_surface_has_no_light_of_its_own_and_takes_one_depth() {
    let mut s = scene();
    let glass = s.material(Material { priority: 1, ..clear(1.0) });
    let lamp = s.material(Material { secondary: 0.5, ior: 1.0, ..Material { ambient: 8.0, ..clear(1.0) } });
    s.cuboid(v(-9.0, -9.0, -1.0), v(9.0, 9.0, 5.0), glass);
    s.cuboid(v(-1.0, -1.0, 2.0), v(1.0, 1.0, 3.0), lamp);
    s.render.background = DVec3::ONE;
    let seen = |s: &Scene, depth| probe(s, DVec3::ZERO, DVec3::Z, depth).radiance.x;
    // Two hidden faces, the glass's far face, the background.
    assert_eq!([1, 2, 3, 4].map(|depth| seen(&s, depth)), [0.0, 0.0, 0.0, 1.0]);
    s.materials[glass].priority = 0;
    assert_eq!(seen(&s, 1), 4.0);
    // What does not refract is matter whatever the priorities.
    s.materials[glass].priority = 1;
    s.materials[lamp] = glowing(2.0);
    assert_eq!(seen(&s, 2), 2.0);
}

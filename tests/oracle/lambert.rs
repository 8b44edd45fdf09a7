//! Own colour: inverse square, cosine, shadows.

use crate::build::{Add, assert_close, glowing, matte, probe, scene, v};
use glam::DVec3;
use whitted::scene::Scene;

fn floor() -> Scene {
    let mut s = scene();
    let white = s.material(matte());
    s.rectangle(DVec3::ZERO, DVec3::Z * 100.0, DVec3::X * 100.0, white);
    s
}

#[test]
fn light_falls_with_the_square_of_distance_and_the_cosine() {
    for (x, h) in [(0.0, 1.0), (0.0, 2.0), (3.0, 4.0), (-20.0, 0.5), (1e-3, 50.0)] {
        let mut s = floor();
        s.light(v(x, h, 0.25), v(3.0, 2.0, 1.0));
        let seen = probe(&s, v(1.0, 7.0, 2.0), v(0.0, 0.0, 0.25), 1).radiance;
        let expected = h / (x * x + h * h).powf(1.5);
        assert_close(seen.x, 3.0 * expected, 1e-13 * expected);
        assert_close(seen.z, expected, 1e-13 * expected);
    }
}

#[test]
fn twice_the_distance_is_exactly_a_quarter() {
    let at = |h: f64| {
        let mut s = floor();
        s.light(v(0.0, h, 0.0), DVec3::ONE);
        probe(&s, v(0.0, 4.0, 0.0), DVec3::ZERO, 1).radiance.x
    };
    assert_eq!(at(2.0), 4.0 * at(4.0));
    assert_eq!(at(2.0), 0.25);
}

#[test]
fn surfaces_are_two_sided_but_lit_from_the_side_that_is_seen() {
    let mut s = floor();
    s.light(v(0.0, 2.0, 0.0), DVec3::ONE);
    assert_eq!(probe(&s, v(0.0, -4.0, 1.0), DVec3::ZERO, 1).radiance, DVec3::ZERO);
    s.lights[0].position.y = -2.0;
    assert_close(probe(&s, v(0.0, -4.0, 1.0), DVec3::ZERO, 1).radiance.x, 0.25, 1e-15);
}

#[test]
fn the_shadow_edge_is_where_the_light_sees_the_blocker_end() {
    let (light, height, blocker, end) = (-1.5, 6.0, 2.0, 0.75);
    let mut s = floor();
    let white = s.material(matte());
    s.rectangle(v(end - 4.0, blocker, 0.0), DVec3::Z * 4.0, DVec3::X * 4.0, white);
    s.light(v(light, height, 0.0), DVec3::ONE);
    let edge = end + (end - light) * blocker / (height - blocker);
    let lit = |x: f64| probe(&s, v(x, 1.0, 0.1), v(x, 0.0, 0.1), 1).radiance.x > 0.0;
    // A floor 280 across is known to 16 EPSILON of that.
    assert!(lit(edge + 2e-12) && !lit(edge - 2e-12));
}

#[test]
fn only_what_lies_strictly_between_blocks() {
    let mut s = floor();
    let white = s.material(matte());
    s.light(v(0.0, 2.0, 0.0), DVec3::ONE);
    // Beyond the light, then through it: neither blocks.
    s.rectangle(v(0.0, 2.5, 0.0), DVec3::X, DVec3::Z, white);
    s.rectangle(v(0.0, 2.0, 0.0), v(0.6, 0.8, 0.0), v(0.0, 0.28, 0.96), white);
    let seen = |s: &Scene| probe(s, v(3.0, 1.0, 0.7), v(0.3, 0.0, 0.2), 1).radiance.x;
    let distance2: f64 = 0.3 * 0.3 + 2.0 * 2.0 + 0.2 * 0.2;
    assert_close(seen(&s), 2.0 / distance2.powf(1.5), 1e-14);
    // Just below it: blocks.
    s.rectangle(v(0.0, 2.0 - 1e-12, 0.0), DVec3::X, DVec3::Z, white);
    assert_eq!(seen(&s), 0.0);
}

#[test]
fn a_light_on_the_surface_stays_finite() {
    let mut s = floor();
    s.light(DVec3::ZERO, DVec3::ONE);
    s.light(v(0.0, 1e-300, 0.0), DVec3::ONE);
    assert!(probe(&s, v(1.0, 3.0, 2.0), DVec3::ZERO, 1).radiance.is_finite());
}

#[test]
fn neither_planes_nor_spheres_shadow_themselves() {
    for far in [0.0, 1e3, 1e6] {
        let at = DVec3::splat(far);
        let mut s = scene();
        let white = s.material(matte());
        s.rectangle(at, v(0.6, 0.8, 0.0) * 50.0, v(0.48, -0.36, 0.8) * 50.0, white);
        s.sphere(at + v(30.0, 0.0, 0.0), 0.01, white);
        let normal = v(0.6, 0.8, 0.0).cross(v(0.48, -0.36, 0.8));
        s.light(at + normal * 5.0, DVec3::ONE);
        for i in 0..400 {
            let t = f64::from(i) / 20.0 - 10.0;
            let target = at + v(0.6, 0.8, 0.0) * t + v(0.48, -0.36, 0.8) * (t * 0.7 - 1.0);
            assert!(probe(&s, at + normal * 9.0, target, 1).radiance.x > 0.0, "{far} {t}");
        }
        // A sphere is lit exactly where its normal faces the light.
        let (center, eye) = (at + v(0.0, 0.0, 500.0), at + v(0.0, 0.0, 490.0));
        let mut s = scene();
        let white = s.material(matte());
        s.sphere(center, 2.0, white);
        s.light(center + v(10.0, 0.0, 0.0), DVec3::ONE);
        for i in 0..100 {
            let x = (f64::from(i) + 0.5) / 50.0 - 1.0;
            let point = center + v(x, 0.0, -(4.0 - x * x).sqrt());
            let lit = probe(&s, eye, point, 1).radiance.x > 0.0;
            assert_eq!(lit, x > 0.4, "{far} {x}");
        }
    }
}

#[test]
fn ambient_needs_no_light() {
    let mut s = scene();
    let lamp = s.material(glowing(0.3));
    s.materials[lamp].diffuse = v(1.0, 0.5, 0.0);
    s.sphere(DVec3::Z * 5.0, 1.0, lamp);
    assert_eq!(probe(&s, DVec3::ZERO, DVec3::Z, 1).radiance, v(0.3, 0.15, 0.0));
}

#[test]
fn a_smooth_normal_shades_as_the_sphere_it_stands_for() {
    let mut s = scene();
    let white = s.material(matte());
    s.cuboid(v(-1.0, -1.0, 4.0), v(1.0, 1.0, 6.0), white);
    // The front face's corners get one tilted normal: the same as a polygon that carries it.
    let tilted = v(0.6, 0.0, -0.8);
    s.meshes[0].normals = vec![tilted];
    s.meshes[0].faces.iter_mut().for_each(|f| f.normals = Some([0; 3]));
    s.light(v(5.0, 1.0, -2.0), DVec3::ONE);
    let to_light = v(5.0, 1.0, -6.0);
    let expected = tilted.dot(to_light) / to_light.length().powi(3);
    assert_close(probe(&s, v(0.2, 0.1, 0.0), v(0.0, 0.0, 4.0), 1).radiance.x, expected, 1e-15);
}

//! Solids in solids: which index of refraction rules where.

use crate::build::{Add, assert_close, clear, glass, glowing, mirror, probe, scene, v};
use glam::DVec3;
use whitted::reference::oracle::Oracle;
use whitted::scene::{Fresnel, Scene};
use whitted::settings::Settings;

const SIDE: f64 = 30.0;

/// Layers along z as boxes `(low, high, index)`, in this order in the scene.
fn layers(boxes: &[(f64, f64, f64)]) -> Scene {
    let mut s = scene();
    for &(low, high, index) in boxes {
        let material = s.material(clear(index));
        // Wider boxes are longer too, so that their bounds are ordered as they contain each other.
        let side = SIDE + (high - low);
        s.cuboid(v(-side, -side, low), v(side, side, high), material);
    }
    s
}

/// Whether a lamp of radius 1e-11 at `target` is seen by the ray from the origin to `at`.
fn arrives(scene: &Scene, at: DVec3, target: DVec3, depth: u32) -> bool {
    let mut s = scene.clone();
    let lamp = s.material(glowing(1.0));
    s.sphere(target, 1e-11, lamp);
    probe(&s, DVec3::ZERO, at, depth).radiance.x == 1.0
}

/// Sideways way of a ray with invariant n sin(angle) through layers of (thickness, index).
fn sideways(invariant: f64, layers: &[(f64, f64)]) -> f64 {
    layers.iter().map(|&(t, n)| t * invariant / (n * n - invariant * invariant).sqrt()).sum()
}

#[test]
fn nested_boxes_follow_the_chain_of_indices() {
    let s = layers(&[(4.0, 5.0, 2.1), (2.0, 7.0, 1.3), (3.0, 6.0, 1.7)]);
    let angle = 0.6f64;
    let chain = [(2.0, 1.0), (1.0, 1.3), (1.0, 1.7), (1.0, 2.1), (1.0, 1.7), (1.0, 1.3), (3.0, 1.0)];
    for end in 1..=chain.len() {
        // A lamp in the middle of each layer in turn.
        let (before, last) = (&chain[..end - 1], chain[end - 1]);
        let z = before.iter().map(|l| l.0).sum::<f64>() + last.0 / 2.0;
        let x = sideways(angle.sin(), before) + sideways(angle.sin(), &[(last.0 / 2.0, last.1)]);
        assert!(arrives(&s, v(angle.sin(), 0.0, angle.cos()), v(x, 0.0, z), end as u32));
        assert!(!arrives(&s, v(angle.sin(), 0.0, angle.cos()), v(x + 1e-9, 0.0, z), end as u32));
    }
}

#[test]
fn an_eye_inside_solids_starts_in_the_innermost() {
    // Listed inner first: containment decides, not the order of the text.
    let s = layers(&[(-1.0, 1.0, 2.1), (-3.0, 3.0, 1.3), (-2.0, 2.0, 1.7)]);
    let angle = 0.2f64;
    let invariant = 2.1 * angle.sin();
    let x = sideways(invariant, &[(1.0, 2.1), (1.0, 1.7), (1.0, 1.3), (4.0, 1.0)]);
    assert!(arrives(&s, v(angle.sin(), 0.0, angle.cos()), v(x, 0.0, 7.0), 4));
}

#[test]
fn an_eye_inside_a_sphere_inside_a_box() {
    let mut s = layers(&[(-5.0, 5.0, 1.5)]);
    let air = s.material(clear(1.0));
    s.sphere(DVec3::ZERO, 1.0, air);
    // Through the centre: straight out of the air bubble, then bent at the face.
    let angle = 0.4f64;
    let x = 5.0 * angle.tan() + sideways(1.5 * angle.sin(), &[(2.0, 1.0)]);
    assert!(arrives(&s, v(angle.sin(), 0.0, angle.cos()), v(x, 0.0, 7.0), 3));
}

#[test]
fn where_solids_overlap_the_last_entered_rules() {
    let s = layers(&[(2.0, 4.0, 1.3), (3.0, 5.0, 1.7)]);
    let angle = 0.5f64;
    // Leaving the first inside the second changes nothing.
    let x = sideways(angle.sin(), &[(2.0, 1.0), (1.0, 1.3), (2.0, 1.7), (2.0, 1.0)]);
    assert!(arrives(&s, v(angle.sin(), 0.0, angle.cos()), v(x, 0.0, 7.0), 5));
}

#[test]
fn glass_of_index_one_is_not_there() {
    let mut s = scene();
    let nothing = s.material(glass(1.0, Fresnel::Exact));
    s.sphere(v(0.1, 0.0, 5.0), 1.0, nothing);
    s.cuboid(v(-3.0, -3.0, 2.0), v(3.0, 3.0, 9.0), nothing);
    s.render.background = v(0.3, 0.6, 0.9);
    s.camera.fov = 0.4;
    let settings = Settings { width: 20, height: 20, depth: 5, ..Settings::of(&s) };
    let image = Oracle::new(&s).render(&settings);
    assert!(image.linear.iter().all(|&c| c == s.render.background));
    assert_eq!(image.rays.reflection, 0);
}

#[test]
fn a_mirror_bounds_no_solid() {
    let mut s = layers(&[(2.0, 9.0, 1.5)]);
    let silver = s.material(mirror(1.0));
    s.sphere(v(0.0, 0.0, 6.0), 1.0, silver);
    // In, back from the mirror, out again: the eye's own place is reached straight.
    let lamp = s.material(glowing(1.0));
    s.sphere(v(0.0, 0.0, -1.0), 0.5, lamp);
    assert_eq!(probe(&s, DVec3::ZERO, DVec3::Z, 4).radiance.x, 1.0);
}

#[test]
fn an_eye_near_a_corner_of_a_box_is_told_inside_from_outside() {
    for far in [0.0, 1e5] {
        let mut s = scene();
        let pane = s.material(clear(1.5));
        let low = DVec3::splat(far);
        s.cuboid(low, low + DVec3::ONE, pane);
        s.render.background = DVec3::ONE;
        for i in 0..64 {
            let place = |bits: i32| [-1e-6, 1e-6, 1.0 - 1e-6, 1.0 + 1e-6][(bits & 3) as usize];
            let eye = low + v(place(i), place(i >> 2), place(i >> 4));
            let inside = eye.cmpgt(low).all() && eye.cmplt(low + DVec3::ONE).all();
            // 45 degrees is past the critical angle 41.8 inside, and no angle is outside.
            let towards = v(low.x + 0.5 - eye.x, 0.0, 0.0).normalize();
            let outward = if eye.z > low.z + 0.5 { DVec3::Z } else { DVec3::NEG_Z };
            let mut looking = s.clone();
            looking.look(eye, eye + towards * 1.1 + outward);
            let rays = Oracle::new(&looking).render(&Settings { depth: 2, ..Settings::of(&looking) }).rays;
            // From inside the first ray is reflected in full; from outside it is refracted or misses.
            assert_eq!(inside, rays.reflection == 1, "{eye}");
        }
    }
}

#[test]
fn crossing_a_medium_boundary_obeys_snell_from_the_current_medium() {
    let n = [1.5f64, 1.2];
    let s = layers(&[(-9.0, 9.0, n[0]), (2.0, 8.0, n[1])]);
    let critical = (n[1] / n[0]).asin();
    let below = v((critical - 1e-9).sin(), 0.0, (critical - 1e-9).cos());
    let above = v((critical + 1e-9).sin(), 0.0, (critical + 1e-9).cos());
    let depth_2 = |at: DVec3| {
        let mut looking = s.clone();
        looking.look(DVec3::ZERO, at);
        let settings = Settings { depth: 2, ..Settings::of(&looking) };
        let rays = Oracle::new(&looking).render(&settings).rays;
        (rays.reflection, rays.refraction)
    };
    assert_eq!((depth_2(below), depth_2(above)), ((0, 1), (1, 0)));
    assert_close(critical.sin(), 0.8, 1e-15);
}

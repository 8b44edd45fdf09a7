//! Device against oracle: first hits, colours and ray counts, each within a bound from docs/numerics.md.

use crate::common::{device, first_hits, render, renderer, scenes, small};
use whitted::compare::metrics::{edge_length, hit_mismatches, mismatch_bound};
use whitted::reference::oracle::{Oracle, OracleImage};
use whitted::report::{DepthInfo, RayInfo};
use whitted::scene::Scene;
use whitted::settings::Settings;

const WIDTH: u32 = 64;
const SAMPLES: u32 = 4;
/// How far, in pixels, rounding may move a primary ray against an edge: its direction carries some 10
/// roundings of 2^-24 (offset, step, lateral sum, normalisation), the corners of both triangles and
/// the start plane some 16 more; 32 pixels lie in the half width, which is half the distance to the
/// image plane in the narrowest of the scenes: 26 * 2^-24 * 32 * 2 = 1.0e-4.
const DELTA_PX: f64 = 1.0e-4;
/// Relative error of a colour whose path tree is the oracle's: a hit point is off by up to 16 * 2^-24
/// scene radii, and its ray starts up to as much beside it (numerics.md, Spawn origins), at each of a few
/// depths; where a light is half a scene radius away the law of inverse squares and the cosine triple and
/// double that: 6 * 3 depths * 1.9e-6 = 3.4e-5.
const TOLERANCE: f64 = 3.5e-5;
/// Colours below this are compared with it, not with themselves.
const DARK: f64 = 1.0e-3;
/// Beyond this a colour is another path's, not a rounded one.
const OTHER_PATH: f64 = 1.0e-2;

fn edges(oracle: &OracleImage) -> u64 {
    let one_each: Vec<_> = oracle.first_hit.chunks(SAMPLES as usize).map(|c| c[0]).collect();
    edge_length(&one_each, oracle.width as usize).unwrap()
}

fn error(found: [f32; 3], truth: glam::DVec3) -> f64 {
    let one = |c: usize| (f64::from(found[c]) - truth[c]).abs() / (DARK + truth[c].abs());
    (0..3).map(one).fold(0.0, |worst, e| if e.is_nan() { f64::INFINITY } else { worst.max(e) })
}

/// What is wrong with an image, if anything.
fn colours(
    scene: &Scene,
    settings: &Settings,
    found: &[[f32; 3]],
    oracle: &OracleImage,
) -> Result<(), String> {
    let errors: Vec<f64> = found.iter().zip(&oracle.linear).map(|(a, b)| error(*a, *b)).collect();
    let rounded = errors.iter().filter(|e| **e > TOLERANCE).count();
    if rounded * 100 > errors.len() {
        return Err(format!("{rounded} of {} pixels are off by more than {TOLERANCE}", errors.len()));
    }
    // Shadows have edges as well, one set per light, and every depth shows edges again.
    let sets = (scene.lights.len() as u64 + 1) * u64::from(settings.depth);
    let bound = mismatch_bound(DELTA_PX, edges(oracle) * sets, SAMPLES);
    let others = errors.iter().filter(|e| **e > OTHER_PATH).count();
    if others as f64 > bound {
        return Err(format!("{others} pixels show other paths, {bound:.1} may"));
    }
    Ok(())
}

/// A path that differs may end, or grow a tree of 2^(depth - 1) rays at each depth.
fn counts(scene: &Scene, found: &RayInfo, truth: &RayInfo, mismatches: f64) -> Result<(), String> {
    if found.by_depth.len() != truth.by_depth.len() {
        return Err(format!("{} depths, not {}", found.by_depth.len(), truth.by_depth.len()));
    }
    for (a, b) in found.by_depth.iter().zip(&truth.by_depth) {
        let bound = mismatches * f64::from(1u32 << (b.depth - 1));
        let lights = scene.lights.len() as f64;
        let kinds = |d: &DepthInfo| [d.traced, d.primary, d.reflection, d.refraction];
        let worst = kinds(a).into_iter().zip(kinds(b)).map(|(a, b)| a.abs_diff(b)).max().unwrap_or(0);
        if worst as f64 > bound || a.shadow.abs_diff(b.shadow) as f64 > lights * bound {
            return Err(format!("depth {}: {a:?}, not {b:?}, within {bound:.1}", b.depth));
        }
    }
    Ok(())
}

#[test]
fn hits_colours_and_counts_are_the_oracles() {
    let device = device();
    let mut renderer = renderer();
    for (name, scene) in scenes() {
        for seed in 0..3 {
            let settings = small(&scene, WIDTH, SAMPLES, seed);
            let oracle = Oracle::new(&scene).render(&settings);
            let bound = mismatch_bound(DELTA_PX, edges(&oracle), SAMPLES);
            let hits = first_hits(&device, &scene, &settings);
            let mismatches = hit_mismatches(&hits, &oracle.first_hit).unwrap();
            assert!(
                mismatches as f64 <= bound,
                "{name}, seed {seed}: {mismatches} hits differ, {bound:.1} may"
            );
            let image = render(&mut renderer, &scene, &settings);
            colours(&scene, &settings, &image.linear, &oracle)
                .unwrap_or_else(|e| panic!("{name}, seed {seed}: {e}"));
            counts(&scene, &image.report.rays, &oracle.rays, bound)
                .unwrap_or_else(|e| panic!("{name}, seed {seed}: {e}"));
        }
    }
}

#[test]
fn a_lens_wrong_by_a_thousandth_is_seen() {
    let device = device();
    let (_, scene) = scenes().swap_remove(0);
    let settings = small(&scene, WIDTH, SAMPLES, 0);
    let oracle = Oracle::new(&scene).render(&settings);
    let mut wrong = scene.clone();
    wrong.camera.fov *= 1.001;
    let mismatches = hit_mismatches(&first_hits(&device, &wrong, &settings), &oracle.first_hit).unwrap();
    let bound = mismatch_bound(DELTA_PX, edges(&oracle), SAMPLES);
    assert!(mismatches as f64 > bound, "{mismatches} pass under {bound:.1}");
}

#[test]
fn light_wrong_by_a_ten_thousandth_is_seen() {
    let mut renderer = renderer();
    let (_, scene) = scenes().swap_remove(0);
    let settings = small(&scene, WIDTH, SAMPLES, 0);
    let oracle = Oracle::new(&scene).render(&settings);
    let mut wrong = scene.clone();
    wrong.lights[0].intensity *= 1.0001;
    let image = render(&mut renderer, &wrong, &settings);
    assert!(colours(&scene, &settings, &image.linear, &oracle).is_err(), "a wrong light passes");
    // A few pixels of another path among thousands.
    let mut image = render(&mut renderer, &scene, &settings).linear;
    image[100..130].fill([0.123; 3]);
    assert!(colours(&scene, &settings, &image, &oracle).is_err(), "30 wrong pixels pass");
}

#[test]
fn a_lost_ray_is_seen() {
    let (_, scene) = scenes().swap_remove(0);
    let oracle = Oracle::new(&scene).render(&small(&scene, WIDTH, SAMPLES, 0)).rays;
    let mut lost = oracle.clone();
    lost.by_depth[1].traced -= 40;
    assert!(counts(&scene, &lost, &oracle, 6.0).is_err());
}

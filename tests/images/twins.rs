//! Device against twin, hierarchy against brute force: the same bits.

use crate::common::build::{Add, everything, matte};
use crate::common::{render, renderer, scenes, small};
use glam::DVec3;
use whitted::image::linear_sha256;
use whitted::plan::{Plan, brute_force_max, pack_for};
use whitted::prepare::pack;
use whitted::reference::twin;
use whitted::report::Report;
use whitted::report::test_counts::TestCounts;
use whitted::scene::Scene;
use whitted::settings::forced_features::{Feature, ForcedFeatures};
use whitted::settings::sampler::Sampler;
use whitted::settings::{Origin, Precision, Schedule, Settings, SurfaceSums};

/// Every way the kernels compute, and every sampler.
const ARITHMETIC: [(Precision, Origin, Sampler); 4] = [
    (Precision::Robust, Origin::Bound, Sampler::Owen),
    (Precision::Fast, Origin::Bound, Sampler::Random),
    (Precision::Double, Origin::Bound, Sampler::Owen),
    (Precision::Robust, Origin::Fixed(1e-3), Sampler::Stratified),
];

/// Scenes that between them have every feature.
const MANY_SIDED: [&str; 2] = ["everything", "planet"];

/// Per depth: traced, reflection, refraction and shadow rays, as far as rays go.
fn by_depth(report: &Report) -> Vec<[u64; 4]> {
    report.rays.by_depth.iter().map(|d| [d.traced, d.reflection, d.refraction, d.shadow]).collect()
}

fn same_bits(a: &[[f32; 3]], b: &[[f32; 3]]) -> bool {
    a.len() == b.len() && a.iter().flatten().zip(b.iter().flatten()).all(|(a, b)| a.to_bits() == b.to_bits())
}

#[test]
fn the_device_gives_the_twins_image_and_counts() {
    let mut renderer = renderer();
    let limits = renderer.device().limits();
    for ((name, scene), (precision, origin, sampler)) in scenes()
        .into_iter()
        .chain([("everything".into(), everything()), ("planet".into(), planet())])
        .flat_map(|subject| {
            // Every way where everything is, the usual way elsewhere: each pair is compiled anew.
            let ways = if MANY_SIDED.contains(&subject.0.as_str()) { ARITHMETIC.len() } else { 1 };
            ARITHMETIC[..ways].iter().map(|how| (subject.clone(), *how)).collect::<Vec<_>>()
        })
    {
        let name = format!("{name}, {precision:?}, {origin:?}, {sampler:?}");
        // Tiles and batches that divide nothing.
        let schedule = Schedule { tile_pixels: Some(301), batch_samples: Some(2), ..Schedule::default() };
        let settings = Settings { schedule, precision, origin, sampler, ..small(&scene, 37, 3, 11) };
        let packed = pack_for(&scene, &settings, &limits);
        let plan = Plan::new(&packed, &settings, &limits).unwrap();
        let (linear, counts) = twin::render(&packed, &scene, &settings, &plan).unwrap();
        let device = render(&mut renderer, &scene, &settings);
        let different = linear.iter().zip(&device.linear).filter(|(a, b)| a != b).count();
        assert!(same_bits(&linear, &device.linear), "{name}: {different} of {} pixels differ", linear.len());
        let found = by_depth(&device.report);
        let expected: Vec<[u64; 4]> = counts.depths.iter().copied().take_while(|d| d[0] > 0).collect();
        assert_eq!(found, expected, "{name}");
        assert!(linear.iter().flatten().any(|c| *c > 0.0), "{name} is black");
        // The comparison can fail.
        let mut other = linear.clone();
        other[17][1] = f32::from_bits(other[17][1].to_bits() ^ 1);
        assert!(!same_bits(&linear, &other));
    }
}

/// Everything above a planet, with a grain of dust before the eye: spheres beyond single precision.
fn planet() -> Scene {
    let mut s = everything();
    let ground = s.materials.len();
    s.materials.push(whitted::scene::Material { diffuse: DVec3::new(0.3, 0.6, 0.2), ..matte() });
    s.sphere(DVec3::new(3.0, -6_371_002.0, 4.0), 6_371_000.0, ground);
    s.sphere(s.camera.look_from + DVec3::new(0.0, -5e-6, 1e-4), 4e-6, ground);
    s
}

#[test]
fn the_hierarchy_changes_no_bit() {
    let mut renderer = renderer();
    let others = [("everything".into(), everything()), ("planet".into(), planet())];
    for (name, scene) in scenes().into_iter().chain(others) {
        let settings = small(&scene, 60, 2, 3);
        let hashes = [true, false].map(|brute| {
            renderer.force_brute_force(Some(brute));
            linear_sha256(&render(&mut renderer, &scene, &settings).linear)
        });
        assert_eq!(hashes[0], hashes[1], "{name}: hierarchy and brute force differ");
    }
}

/// Sums of surfaces in every way of doing a depth and both precisions, with lights that then do not matter.
#[test]
fn the_device_sums_the_surfaces_that_the_twins_sum() {
    let mut renderer = renderer();
    let limits = renderer.device().limits();
    let ways = [
        (Precision::Robust, Schedule { fused: Some(true), ..Schedule::default() }),
        (Precision::Robust, Schedule { fused: Some(false), ..Schedule::default() }),
        (Precision::Robust, Schedule { walk_steps: Some(12), ..Schedule::default() }),
        (Precision::Double, Schedule::default()),
    ];
    for scene in [everything(), planet()] {
        for (precision, schedule) in ways {
            let images = [SurfaceSums::Place, SurfaceSums::Normal].map(|sums| {
                let schedule = Schedule { surface_layer: Some(sums), tile_pixels: Some(301), ..schedule };
                let settings = Settings { precision, schedule, depth: 1, ..small(&scene, 37, 3, 11) };
                let what = format!("{precision:?}, {schedule:?}");
                let packed = pack_for(&scene, &settings, &limits);
                let plan = Plan::new(&packed, &settings, &limits).unwrap();
                let (linear, _) = twin::render(&packed, &scene, &settings, &plan).unwrap();
                let device = render(&mut renderer, &scene, &settings);
                assert!(same_bits(&linear, &device.linear), "{what}");
                linear
            });
            assert!(images[0].iter().any(|p| p[1] == 1.0) && images[1].iter().flatten().any(|n| *n < 0.0));
        }
    }
}

/// Whole images in every traversal and both precisions: the tests that the device counts are the twins', by depth and
/// kind of ray, and the image keeps its bits.
#[test]
fn the_device_counts_the_tests_that_the_twins_count() {
    let mut renderer = renderer();
    let limits = renderer.device().limits();
    let forced_features = ForcedFeatures::default().with(Feature::LoneRays);
    let ways = [
        (Precision::Robust, Schedule { fused: Some(true), ..Schedule::default() }),
        (Precision::Robust, Schedule { fused: Some(false), ..Schedule::default() }),
        (Precision::Robust, Schedule { forced_features, ..Schedule::default() }),
        (Precision::Double, Schedule::default()),
    ];
    for (precision, schedule) in ways {
        for brute_force in [Some(true), Some(false)] {
            renderer.force_brute_force(brute_force);
            let scene = everything();
            let plain = Settings { precision, schedule, ..small(&scene, 37, 3, 11) };
            let count_tests = Schedule { count_tests: true, tile_pixels: Some(301), ..schedule };
            let settings = Settings { schedule: count_tests, ..plain.clone() };
            let what = format!("{precision:?}, {schedule:?}, {brute_force:?}");
            let packed = pack(&scene, &settings, brute_force_max(brute_force, &settings, &limits));
            let plan = Plan::new(&packed, &settings, &limits).unwrap();
            let (linear, counts) = twin::render(&packed, &scene, &settings, &plan).unwrap();
            let device = render(&mut renderer, &scene, &settings);
            let uncounted = render(&mut renderer, &scene, &plain);
            assert!(same_bits(&linear, &device.linear) && same_bits(&linear, &uncounted.linear), "{what}");
            let found = device.report.tests.unwrap();
            assert_eq!(found, TestCounts::of(&device.report.rays, &counts.tests), "{what}");
            assert_eq!(uncounted.report.tests, None);
            // The formula of brute force holds for whole images.
            let primitives = packed.primitive_count() as u64;
            let rays = device.report.rays.total();
            match brute_force {
                Some(true) => assert_eq!([found.boxes, found.primitives], [0, primitives * rays], "{what}"),
                _ => assert!(found.boxes > rays && found.primitives < primitives * rays, "{what}: {found:?}"),
            }
        }
    }
}

//! The same bits, however the work is cut (contract 4).

// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

mod common;

use common::{render, renderer, scenes, small};
use std::path::Path;
use std::process::Command;
use whitted::image::linear_sha256;
use whitted::render::Rendered;
use whitted::report::Report;
use whitted::scene::{Scene, Sphere};
use whitted::settings::forced_features::{Feature, ForcedFeatures};
use whitted::settings::{Hierarchy, Schedule, Settings};

/// Scenes that between them have every feature.
fn subjects() -> Vec<(String, Scene)> {
    let mut all = scenes();
    all.retain(|(name, _)| {
        ["cornell_glass", "nested_glass", "many_lights", "mesh_glass"].contains(&name.as_str())
    });
    assert_eq!(all.len(), 4);
    all
}

fn hash(rendered: &Rendered) -> String {
    linear_sha256(&rendered.linear)
}

#[test]
fn tiles_batches_and_groups_change_no_bit() {
    let mut renderer = renderer();
    for (name, scene) in subjects() {
        let settings = small(&scene, 41, 5, 9);
        let expected = hash(&render(&mut renderer, &scene, &settings));
        let mut with = |schedule: Schedule| {
            let found = render(&mut renderer, &scene, &Settings { schedule, ..settings.clone() });
            assert_eq!(hash(&found), expected, "{name}: {schedule:?}");
        };
        let none = Schedule::default();
        for tile_pixels in [37, 41, 64, 100, 1000] {
            with(Schedule { tile_pixels: Some(tile_pixels), ..none });
        }
        for batch_samples in [1, 2, 3, 4] {
            with(Schedule { batch_samples: Some(batch_samples), ..none });
        }
        for workgroup in [32, 128, 256] {
            with(Schedule { workgroup: Some(workgroup), ..none });
        }
        with(Schedule { tile_pixels: Some(53), batch_samples: Some(2), workgroup: Some(32), ..none });
        with(none);
        // Fused kernels.
        let long = Schedule { fused: Some(true), ..none };
        with(long);
        with(Schedule { tile_pixels: Some(53), batch_samples: Some(2), workgroup: Some(32), ..long });
        with(Schedule { tile_pixels: Some(100), workgroup: Some(256), ..long });
        // Rays of a subgroup apart, where a hierarchy is walked.
        with(Schedule { forced_features: ForcedFeatures::default().with(Feature::LoneRays), ..none });
        let mut other = settings.clone();
        other.seed += 1;
        assert_ne!(
            hash(&render(&mut renderer, &scene, &other)),
            expected,
            "{name}: the seed changes nothing"
        );
    }
}

/// Depths are dispatched as far as rays are seen to get; a submit whose rays get further is void.
#[test]
fn dispatched_depths_change_no_bit() {
    let mut renderer = renderer();
    let (_, scene) = scenes().into_iter().find(|(name, _)| name == "two_mirrors").unwrap();
    let settings = Settings { depth: 40, ..small(&scene, 41, 5, 9) };
    let whole = render(&mut renderer, &scene, &settings);
    let rays = |of: &Rendered| serde_json::to_string(&of.report.rays).unwrap();
    let traced = |of: &Rendered| -> Vec<u64> { of.report.rays.by_depth.iter().map(|d| d.traced).collect() };
    assert!(traced(&whole).len() == 40 && traced(&whole).iter().all(|n| *n > 0));
    let none = Schedule::default();
    for schedule in [
        Schedule { tile_pixels: Some(37), batch_samples: Some(1), ..none },
        Schedule { batch_samples: Some(2), ..none },
        Schedule { fused: Some(true), batch_samples: Some(2), ..none },
        Schedule {
            walk_steps: Some(1),
            forced_features: ForcedFeatures::default().with(Feature::Hierarchy),
            ..none
        },
    ] {
        let found = render(&mut renderer, &scene, &Settings { schedule, ..settings.clone() });
        assert_eq!((hash(&found), rays(&found)), (hash(&whole), rays(&whole)), "{schedule:?}");
    }
    // What is asked for in vain costs no dispatch, and one depth more is not lost.
    for (depth, deepest) in [(16, 16), (17, 17), (18, 18)] {
        let found = render(&mut renderer, &scene, &Settings { depth, ..settings.clone() });
        assert_eq!(traced(&found)[..], traced(&whole)[..deepest]);
    }
    let (_, ended) = scenes().into_iter().find(|(name, _)| name == "cornell").unwrap();
    let of = |depth| Settings { depth, ..small(&ended, 41, 2, 9) };
    let found = render(&mut renderer, &ended, &of(1024));
    assert_eq!(found.report.passes.iter().map(|p| p.depth).max(), Some(16));
    assert_eq!(hash(&found), hash(&render(&mut renderer, &ended, &of(16))));
}

/// Every way of building a hierarchy, and none at all, over overlapping spheres and a mesh.
#[test]
fn hierarchies_change_no_bit() {
    let (_, mut scene) = subjects().into_iter().find(|(name, _)| name == "cornell_glass").unwrap();
    let of = scene.spheres[0];
    for i in 0..300 {
        let at = f64::from(i) * 2.4;
        let center = of.center + glam::DVec3::new(at.cos(), (at * 0.37).sin(), at.sin()) * (at / 200.0);
        scene.spheres.push(Sphere { center, radius: of.radius * 0.1, ..of });
    }
    let settings = small(&scene, 60, 2, 5);
    let mut renderer = renderer();
    let mut with = |hierarchy, brute_force| {
        renderer.force_brute_force(brute_force);
        let schedule = Schedule { hierarchy, ..Schedule::default() };
        hash(&render(&mut renderer, &scene, &Settings { schedule, ..settings.clone() }))
    };
    let expected = with(Hierarchy::Balanced, Some(true));
    for hierarchy in Hierarchy::ALL {
        assert_eq!(with(hierarchy, Some(false)), expected, "{}", hierarchy.name());
    }
}

#[test]
fn a_queue_too_small_costs_no_bit() {
    let mut renderer = renderer();
    let (_, scene) = subjects().into_iter().find(|(name, _)| name == "nested_glass").unwrap();
    let settings = small(&scene, 40, 4, 2);
    let roomy = render(&mut renderer, &scene, &settings);
    // The kernels of short renders, and of long ones.
    for (tile_pixels, batch_samples, fused) in
        [(400, 4, None), (200, 1, None), (60, 3, None), (400, 4, Some(true)), (60, 3, Some(true))]
    {
        let schedule = Schedule {
            tile_pixels: Some(tile_pixels),
            batch_samples: Some(batch_samples),
            fused,
            ..Schedule::default()
        };
        let fits = render(&mut renderer, &scene, &Settings { schedule, ..settings.clone() });
        let schedule = Schedule { capacity: Some(1), ..schedule };
        let tight = render(&mut renderer, &scene, &Settings { schedule, ..settings.clone() });
        let (a, b) = (&tight.report.plan, &fits.report.plan);
        assert!(a.tiles > b.tiles || a.batches > b.batches, "no queue overflowed: {a:?}");
        assert_eq!(hash(&tight), hash(&roomy));
        assert_eq!(tight.report.rays.total(), roomy.report.rays.total(), "a void tile was counted");
    }
}

#[test]
fn a_crop_is_a_part_of_the_whole() {
    let mut renderer = renderer();
    for (name, scene) in subjects() {
        let settings = small(&scene, 41, 3, 4);
        let whole = render(&mut renderer, &scene, &settings);
        let [x0, y0, x1, y1] = [7, 3, 30, 19];
        let crop = Settings { crop: Some([x0, y0, x1, y1]), ..settings.clone() };
        let part = render(&mut renderer, &scene, &crop);
        let row = |y: u32| &whole.linear[(y * 41 + x0) as usize..(y * 41 + x1) as usize];
        let cut: Vec<[f32; 3]> = (y0..y1).flat_map(|y| row(y).to_vec()).collect();
        assert_eq!(linear_sha256(&cut), hash(&part), "{name}");
    }
}

#[test]
fn nothing_unwritten_is_read() {
    let mut renderer = renderer();
    for (name, scene) in scenes() {
        let schedule = Schedule { tile_pixels: Some(500), ..Schedule::default() };
        let settings = Settings { schedule, ..small(&scene, 41, 3, 4) };
        let clean = render(&mut renderer, &scene, &settings);
        renderer.poison_buffers(true);
        let poisoned = render(&mut renderer, &scene, &settings);
        renderer.poison_buffers(false);
        assert_eq!(hash(&poisoned), hash(&clean), "{name}");
        assert_eq!(poisoned.report.counters.nan_rays, 0, "{name}");
    }
}

/// Renders in a fresh process under `variables`; the hash from its report.
fn elsewhere(folder: &Path, scene: &str, variables: &[(&str, &str)]) -> String {
    let report = folder.join("report.json");
    let output = Command::new(env!("CARGO_BIN_EXE_whitted"))
        .arg("render")
        .arg(format!("{}/scenes/{scene}.toml", env!("CARGO_MANIFEST_DIR")))
        .arg("-o")
        .arg(folder.join("image.png"))
        .args(["--size", "40x30", "--samples", "3", "--device", "cpu", "--report"])
        .arg(&report)
        // Code compiled for other vectors must not come from a cache.
        .env("MESA_SHADER_CACHE_DISABLE", "true")
        .env("XDG_CACHE_HOME", folder)
        .envs(variables.iter().copied())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let report: Report = serde_json::from_slice(&std::fs::read(report).unwrap()).unwrap();
    report.image.linear_sha256
}

/// A subgroup of lavapipe is its vector: 8 lanes unless told, here also 4 and 16.
#[test]
fn threads_and_vector_width_change_no_bit() {
    let folder = tempfile::tempdir().unwrap();
    for scene in ["nested_glass", "cornell_glass", "mesh_glass"] {
        let expected = elsewhere(folder.path(), scene, &[]);
        assert_eq!(expected.len(), 64);
        for variables in [
            &[("LP_NUM_THREADS", "1")][..],
            &[("LP_NUM_THREADS", "2")],
            &[("LP_NATIVE_VECTOR_WIDTH", "128")],
            &[("LP_NATIVE_VECTOR_WIDTH", "512"), ("LP_NUM_THREADS", "1")],
        ] {
            assert_eq!(elsewhere(folder.path(), scene, variables), expected, "{scene}: {variables:?}");
        }
    }
}

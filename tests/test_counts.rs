//! Box and primitive tests as the program shows them: by depth and kind in `profile --tests`, per pixel in the layer
//! `tests`; the sums of both are the same.

// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

use assert_cmd::Command;
use serde_json::Value;
use std::fs;
use tempfile::TempDir;
use whitted::render::{Quiet, Renderer};
use whitted::scene::Scene;
use whitted::settings::{DeviceChoice, Settings};

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/");
const SMALL: &[&str] = &["--size", "36x30", "--samples", "4", "--device", "cpu"];

fn whitted(folder: &TempDir, words: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_whitted"));
    command.current_dir(folder.path()).args(words).args(SMALL).env_remove("WHITTED_DEVICE");
    command
}

#[test]
fn the_profile_counts_each_kind_at_each_depth() {
    let folder = TempDir::new().unwrap();
    let scene = format!("{FOLDER}cornell_glass.toml");
    let words = ["profile", &scene, "--repeats", "1", "--tests", "--json", "a.json", "--page", "a.html"];
    let out = whitted(&folder, &words).assert().success();
    let text = String::from_utf8_lossy(&out.get_output().stdout).into_owned();
    assert!(text.contains("box tests") && text.contains("refraction"), "{text}");
    assert!(fs::read_to_string(folder.path().join("a.html")).unwrap().contains("<h2 id=\"tests\">"));
    let report: Value = serde_json::from_slice(&fs::read(folder.path().join("a.json")).unwrap()).unwrap();
    let tests = &report["tests"];
    let rows = tests["by_kind"].as_array().unwrap();
    let sum = |key: &str| rows.iter().map(|row| row[key].as_u64().unwrap()).sum::<u64>();
    assert_eq!(
        (sum("boxes"), sum("primitives")),
        (tests["boxes"].as_u64().unwrap(), tests["primitives"].as_u64().unwrap())
    );
    // Every ray of the report is in one row.
    let rays = &report["rays"];
    let all = ["primary", "reflection", "refraction", "shadow"].map(|kind| rays[kind].as_u64().unwrap());
    assert_eq!(sum("rays"), all.iter().sum::<u64>());
    for row in rows {
        let depth = &rays["by_depth"][row["depth"].as_u64().unwrap() as usize - 1];
        assert_eq!(depth[row["kind"].as_str().unwrap()], row["rays"]);
    }
    // Without being asked nothing is counted.
    let words = ["profile", &scene, "--repeats", "1", "--json", "b.json"];
    whitted(&folder, &words).assert().success();
    let report: Value = serde_json::from_slice(&fs::read(folder.path().join("b.json")).unwrap()).unwrap();
    assert!(report.get("tests").is_none());
}

#[test]
fn the_layer_adds_up_to_the_profile() {
    let mut renderer = Renderer::new(&DeviceChoice::Cpu).unwrap();
    for name in ["cornell.toml", "cornell_glass.toml"] {
        let scene = Scene::load(format!("{FOLDER}{name}")).unwrap();
        for brute_force in [true, false] {
            renderer.force_brute_force(Some(brute_force));
            let own = Settings::of(&scene);
            let mut settings = Settings { width: 24, height: 20, samples: 18, replicates: 3, ..own };
            let layer = renderer.tests_per_pixel(&scene, &settings, &mut Quiet).unwrap().unwrap();
            assert!(layer.len() == 480 && layer.iter().all(|tests| *tests > 0.0));
            settings.schedule.count_tests = true;
            let rendered = renderer.render(&scene, &settings).unwrap();
            let tests = rendered.report.tests.unwrap();
            let all = layer.iter().sum::<f64>() as u64;
            // A packet's box tests depend on which rays it has: a survey takes pixels row by row.
            if brute_force {
                assert_eq!((0, all), (tests.boxes, tests.primitives), "{name}");
            } else {
                let ratio = all as f64 / (tests.boxes + tests.primitives) as f64;
                assert!((0.5..2.0).contains(&ratio), "{name}: {ratio}");
            }
        }
    }
}

#[test]
fn the_layer_is_written_and_refused_where_samples_differ() {
    let folder = TempDir::new().unwrap();
    let scene = format!("{FOLDER}cornell.toml");
    let words = ["render", &scene, "-o", "a.png", "--aov", "tests", "-q"];
    whitted(&folder, &words).assert().success();
    assert!(folder.path().join("a.tests.png").exists());
    let mut command = Command::new(env!("CARGO_BIN_EXE_whitted"));
    let words = ["render", &scene, "-o", "b.png", "--aov", "tests", "--error", "0.1", "--device", "cpu"];
    command.current_dir(folder.path()).args(words).assert().failure().code(2);
}

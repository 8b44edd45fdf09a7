//! The error of an image on its way, against a reference picture: the same bits as without it, a point after each
//! round, and pictures that do not fit refused before anything is rendered.

// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

use assert_cmd::Command;
use serde_json::Value;
use std::fs;
use std::path::Path;
use tempfile::TempDir;
use whitted::render::{Observer, Rendered, Renderer};
use whitted::scene::Scene;
use whitted::settings::{DeviceChoice, Schedule, Settings};
use whitted::{Convergence, Picture, Quiet, compare};

const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell_glass.toml");

fn bits(rendered: &Rendered) -> Vec<u32> {
    rendered.linear.as_flattened().iter().map(|c| c.to_bits()).collect()
}

/// Ends after so many submits.
struct StopAfter(u32);

impl Observer for StopAfter {
    fn progress(&mut self, _done: u64, _total: u64) {
        self.0 = self.0.saturating_sub(1);
    }
    fn cancelled(&self) -> bool {
        self.0 == 0
    }
}

#[test]
fn rounds_give_the_bits_of_a_plain_render_and_a_point_each() {
    let scene = Scene::load(Path::new(SCENE)).unwrap();
    let mut renderer = Renderer::new(&DeviceChoice::Cpu).unwrap();
    // Tiles that divide nothing, and queues so small that some overflow.
    let small =
        Schedule { tile_pixels: Some(97), batch_samples: Some(4), capacity: Some(1), ..Schedule::default() };
    for (schedule, replicates, samples) in [(Schedule::default(), 1, 11), (small, 3, 12)] {
        let settings = Settings {
            width: 30,
            height: 20,
            samples,
            seed: 5,
            replicates,
            schedule,
            ..Settings::of(&scene)
        };
        let plain = renderer.render(&scene, &settings).unwrap();
        let other = renderer.render(&scene, &Settings { seed: 6, ..settings.clone() }).unwrap();
        let mut quiet = Quiet;
        let mut convergence = Convergence::new(&other.linear, &mut quiet);
        let seen = renderer.render_with(&scene, &settings, &mut convergence).unwrap();
        let points = convergence.into_points();
        assert_eq!(bits(&seen), bits(&plain));
        assert_eq!(seen.report.image.linear_sha256, plain.report.image.linear_sha256);
        let rounds: Vec<f64> = points.iter().map(|p| p.samples).collect();
        assert_eq!(rounds, [1.0, 2.0, 4.0, 8.0, f64::from(samples)]);
        assert!(points.windows(2).all(|p| p[0].seconds <= p[1].seconds && p[0].rays < p[1].rays));
        let last = points.last().unwrap();
        assert_eq!(last.rmse, compare(&plain.linear, &other.linear).unwrap().rmse);
        assert_eq!(last.rays, plain.report.rays.total());
        assert!(points[0].rmse > last.rmse);
        // What a report says of the work is the same, however it was divided.
        assert_eq!(seen.report.rays.by_depth, plain.report.rays.by_depth);
        let pixels = |r: &Rendered| r.report.passes.iter().find(|p| p.name == "resolve").unwrap().items;
        assert_eq!(pixels(&seen), pixels(&plain));
    }
}

#[test]
fn an_interrupted_one_keeps_what_is_done() {
    let scene = Scene::load(Path::new(SCENE)).unwrap();
    let mut renderer = Renderer::new(&DeviceChoice::Cpu).unwrap();
    let schedule = Schedule { tile_pixels: Some(100), batch_samples: Some(1), ..Schedule::default() };
    let settings = Settings { width: 30, height: 20, samples: 16, schedule, ..Settings::of(&scene) };
    let reference = vec![[0.0; 3]; 600];
    let mut stop = StopAfter(9);
    let mut convergence = Convergence::new(&reference, &mut stop);
    let part = renderer.render_with(&scene, &settings, &mut convergence).unwrap();
    assert!(part.done > 0.0 && part.done < 1.0 && part.state.is_some(), "{}", part.done);
    assert!(part.linear.iter().all(|pixel| pixel.iter().sum::<f32>() > 0.0), "every pixel has a sample");
    assert!(!convergence.into_points().is_empty());
}

fn whitted(folder: &TempDir, words: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_whitted"));
    command.current_dir(folder.path()).args(words).args(["--device", "cpu"]).env_remove("WHITTED_DEVICE");
    command
}

fn points(folder: &TempDir, report: &str) -> Vec<Value> {
    let report: Value = serde_json::from_slice(&fs::read(folder.path().join(report)).unwrap()).unwrap();
    report["reference"]["points"].as_array().unwrap().clone()
}

#[test]
fn the_program_draws_the_curve_of_every_kind_of_render() {
    let folder = TempDir::new().unwrap();
    let size = ["--size", "30x20"];
    let render = |words: &[&str]| {
        let all = [&["render", SCENE][..], words, &size].concat();
        whitted(&folder, &all)
    };
    render(&["-o", "truth.exr", "--samples", "64", "-q"]).assert().success();
    let with = ["--reference", "truth.exr"];
    let plain = ["-o", "a.exr", "--samples", "64", "--report", "a.json", "--page", "a.html", "-v"];
    let out = render(&[&plain[..], &with].concat()).assert().success();
    let stderr = String::from_utf8_lossy(&out.get_output().stderr).into_owned();
    // The picture is its own reference: the last point has no error.
    assert!(stderr.contains("error against truth.exr"), "{stderr}");
    assert!(stderr.contains("difference from truth.exr: 0 (RMSE"), "{stderr}");
    let rows = points(&folder, "a.json");
    assert_eq!(rows.len(), 7);
    assert!(rows[0]["rmse"].as_f64().unwrap() > 0.0 && rows[6]["rmse"] == 0.0);
    let page = fs::read_to_string(folder.path().join("a.html")).unwrap();
    assert!(page.contains("Error against time") && page.contains("Error against rays"));

    for (name, words) in [
        ("error", &["--error", "0.012"][..]),
        ("time", &["--time", "3"]),
        ("budget", &["--budget", "--samples", "4"]),
    ] {
        let report = format!("{name}.json");
        let more = ["-o", "b.exr", "--report", report.as_str(), "-q"];
        render(&[words, &more, &with].concat()).assert().success();
        let rows = points(&folder, &report);
        // An error may be reached by the pilot alone.
        assert!(rows.len() >= if name == "time" { 2 } else { 1 }, "{name}: {rows:?}");
        // The last point is of the file that was written.
        let [image, truth] = ["b.exr", "truth.exr"].map(|n| Picture::read(folder.path().join(n)).unwrap());
        let rmse = compare(&image.linear, &truth.linear).unwrap().rmse;
        assert_eq!(rows.last().unwrap()["rmse"].as_f64(), Some(rmse), "{name}");
    }
}

#[test]
fn what_does_not_fit_is_refused_before_anything_is_rendered() {
    let folder = TempDir::new().unwrap();
    whitted(&folder, &["render", SCENE, "-o", "small.exr", "--size", "12x10", "--samples", "1", "-q"])
        .assert()
        .success();
    fs::write(folder.path().join("text.exr"), "no picture").unwrap();
    for (reference, part) in [
        ("small.exr", "small.exr has 12x10 pixels and the image 30x20"),
        ("text.exr", "cannot read text.exr as a PNG"),
        ("none.exr", "cannot read none.exr"),
    ] {
        let words = ["render", SCENE, "-o", "out.png", "--size", "30x20", "--reference", reference];
        let out = whitted(&folder, &words).assert().failure().code(1);
        let stderr = String::from_utf8_lossy(&out.get_output().stderr).into_owned();
        assert!(stderr.contains(part), "{stderr}");
        assert!(!folder.path().join("out.png").exists());
    }
    let words = ["render", SCENE, "-o", "out.png", "--reference", "small.exr", "--resume"];
    whitted(&folder, &words).assert().failure().code(2);
}

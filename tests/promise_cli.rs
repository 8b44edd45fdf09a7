//! Images with a known error as their users meet them: exit codes, reports, layers, and going on after an
//! interrupt. Renders run on the software device.

// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

use assert_cmd::Command;
use serde_json::Value;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell.toml");

fn whitted(output: &str, words: &[&str]) -> Command {
    whitted_of(SCENE, output, words)
}

fn whitted_of(scene: &str, output: &str, words: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_whitted"));
    command.args(["render", scene, "--device", "cpu", "-o", output]).args(words);
    command
}

struct Bench(TempDir);

impl Bench {
    fn new() -> Bench {
        Bench(tempfile::tempdir().unwrap())
    }

    fn at(&self, name: &str) -> String {
        self.0.path().join(name).display().to_string()
    }

    fn names(&self) -> Vec<String> {
        let name = |e: fs::DirEntry| e.file_name().into_string().unwrap();
        let mut names: Vec<_> = fs::read_dir(self.0.path()).unwrap().map(|e| name(e.unwrap())).collect();
        names.sort();
        names
    }

    /// Renders to `image`; gives the report.
    fn render(&self, image: &str, words: &[&str], code: i32) -> Value {
        self.render_scene(SCENE, image, words, code)
    }

    /// The same of another scene.
    fn render_scene(&self, scene: &str, image: &str, words: &[&str], code: i32) -> Value {
        let report = self.at("report.json");
        let output = self.at(image);
        whitted_of(scene, &output, words).args(["--report", &report]).assert().code(code);
        assert!(Path::new(&output).exists());
        let report = fs::read(report).unwrap();
        serde_json::from_slice(&report).unwrap()
    }
}

#[test]
fn what_cannot_be_is_a_usage_error() {
    let bench = Bench::new();
    let cases = [
        "--error 0",
        "--error -1",
        "--error 0.01 --confidence 2",
        "--error 0.01 --samples 4",
        "--error 0.01 --time 1",
        "--error 0.01 --replicates 4",
        "--error 0.01 --precision fast",
        "--error 0.01 --aov rounding",
        "--time 0",
        "--time 1 --samples 4",
        "--time 1 --aov rounding",
        "--budget --samples 1",
        "--budget --samples 6 --replicates 4",
        "--aov sampling,colour",
    ];
    for case in cases {
        let words: Vec<&str> = case.split(' ').collect();
        let output = whitted(&bench.at("a.png"), &words).assert().code(2).get_output().clone();
        assert!(!output.stderr.is_empty(), "{case}");
    }
    whitted("-", &["--aov", "samples"]).assert().code(2);
    assert_eq!(bench.names(), Vec::<String>::new());
}

#[test]
fn a_budget_tells_its_four_parts() {
    let bench = Bench::new();
    let report = bench.render("a.png", &["--size", "24x20", "--samples", "6", "--budget"], 0);
    let error = &report["error"];
    assert_eq!((&error["kind"], &error["confidence"]), (&"rmse".into(), &0.95.into()));
    let part = |name: &str| error[name].as_f64().unwrap_or_else(|| panic!("{name}: {error}"));
    let sum = part("sampling") + part("truncation") + part("rounding") + part("encoding");
    assert!(part("sampling") > 0.0 && (part("total") - sum).abs() < 1e-12, "{error}");
    assert_eq!(error["truncation_bounded"], true);
    assert_eq!(report["asked"]["error"], Value::Null);
    assert_eq!(report["asked"]["met"], Value::Null);
    assert!(part("encoding") > 1e-4 && part("encoding") < 3e-3, "steps of 8 bits: {error}");
    assert_eq!((&report["settings"]["samples"], &report["settings"]["replicates"]), (&6.into(), &1.into()));
    // The image is the one without a budget, as far as sums of quarters round alike.
    let plain = bench.render("b.png", &["--size", "24x20", "--samples", "6"], 0);
    let pixels = |name: &str| image::open(bench.at(name)).unwrap().into_rgb8().into_raw();
    let apart = pixels("a.png").iter().zip(pixels("b.png")).filter(|(a, b)| a.abs_diff(*b) > 0).count();
    assert!(apart <= 2, "{apart} codes differ");
    assert_eq!(plain["error"], Value::Null);
    // A file of 16 bits loses less, and EXR nothing.
    let encoding = |name: &str, words: &[&str]| {
        let words = [&["--size", "24x20", "--samples", "6", "--budget"], words].concat();
        bench.render(name, &words, 0)["error"]["encoding"].as_f64().unwrap()
    };
    assert!(encoding("c.png", &["--bits", "16"]) < 0.01 * part("encoding"));
    assert_eq!(encoding("c.exr", &[]), 0.0);
}

/// An error that 8 bits cannot keep takes 16, unless the bits are given.
#[test]
fn bits_are_chosen_for_the_error() {
    let bench = Bench::new();
    let words = ["--size", "24x20", "--error", "0.004"];
    let report = bench.render("a.png", &words, 0);
    assert!(report["error"]["encoding"].as_f64().unwrap() < 1e-4, "{}", report["error"]);
    let color = |name: &str| image::open(bench.at(name)).unwrap().color();
    assert_eq!(color("a.png"), image::ColorType::Rgb16);
    let report = bench.render("b.png", &[&words[..], &["--bits", "8"]].concat(), 0);
    assert!(report["error"]["encoding"].as_f64().unwrap() > 1e-4, "{}", report["error"]);
    assert_eq!(color("b.png"), image::ColorType::Rgb8);
}

#[test]
fn an_error_is_reached_and_the_same_however_the_work_is_cut() {
    let bench = Bench::new();
    let words = ["--size", "24x20", "--error", "0.02", "--confidence", "0.9"];
    let report = bench.render("a.exr", &words, 0);
    assert_eq!((&report["asked"]["error"], &report["asked"]["met"]), (&0.02.into(), &true.into()));
    assert!(report["error"]["total"].as_f64().unwrap() <= 0.02, "{}", report["error"]);
    assert_eq!(report["error"]["confidence"], 0.9);
    let hash = report["image"]["linear_sha256"].clone();
    let cut = ["--tile-pixels", "37", "--workgroup", "128", "--batch-samples", "3"];
    for cut in [&[][..], &cut] {
        let again = bench.render("b.exr", &[&words[..], cut].concat(), 0);
        assert_eq!(again["image"]["linear_sha256"], hash, "{cut:?}");
        assert_eq!(again["rays"], report["rays"], "{cut:?}");
    }
}

#[test]
fn an_error_that_cannot_be_reached_leaves_the_image_and_says_why() {
    let bench = Bench::new();
    let report = bench.render("a.png", &["--size", "24x20", "--error", "0.004", "--depth", "1"], 7);
    assert_eq!(report["asked"]["met"], false);
    let why = report["asked"]["unmet_why"].as_str().unwrap();
    assert!(why.contains("rays that are not traced can contribute more"), "{why}");
    assert!(report["error"]["truncation"].as_f64().unwrap() > 0.004);
    assert_eq!(bench.names(), ["a.png", "report.json"]);
}

/// What is certain of rays beyond depth 8 is above this error; what they hide in the pixels that are traced deeper is not.
#[test]
fn an_error_is_kept_at_a_depth_whose_rays_hide_less_than_they_may() {
    let bench = Bench::new();
    // A lamp below the ceiling: what is certain takes every ray for one that ends there.
    let scenes = Path::new(SCENE).parent().unwrap();
    let glass = fs::read_to_string(scenes.join("cornell_glass.toml")).unwrap();
    let cube = scenes.join("rotated_cube.obj").display().to_string();
    let changes =
        [("[0, 5, 5]", "[0, 9.9, 5]"), ("intensity = 10", "intensity = 30"), ("rotated_cube.obj", &cube)];
    let lamp = changes.iter().fold(glass, |text, (from, to)| text.replace(from, to));
    let scene = bench.at("lamp.toml");
    fs::write(&scene, lamp).unwrap();
    let words = ["--size", "96x72", "--error", "0.1", "--depth", "8"];
    let report = bench.render_scene(&scene, "a.png", &words, 0);
    let part = |name: &str| report["error"][name].as_f64().unwrap();
    assert!(part("truncation_certain") > 0.1 && part("truncation") < 0.1, "{}", report["error"]);
    assert_eq!(report["asked"]["met"], true);
}

#[test]
fn an_error_that_no_samples_give_is_refused_soon() {
    let bench = Bench::new();
    let report = bench.render("a.exr", &["--size", "24x20", "--error", "1e-7"], 7);
    let why = report["asked"]["unmet_why"].as_str().unwrap();
    assert!(why.contains("even 65536 samples in every pixel"), "{why}");
    assert!(report["settings"]["samples"].as_u64().unwrap() <= 256, "{}", report["settings"]);
}

#[test]
fn a_time_far_too_short_gives_a_coarse_image_of_unknown_error() {
    let bench = Bench::new();
    let report = bench.render("a.exr", &["--size", "120x100", "--time", "0.001"], 7);
    assert_eq!((&report["asked"]["time"], &report["asked"]["met"]), (&0.001.into(), &false.into()));
    let why = report["asked"]["unmet_why"].as_str().unwrap();
    assert!(why.contains("too short") && why.contains("the error is unknown"), "{why}");
    assert_eq!(report["error"], Value::Null);
    assert_eq!(report["settings"]["crop"], Value::Null);
    // 64, 32, 16, 8 and some of 4: no pixel is left black that is lit around.
    let image = whitted::Picture::read(bench.at("a.exr")).unwrap();
    let lit = image.linear.iter().filter(|c| c.iter().any(|c| *c > 0.0)).count();
    assert!(lit > image.linear.len() / 2, "{lit} of {}", image.linear.len());
}

#[test]
fn a_crop_has_its_own_error() {
    let bench = Bench::new();
    let words = ["--size", "60x50", "--crop", "20,10,44,30", "--error", "0.02"];
    let report = bench.render("a.exr", &words, 0);
    assert_eq!(report["settings"]["crop"], serde_json::json!([20, 10, 44, 30]));
    let image = whitted::Picture::read(bench.at("a.exr")).unwrap();
    assert_eq!((image.width, image.height), (24, 20));
}

#[test]
fn layers_are_pictures_beside_a_png_and_channels_of_an_exr() {
    use exr::prelude::*;
    let bench = Bench::new();
    let layers = ["sampling", "truncation", "rounding", "samples", "depth", "cost"];
    let words = ["--size", "24x20", "--samples", "16", "--aov", &layers.join(",")];
    bench.render("a.png", &words, 0);
    let mut expected: Vec<String> = layers.iter().map(|l| format!("a.{l}.png")).collect();
    expected.extend(["a.png".into(), "report.json".into()]);
    expected.sort();
    assert_eq!(bench.names(), expected);
    for layer in layers {
        let painted = image::open(bench.at(&format!("a.{layer}.png"))).unwrap();
        // With its scale.
        assert!(painted.width() >= 24 && painted.height() > 20, "{layer}");
    }

    let bench = Bench::new();
    bench.render("a.exr", &words, 0);
    assert_eq!(bench.names(), ["a.exr", "report.json"]);
    let file = read_first_flat_layer_from_file(bench.at("a.exr")).unwrap();
    assert_eq!(file.layer_data.size, Vec2(24, 20));
    let channel = |name: &str| -> Vec<f32> {
        let found = file.layer_data.channel_data.list.iter().find(|c| c.name.to_string() == name);
        found.unwrap_or_else(|| panic!("no channel {name}")).sample_data.values_as_f32().collect()
    };
    assert_eq!(channel("samples.Y"), vec![16.0; 24 * 20]);
    assert!(channel("cost.Y").iter().all(|rays| *rays >= 16.0));
    assert!(channel("depth.Y").iter().all(|depth| (1.0..=4.0).contains(depth)));
    for name in ["sampling.Y", "truncation.Y", "rounding.Y"] {
        assert!(channel(name).iter().all(|x| *x >= 0.0), "{name}");
    }
}

/// Kills the program if the test ends before it.
#[cfg(unix)]
struct Stopped(std::process::Child);

#[cfg(unix)]
impl Drop for Stopped {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Starts a render, interrupts it once it is under way; its last line and exit code.
#[cfg(unix)]
fn interrupted(output: &str, words: &[&str]) -> (String, Option<i32>) {
    use std::io::{BufRead, BufReader};
    use std::process::{Command, Stdio};
    let child = Command::new(env!("CARGO_BIN_EXE_whitted"))
        .args(["render", SCENE, "-o", output, "--device", "cpu", "-v"])
        .args(words)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut child = Stopped(child);
    let mut lines = BufReader::new(child.0.stderr.take().unwrap()).lines().map(Result::unwrap);
    // Beyond the choice of precision and depth.
    let share = |line: &str| line.split_once(": ")?.1.strip_suffix(" %")?.parse::<f64>().ok();
    assert!(
        lines.any(|line| line.starts_with("rendering") && share(&line).is_some_and(|s| s > 10.0)),
        "it ended before it was stopped"
    );
    // The shell's own `kill`: the program of that name is not on every machine.
    let interrupt = format!("kill -INT {}", child.0.id());
    assert!(Command::new("sh").args(["-c", &interrupt]).status().unwrap().success());
    (lines.last().unwrap(), child.0.wait().unwrap().code())
}

#[cfg(unix)]
#[test]
fn an_interrupted_error_resumes_to_the_same_image() {
    let bench = Bench::new();
    let words = ["--size", "24x20", "--error", "0.006"];
    let whole = bench.render("whole.exr", &words, 0);
    fs::remove_file(bench.at("report.json")).unwrap();
    // Slowed down: how the work is cut changes no bit.
    let slow = [&words[..], &["--tile-pixels", "4", "--batch-samples", "1"]].concat();
    let (last, code) = interrupted(&bench.at("a.exr"), &slow);
    assert_eq!(code, Some(130), "{last}");
    assert!(last.contains("continue with --resume"), "{last}");
    assert_eq!(bench.names(), ["a.exr.partial", "a.incomplete.exr", "whole.exr"]);

    // Another request does not go on from it, nor does a plain render, and they say why.
    let cases: [(&[&str], &str); 4] = [
        (&["--error", "0.01", "--size", "24x20"], "--error 0.006"),
        (&["--error", "0.006", "--size", "24x21"], "--size 24x20"),
        (&["--budget", "--size", "24x20"], "--budget"),
        (&["--size", "24x20"], "a render with --error, --time or --budget"),
    ];
    for (other, why) in cases {
        let refused = whitted(&bench.at("a.exr"), other).arg("--resume").assert().code(1);
        let said = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
        assert!(said.contains(why) && said.contains("a.exr.partial"), "{other:?}: {said}");
    }
    let resumed = bench.render("a.exr", &[&words[..], &["--resume"]].concat(), 0);
    assert_eq!(bench.names(), ["a.exr", "report.json", "whole.exr"], "the state is gone");
    assert_eq!(resumed["image"]["linear_sha256"], whole["image"]["linear_sha256"]);
    assert_eq!((&resumed["error"], &resumed["rays"]), (&whole["error"], &whole["rays"]));
}

#[cfg(unix)]
#[test]
fn an_interrupted_budget_resumes_to_the_same_image() {
    let bench = Bench::new();
    let words = ["--size", "24x20", "--samples", "64", "--budget"];
    let whole = bench.render("whole.exr", &words, 0);
    let slow = [&words[..], &["--tile-pixels", "2", "--batch-samples", "1"]].concat();
    let (last, code) = interrupted(&bench.at("a.exr"), &slow);
    assert_eq!(code, Some(130), "{last}");

    // A damaged state is not gone on with.
    let state = fs::read(bench.at("a.exr.partial")).unwrap();
    let mut damaged = state.clone();
    damaged[state.len() - 1] ^= 1;
    fs::write(bench.at("a.exr.partial"), damaged).unwrap();
    let refused = whitted(&bench.at("a.exr"), &words).arg("--resume").assert().code(1);
    let said = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
    assert!(said.contains("wrong checksum"), "{said}");

    fs::write(bench.at("a.exr.partial"), state).unwrap();
    let resumed = bench.render("a.exr", &[&words[..], &["--resume"]].concat(), 0);
    assert_eq!(resumed["image"]["linear_sha256"], whole["image"]["linear_sha256"]);
    assert_eq!(resumed["error"], whole["error"]);
    assert_eq!(resumed["rays"], whole["rays"]);
}

/// A picture that is known to be wrong is never a success: a light so bright that single precision ends.
#[test]
fn pixels_beyond_single_precision_are_exit_code_8_or_7() {
    let folder = tempfile::tempdir().unwrap();
    let text = "[camera]\nlook_from = [0.001, 2, 0]\nlook_at = [0, 0, 0]\n\
        [[light]]\nposition = [0, 0.3, 0]\nintensity = 3e38\n[material.a]\ndiffuse = [1, 1, 1]\n\
        [[polygon]]\nvertices = [[-2, 0, 2], [2, 0, 2], [2, 0, -2], [-2, 0, -2]]\nmaterial = \"a\"\n";
    fs::write(folder.path().join("s.toml"), text).unwrap();
    let run = |words: &str, code: i32| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_whitted"));
        command.current_dir(folder.path()).args(words.split_whitespace()).env("WHITTED_DEVICE", "cpu");
        let output = command.assert().code(code).get_output().clone();
        String::from_utf8(output.stderr).unwrap()
    };
    let options = "--size 30x25 --samples 4 -q";
    assert!(run(&format!("render s.toml -o a.exr {options}"), 8).contains("are not finite"));
    assert!(run(&format!("render s.toml -o a.exr {options} --budget"), 7).contains("are not finite"));
    for share in 1..=2 {
        run(&format!("render s.toml -o {share}.share --share {share}/2 {options}"), 8);
    }
    assert!(run("merge 1.share 2.share -o m.exr -q", 8).contains("are not finite"));
    assert!(folder.path().join("m.exr").exists(), "it is there to be looked at");
}

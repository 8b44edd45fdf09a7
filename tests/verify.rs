//! `whitted verify` and settings chosen beforehand: what a report describes can be drawn again, and a wrong pixel is
//! found.

// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

use assert_cmd::Command;
use serde_json::Value;
use std::fs;
use std::path::PathBuf;
use tempfile::TempDir;
use whitted::Picture;
use whitted::compare::metrics::rmse;
use whitted::image::{Bits, Format, Metadata, View, read_metadata};

const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell_glass.toml");

struct Folder(TempDir);

impl Folder {
    fn new() -> Folder {
        Folder(tempfile::tempdir().unwrap())
    }

    fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn run(&self, words: &str, code: i32) -> String {
        let output = Command::new(env!("CARGO_BIN_EXE_whitted"))
            .current_dir(self.0.path())
            .args(words.replace("SCENE", SCENE).split_whitespace())
            .env("WHITTED_DEVICE", "cpu")
            .assert()
            .code(code)
            .get_output()
            .clone();
        String::from_utf8(output.stderr).unwrap()
    }

    fn picture(&self, name: &str) -> Picture {
        Picture::read(self.at(name)).unwrap()
    }

    /// Writes `picture` with pixel `at` changed by `change`.
    fn spoil(&self, name: &str, at: usize, change: f32) {
        let mut picture = self.picture(name);
        picture.linear[at][1] += change;
        let view = View { width: picture.width, height: picture.height, linear: &picture.linear };
        let format = match Format::of(&self.at(name)).unwrap() {
            Format::Png(_) => Format::Png(Bits::Eight),
            other => other,
        };
        let mut bytes = Vec::new();
        format.encode(view, &Metadata::default(), &mut bytes).unwrap();
        fs::write(self.at(name), bytes).unwrap();
    }

    fn edit(&self, name: &str, edit: impl Fn(&mut Value)) {
        let mut json: Value = serde_json::from_slice(&fs::read(self.at(name)).unwrap()).unwrap();
        edit(&mut json);
        fs::write(self.at(name), json.to_string()).unwrap();
    }
}

#[test]
fn a_picture_is_verified_and_a_wrong_pixel_found() {
    let folder = Folder::new();
    for format in ["exr", "png", "hdr"] {
        let (render, verify) = (format!("render SCENE -o a.{format}"), "verify a.json --diff d.png");
        folder.run(&format!("{render} --size 40x30 --samples 4 --report a.json"), 0);
        let said = folder.run(verify, 0);
        assert!(said.contains("same bits: a."), "{format}: {said}");
        assert!(!folder.at("d.png").exists(), "there is no difference to show");
        // Row 7, column 12.
        folder.spoil(&format!("a.{format}"), 7 * 40 + 12, 0.05);
        let said = folder.run(verify, 6);
        assert!(said.contains("1 pixel of a.") && said.contains("pixel (12, 7): "), "{format}: {said}");
        assert!(folder.at("d.png").exists());
        fs::remove_file(folder.at("d.png")).unwrap();
    }
    // Without the picture the hash of the report is left.
    fs::remove_file(folder.at("a.hdr")).unwrap();
    assert!(folder.run("verify a.json", 0).contains("there is no picture"));
    folder.edit("a.json", |report| report["settings"]["seed"] = 9.into());
    assert!(folder.run("verify a.json", 6).contains("different: the hash"));
}

/// Metadata says as much as a report, for every kind of render that can be drawn again.
#[test]
fn a_picture_is_verified_by_what_it_says_of_itself() {
    let folder = Folder::new();
    for (name, options) in [
        ("a.png", "--samples 4"),
        ("b.exr", "--samples 4 --crop 3,4,30,20 --sampler stratified --seed 7 --precision f64 --depth 2"),
        ("c.hdr", "--samples 2 --cutoff 0.01"),
        ("d.ppm", "--samples 4 --replicates 2"),
        ("e.exr", "--samples 4 --budget"),
    ] {
        folder.run(&format!("render SCENE -o {name} --size 40x30 {options}"), 0);
        let said = folder.run(&format!("verify {name}"), 0);
        assert!(said.contains("same bits"), "{name}: {said}");
        // One wrong pixel, under the same metadata.
        let picture = folder.picture(name);
        let mut linear = picture.linear.clone();
        linear[45][0] += 0.05;
        let format = Format::of(&folder.at(name)).unwrap();
        let pairs = read_metadata(&folder.at(name));
        let metadata = Metadata::new(pairs.iter().map(|(k, v)| (k.as_str(), v.as_str())));
        let view = View { width: picture.width, height: picture.height, linear: &linear };
        let mut bytes = Vec::new();
        format.encode(view, &metadata, &mut bytes).unwrap();
        fs::write(folder.at(name), bytes).unwrap();
        let said = folder.run(&format!("verify {name}"), 6);
        assert!(said.contains("different: 1 pixel of"), "{name}: {said}");
    }
    folder.run("render SCENE -o a.pfm --size 24x20 --samples 1", 0);
    assert!(folder.run("verify a.pfm", 2).contains("does not say how it was rendered"));
    folder.run("render SCENE -o a.exr --size 24x20 --error 0.05", 0);
    assert!(folder.run("verify a.exr", 2).contains("pixel by pixel"));
}

/// What points up in a model is part of what a picture says.
#[test]
fn a_model_is_verified_the_way_it_stood() {
    let folder = Folder::new();
    fs::write(folder.at("m.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 2\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n")
        .unwrap();
    folder.run("render m.obj -o y.exr --size 40x30", 0);
    for axis in ["x", "-x", "-y", "z", "-z"] {
        folder.run(&format!("render m.obj -o a.exr --size 40x30 --up {axis} --report a.json"), 0);
        assert!(folder.run("verify a.exr", 0).contains("same bits"), "{axis}");
        assert!(folder.run("verify a.json", 0).contains("same bits"), "{axis}");
        let [a, y] = ["a.exr", "y.exr"].map(|name| folder.picture(name).linear);
        assert!(a != y, "{axis} looks like y");
        folder.run(&format!("import m.obj -o s.toml --size 40x30 --up {axis}"), 0);
        folder.run("render s.toml -o s.exr", 0);
        assert!(folder.picture("s.exr").linear == a, "{axis}: the imported scene is another");
    }
    assert!(folder.run("render SCENE -o a.png --up z", 2).contains("--up is for models"));
    assert!(folder.run("render m.obj -o a.png --up q", 2).contains("write x, y, z, -x, -y or -z"));
}

#[test]
fn a_crop_tells_pixels_of_the_whole_and_a_budget_is_drawn_as_one() {
    let folder = Folder::new();
    folder
        .run("render SCENE -o a.exr --size 40x30 --crop 10,20,30,28 --samples 4 --budget --report a.json", 0);
    folder.run("verify a.json", 0);
    folder.spoil("a.exr", 3 * 20 + 2, 1e-6);
    let said = folder.run("verify a.json", 6);
    assert!(said.contains("pixel (12, 23): "), "{said}");
}

#[test]
fn another_device_may_round_otherwise_but_not_more() {
    let folder = Folder::new();
    folder.run("render SCENE -o a.exr --size 40x30 --samples 4 --report a.json", 0);
    folder.edit("a.json", |report| report["device"]["driver"] = "another driver".into());
    assert!(folder.run("verify a.json", 0).contains("same bits"));
    folder.spoil("a.exr", 5, 1e-7);
    let said = folder.run("verify a.json", 0);
    assert!(said.contains("within the bound: 1 pixel") && said.contains("another driver"), "{said}");
    // An object that is not there.
    for at in 0..100 {
        folder.spoil("a.exr", 500 + at, 0.3);
    }
    let said = folder.run("verify a.json", 6);
    assert!(said.contains("101 pixels") && said.contains("more than the"), "{said}");
}

#[test]
fn what_cannot_be_drawn_again_is_said() {
    let folder = Folder::new();
    folder.run("render SCENE -o a.exr --size 24x20 --error 0.05 --report a.json", 0);
    assert!(folder.run("verify a.json", 2).contains("pixel by pixel"));
    fs::write(folder.at("b.json"), "{").unwrap();
    folder.run("verify b.json", 1);
    folder.run("verify none.json", 1);
}

#[test]
fn settings_chosen_for_an_error_are_the_same_for_all_shares() {
    let folder = Folder::new();
    folder.run("plan SCENE --size 60x50 --error 0.02 --no-trial --json p.json", 0);
    let plan: Value = serde_json::from_slice(&fs::read(folder.at("p.json")).unwrap()).unwrap();
    let samples = plan["settings"]["samples"].as_u64().unwrap();
    assert!(samples.is_power_of_two() && samples >= 4, "{samples}");
    assert!(plan["error"]["expected"].as_f64().unwrap() <= 0.02);
    for index in 1..=2 {
        folder.run(&format!("render SCENE --as p.json --share {index}/2 -o {index}.share"), 0);
    }
    folder.run("merge 2.share 1.share -o m.exr --report m.json", 0);
    folder.run("render SCENE --as p.json -o whole.exr", 0);
    assert!(fs::read(folder.at("m.exr")).unwrap() == fs::read(folder.at("whole.exr")).unwrap());
    folder.run("verify m.json", 0);
    // The error is kept, against many more samples of another seed.
    let depth = plan["settings"]["depth"].as_u64().unwrap() + 4;
    folder.run(&format!("render SCENE -o truth.exr --size 60x50 --samples 1024 --seed 5 --depth {depth}"), 0);
    let error = rmse(&folder.picture("m.exr").linear, &folder.picture("truth.exr").linear).unwrap();
    assert!(error <= 0.02, "{error}");
    // A smaller error takes more samples; one that cannot be is told.
    folder.run("plan SCENE --size 60x50 --error 0.008 --no-trial --json q.json", 0);
    let finer: Value = serde_json::from_slice(&fs::read(folder.at("q.json")).unwrap()).unwrap();
    assert!(finer["settings"]["samples"].as_u64().unwrap() > samples);
    assert!(folder.run("plan SCENE --size 8x6 --error 0.001 --depth 1 --no-trial", 7).contains("expected"));
    folder.run("render SCENE --as p.json --samples 3 -o a.exr", 2);
    folder.run("render SCENE --as m.json -o a.exr", 0);
}

#[test]
fn progress_for_programs() {
    let folder = Folder::new();
    let render = "render SCENE -o a.png --size 24x20 --samples 2 --progress";
    let said = folder.run(&format!("{render} json"), 0);
    let last = said.lines().rfind(|line| line.starts_with('{')).unwrap();
    let last: Value = serde_json::from_str(last).unwrap();
    assert_eq!(last["progress"], 1.0);
    let output = Command::new(env!("CARGO_BIN_EXE_whitted"))
        .current_dir(folder.0.path())
        .args(format!("{render} openjd").replace("SCENE", SCENE).split_whitespace())
        .env("WHITTED_DEVICE", "cpu")
        .output()
        .unwrap();
    assert!(String::from_utf8(output.stdout).unwrap().ends_with("openjd_progress: 100.0\n"));
    folder.run("render SCENE -o - --progress openjd", 2);
    folder.run(&format!("{render} loud"), 2);
}

//! An image rendered in shares and merged is the one that a single run renders: the bytes of its file, and the counts
//! of its report.

// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

use assert_cmd::Command;
use serde_json::Value;
use std::fs;
use std::path::Path;
use tempfile::TempDir;
use whitted::render::{Merge, MergeError, Rendered, Renderer};
use whitted::scene::Scene;
use whitted::settings::{DeviceChoice, Schedule, Settings, Share};

const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell_glass.toml");

fn whitted(folder: &TempDir, words: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_whitted"));
    command.current_dir(folder.path()).args(words.split_whitespace()).env("WHITTED_DEVICE", "cpu");
    command
}

fn render(folder: &TempDir, words: &str) {
    let samples = if words.contains("--samples") { "" } else { "--samples 5" };
    whitted(folder, "render")
        .arg(SCENE)
        .args(["--size", "60x50"])
        .args(samples.split_whitespace())
        .args(words.split_whitespace())
        .assert()
        .success();
}

fn refused(folder: &TempDir, words: &str) -> String {
    let output = whitted(folder, words).assert().code(1).get_output().clone();
    String::from_utf8(output.stderr).unwrap()
}

/// What a report counts: all but times, and how the work was cut.
fn counts(folder: &TempDir, name: &str) -> Value {
    let bytes = fs::read(folder.path().join(name)).unwrap();
    let mut report: Value = serde_json::from_slice(&bytes).unwrap();
    let whole = report.as_object_mut().unwrap();
    for key in ["time", "plan", "passes"] {
        whole.remove(key).unwrap();
    }
    whole["image"]["file"] = Value::Null;
    report
}

fn bytes(folder: &TempDir, name: &str) -> Vec<u8> {
    fs::read(folder.path().join(name)).unwrap()
}

#[test]
fn merged_shares_are_the_single_run() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["whole.exr", "whole.png", "whole.hdr"] {
        render(&folder, &format!("-o {name} --report whole.json"));
    }
    for count in [2u32, 3, 7] {
        let mut names = Vec::new();
        // Out of order, in tiles and batches of other sizes.
        for index in (1..=count).rev() {
            let name = format!("{index}of{count}.share");
            let tile = 30 + 200 * index;
            render(&folder, &format!("-o {name} --share {index}/{count} --tile-pixels {tile}"));
            names.push(name);
        }
        let names = names.join(" ");
        whitted(&folder, &format!("merge {names} -o m.exr --report m.json")).assert().success();
        assert!(
            bytes(&folder, "m.exr") == bytes(&folder, "whole.exr"),
            "{count} shares: not one byte differs"
        );
        assert_eq!(counts(&folder, "m.json"), counts(&folder, "whole.json"), "{count} shares");
        for file in ["png", "hdr"] {
            whitted(&folder, &format!("merge {names} -o m.{file}")).assert().success();
            assert!(
                bytes(&folder, &format!("m.{file}")) == bytes(&folder, &format!("whole.{file}")),
                "{file}"
            );
        }
    }
    assert!(!Path::new(&folder.path().join("1of2.share.partial")).exists());
}

#[test]
fn what_does_not_belong_together_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for index in 1..=3 {
        render(&folder, &format!("-o {index}.share --share {index}/3"));
    }
    render(&folder, "-o seed.share --share 2/3 --seed 1");
    render(&folder, "-o half.share --share 2/2");
    render(&folder, "-o again.share --share 3/3");
    let why = refused(&folder, "merge 1.share 3.share -o m.exr");
    assert!(why.contains("1 of 3 share is missing: 2/3") && why.contains("--share"), "{why}");
    let why = refused(&folder, "merge 2.share -o m.exr");
    assert!(why.contains("2 of 3 shares are missing: 1/3, 3/3"), "{why}");
    let why = refused(&folder, "merge 1.share seed.share 3.share -o m.exr");
    assert!(why.contains("seed.share") && why.contains("--seed 0") && why.contains("--seed 1"), "{why}");
    let why = refused(&folder, "merge 1.share half.share -o m.exr");
    assert!(why.contains("half.share") && why.contains("2 shares"), "{why}");
    let why = refused(&folder, "merge 1.share 3.share again.share 2.share -o m.exr");
    assert!(why.contains("again.share and 3.share are both share 3/3"), "{why}");
    let why = refused(&folder, "merge 1.share 2.share none.share -o m.exr");
    assert!(why.contains("none.share"), "{why}");
    // A damaged share, anywhere.
    let good = bytes(&folder, "2.share");
    for at in (0..good.len()).step_by(good.len() / 9) {
        let mut bad = good.clone();
        bad[at] ^= 4;
        fs::write(folder.path().join("bad.share"), bad).unwrap();
        let why = refused(&folder, "merge 1.share bad.share 3.share -o m.exr");
        assert!(why.contains("cannot read bad.share"), "byte {at}: {why}");
    }
    assert!(!folder.path().join("m.exr").exists());
    // Made anew by itself, it fits.
    fs::remove_file(folder.path().join("2.share")).unwrap();
    render(&folder, "-o 2.share --share 2/3");
    whitted(&folder, "merge 1.share 2.share 3.share -o m.exr").assert().success();
}

#[test]
fn shares_and_images_have_names_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    for words in ["-o a.share", "-o a.png --share 1/2", "-o - --share 1/2", "-o a.share --share 3/2"] {
        whitted(&folder, "render").arg(SCENE).args(words.split_whitespace()).assert().code(2);
    }
}

#[test]
fn samples_are_added_to_a_finished_picture_and_to_a_share() {
    let folder = tempfile::tempdir().unwrap();
    render(&folder, "-o a.exr --keep-state");
    render(&folder, "-o a.exr --samples 11 --continue --report a.json");
    render(&folder, "-o whole.exr --samples 11 --report whole.json");
    assert!(bytes(&folder, "a.exr") == bytes(&folder, "whole.exr"), "not one byte differs");
    assert_eq!(counts(&folder, "a.json"), counts(&folder, "whole.json"));
    for index in [1, 2] {
        render(&folder, &format!("-o {index}.share --share {index}/2"));
    }
    whitted(&folder, "merge 1.share 2.share -o m.exr --keep-state").assert().success();
    render(&folder, "-o m.exr --samples 11 --continue");
    assert!(bytes(&folder, "m.exr") == bytes(&folder, "whole.exr"), "merged, then more samples");
    for index in [1, 2] {
        render(&folder, &format!("-o {index}.share --share {index}/2 --samples 11 --continue"));
    }
    whitted(&folder, "merge 1.share 2.share -o m.exr").assert().success();
    assert!(bytes(&folder, "m.exr") == bytes(&folder, "whole.exr"), "more samples, then merged");
    let none = whitted(&folder, "render")
        .arg(SCENE)
        .args(["-o", "b.exr", "--continue"])
        .assert()
        .code(1)
        .get_output()
        .clone();
    assert!(String::from_utf8_lossy(&none.stderr).contains("--keep-state"));
}

fn share(renderer: &mut Renderer, scene: &Scene, index: u32, count: u32) -> Rendered {
    let schedule = Schedule { share: Share { index, count }, ..Schedule::default() };
    let settings = Settings { width: 60, height: 50, samples: 2, schedule, ..Settings::of(scene) };
    renderer.render(scene, &settings).unwrap()
}

#[test]
fn shares_of_several_devices_are_joined_on_request_only() {
    let scene = Scene::load(SCENE).unwrap();
    let mut renderer = Renderer::new(&DeviceChoice::Cpu).unwrap();
    let first = share(&mut renderer, &scene, 1, 2);
    assert!(first.linear.iter().filter(|p| **p == [0.0; 3]).count() >= 1000, "the other share is black");
    // The same bits, as another driver's.
    let state = share(&mut renderer, &scene, 2, 2).state.unwrap();
    let mut file = Vec::new();
    whitted::render::State::write(&state, &mut file).unwrap();
    let text = String::from_utf8_lossy(&file[..4000]).into_owned();
    let driver = text.split("\"driver\":\"").nth(1).unwrap().split('"').next().unwrap().to_owned();
    let other = format!("{}X", &driver[..driver.len() - 1]);
    let place = file.windows(driver.len()).position(|w| w == driver.as_bytes()).unwrap();
    file[place..place + driver.len()].copy_from_slice(other.as_bytes());
    let content = file.len() - 32;
    let sum = <sha2::Sha256 as sha2::Digest>::digest(&file[..content]);
    file[content..].copy_from_slice(&sum);
    let other_state = whitted::render::ResumeState::read(&mut &file[..]).unwrap();

    let mut strict = Merge::new(false);
    strict.add("1", first.state.clone().unwrap()).unwrap();
    let why = strict.add("2", other_state.clone()).unwrap_err();
    assert!(matches!(&why, MergeError::Different { .. }) && why.to_string().contains(&other), "{why}");

    let mut mixed = Merge::new(true);
    mixed.add("1", first.state.unwrap()).unwrap();
    mixed.add("2", other_state).unwrap();
    let merged = mixed.finish().unwrap();
    let device = &merged.report.device;
    assert!(device.driver.starts_with("mixed: ") && device.driver.contains(&other), "{device:?}");
    assert!(merged.report.warnings.iter().any(|w| w.contains("different devices")));
    let whole = share(&mut renderer, &scene, 1, 1);
    assert_eq!(merged.linear, whole.linear);
}

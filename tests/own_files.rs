//! What a user's own files become without an edit: models drawn by themselves, imported and told about; scenes with
//! variables, in frames, from standard input; pictures as PPM and PFM. Renders run on the software device.

// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

use assert_cmd::Command;
use serde_json::Value;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// Glass, a mirror, a cone and a floor, without a camera or lights.
const MODEL: &str = "f 1 0 0 0.5 0.5 0 0 0\ns 0 0 0 1\nf 1 1 1 0 0.1 0 0.9 1.5\ns 2 -1 0 0.7\nf 0 1 0 1 0 0 0 0\n\
                     c\n-2 0 -1 0.6\n-2 0 1 0.1\np 4\n-3 -3 -1\n3 -3 -1\n3 3 -1\n-3 3 -1\n";

const MOVING: &str = "\
[camera]
look_from = [0, 2, 6]
look_at = [0, 1, 0]
width = 24
height = 20

[[light]]
position = [2, 5, 3]
intensity = 20

[material.a]
diffuse = [0.8, ${green}, 0.2]

[[sphere]]
center = [${frame}, 1, 0]
radius = 1
material = \"a\"
";

fn whitted(folder: &Path, words: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_whitted"));
    command.args(words.split_whitespace()).env("WHITTED_DEVICE", "cpu").current_dir(folder);
    command
}

/// Standard error of a run that ends with `code`.
fn ends(folder: &Path, words: &str, code: i32) -> String {
    let output = whitted(folder, words).assert().code(code).get_output().clone();
    String::from_utf8(output.stderr).unwrap()
}

fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("model.nff"), MODEL).unwrap();
    fs::write(folder.path().join("moving.toml"), MOVING).unwrap();
    folder
}

fn hash(report: &Path) -> String {
    let report: Value = serde_json::from_slice(&fs::read(report).unwrap()).unwrap();
    report["image"]["linear_sha256"].as_str().unwrap().to_owned()
}

#[test]
fn a_model_and_its_import_are_the_same_picture() {
    let folder = folder();
    let at = folder.path();
    fs::create_dir(at.join("scenes")).unwrap();
    for size in ["40x30", "20x50"] {
        let said = ends(at, &format!("render model.nff -o a.png --size {size} --report a.json"), 0);
        for part in ["assumed: model.nff: no camera", "72 sides", "file = \"model.nff\"", "whitted import"] {
            assert!(said.contains(part), "{part}: {said}");
        }
        ends(at, &format!("import model.nff -o scenes/b.toml --size {size} -q"), 0);
        assert!(ends(at, "render scenes/b.toml -o b.png --report b.json", 0).contains(size));
        assert_eq!(hash(&at.join("a.json")), hash(&at.join("b.json")));
    }
    let report: Value = serde_json::from_slice(&fs::read(at.join("a.json")).unwrap()).unwrap();
    assert!(report["scene"]["notes"].as_array().unwrap().len() >= 2, "{}", report["scene"]);
    // The picture has all of the model's colours, and the border none.
    ends(at, "render model.nff -o c.pfm -q --size 40x40 --samples 1", 0);
    assert_eq!(ends(at, "render model.nff -o a.png --size 9x9 -q", 0), "");
    // An import never takes the model's place.
    ends(at, "import model.nff -o model.nff", 2);
    ends(at, "import moving.toml -o a.toml", 2);
    ends(at, "import none.obj -o a.toml", 3);
}

#[test]
fn every_command_that_takes_a_scene_takes_a_model() {
    let folder = folder();
    let at = folder.path();
    ends(at, "plan model.nff --size 24x20 --no-trial", 0);
    ends(at, "profile model.nff --size 24x20 --repeats 1 --samples 1", 0);
    ends(at, "render model.nff -o e.png --size 24x20 --budget --samples 2", 0);
    ends(at, "sweep model.nff --size 8x8 --over samples=1 --repeats 1 --truth-samples 4 -o sweep", 0);
}

#[test]
fn names_stand_for_values() {
    let folder = folder();
    let at = folder.path();
    ends(at, "render moving.toml -o a.png -D green=0.25 --frame 2 --report a.json", 0);
    let plain = MOVING.replace("${green}", "0.25").replace("${frame}", "2");
    fs::write(at.join("plain.toml"), plain).unwrap();
    ends(at, "render plain.toml -o b.png --report b.json", 0);
    assert_eq!(hash(&at.join("a.json")), hash(&at.join("b.json")));
    assert!(
        ends(at, "render moving.toml -o a.png -D green=0.25", 3)
            .contains("moving.toml:15:11: scene: `${frame}`")
    );
    assert!(ends(at, "render plain.toml -o a.png -D green=1", 3).contains("does not occur"));
    assert!(ends(at, "render model.nff -o a.png -D green=1", 3).contains("does not occur"));
    assert!(
        ends(at, "render moving.toml -o a.png -D green=-1 --frame 1", 3)
            .contains("moving.toml:12:17: material")
    );
    ends(at, "render moving.toml -o a.png -D green", 2);
}

#[test]
fn a_scene_comes_from_standard_input() {
    let folder = folder();
    let at = folder.path();
    // Files that it names are looked for from the current folder.
    let text = MOVING.to_owned() + "\n[[mesh]]\nfile = \"model.nff\"\n";
    fs::write(at.join("file.toml"), &text).unwrap();
    ends(at, "render file.toml -o a.png -D green=1 --frame 1 --report a.json", 0);
    whitted(at, "render - -o b_##.png -D green=1 --frames 1..2 --report b_##.json")
        .write_stdin(text)
        .assert()
        .success();
    assert_eq!(hash(&at.join("a.json")), hash(&at.join("b_01.json")));
    assert_ne!(hash(&at.join("a.json")), hash(&at.join("b_02.json")));
    let wrong = whitted(at, "plan - --no-trial")
        .write_stdin("[camera]\nx = 1\n")
        .assert()
        .code(3)
        .get_output()
        .clone();
    assert!(String::from_utf8(wrong.stderr).unwrap().contains("-:2:1: camera: unknown key `x`"));
    whitted(at, "plan - --no-trial").write_stdin(&b"\xff"[..]).assert().code(3);
}

#[test]
fn frames_are_numbered_skipped_and_judged() {
    let folder = folder();
    let at = folder.path();
    let render = "render moving.toml -o f_###.png --report f_###.json -D green=0.5";
    ends(at, &format!("{render} --frames 1..5x2"), 0);
    let there = |n: u32| at.join(format!("f_{n:03}.png")).exists();
    assert_eq!([1, 2, 3, 4, 5].map(there), [true, false, true, false, true]);
    // Each frame is what it is alone.
    ends(at, "render moving.toml -o alone.png --report alone.json -D green=0.5 --frame 3", 0);
    assert_eq!(hash(&at.join("alone.json")), hash(&at.join("f_003.json")));
    assert_ne!(hash(&at.join("alone.json")), hash(&at.join("f_005.json")));
    // What is there stays; what was interrupted does not count as there.
    let before = fs::metadata(at.join("f_001.png")).unwrap().modified().unwrap();
    let said = ends(at, &format!("{render} --frames 1..3 --skip-existing"), 0);
    assert!(said.contains("frame 1: there") && said.contains("frame 3: there") && there(2), "{said}");
    assert_eq!(fs::metadata(at.join("f_001.png")).unwrap().modified().unwrap(), before);
    fs::write(at.join("f_001.png.partial"), "no state").unwrap();
    ends(at, &format!("{render} --frames 1..1 --skip-existing --resume"), 1);

    // Frame 10 divides by nothing that it could: its colour is out of range. The others are rendered, and the code is its own.
    let bad = MOVING.replace("radius = 1", "radius = ${frame}").replace("${green}", "0.5");
    fs::write(at.join("bad.toml"), bad).unwrap();
    let said = ends(at, "render bad.toml -o g_#.png --frames 0..2", 3);
    assert!(said.contains("error: frame 0: bad.toml:16:10: sphere 1: `radius` is 0"), "{said}");
    assert!(said.contains("1 of 3 frames failed, frame 0 first"), "{said}");
    assert!(at.join("g_1.png").exists() && at.join("g_2.png").exists());

    for wrong in [
        "-o a.png --frames 1..2",
        "-o - --frames 1..2",
        "-o a_#.png --report r.json --frames 1..2",
        "-o a.png --skip-existing",
    ] {
        ends(at, &format!("render moving.toml -D green=1 {wrong}"), 2);
    }
}

#[test]
fn ppm_and_pfm_are_written_and_compared() {
    let folder = folder();
    let at = folder.path();
    let render = "render moving.toml -D green=0.5 --frame 0 --samples 4 -q -o";
    for name in ["a.png", "a.ppm", "a.exr", "a.pfm"] {
        ends(at, &format!("{render} {name}"), 0);
    }
    ends(at, &format!("{render} deep.ppm --bits 16"), 0);
    ends(at, &format!("{render} deep.png --bits 16"), 0);
    ends(at, &format!("{render} b.pfm --bits 16"), 2);
    for pair in ["a.png a.ppm", "a.exr a.pfm", "deep.png deep.ppm"] {
        ends(at, &format!("compare {pair} --metric max --threshold 0 -q"), 0);
    }
    ends(at, "compare a.ppm a.pfm --metric max --threshold 0 -q", 6);
    ends(at, "render moving.toml -D green=0.5 --frame 0 --samples 4 -o c.png --reference a.pfm", 0);
}

#[test]
fn info_gives_the_command_that_makes_a_picture_again() {
    let folder = folder();
    let at = folder.path();
    let options = "--size 30x20 --samples 3 --depth 2 --sampler random --seed 5 --crop 2,3,20,17 -D green=0.5 --frame 1";
    for name in ["a.png", "a.exr", "a.ppm", "a.hdr"] {
        ends(at, &format!("render moving.toml -o {name} {options} --report first.json"), 0);
        let about =
            whitted(at, &format!("info {name} --json - -q")).assert().success().get_output().stdout.clone();
        let about: Value = serde_json::from_slice(&about).unwrap();
        assert_eq!((about["kind"].as_str(), about["width"].as_u64()), (Some("picture"), Some(18)));
        let command = about["command"].as_str().unwrap().strip_prefix("whitted ").unwrap().to_owned();
        fs::remove_file(at.join(name)).unwrap();
        ends(at, &format!("{command} --report again.json"), 0);
        assert!(at.join(name).exists());
        assert_eq!(hash(&at.join("first.json")), hash(&at.join("again.json")));
    }
    let about = whitted(at, "info model.nff").assert().success().get_output().stdout.clone();
    let about = String::from_utf8(about).unwrap();
    for part in ["model.nff: model", "2 spheres", "bounds", "`fill 2`", "mirror and glass 1", "no camera"] {
        assert!(about.contains(part), "{part}: {about}");
    }
    assert!(ends(at, "info none.png", 3).contains("none.png"));
}

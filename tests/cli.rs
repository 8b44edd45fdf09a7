//! The program as its users meet it: exit codes, streams, files. Renders run on the software device.

// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

use assert_cmd::Command;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell.toml");
const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";

fn whitted(words: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_whitted"));
    command.args(words).env_remove("WHITTED_DEVICE");
    command
}

/// A small render of the example scene on the software device.
fn small(output: &str) -> Command {
    whitted(&[
        "render",
        SCENE,
        "-o",
        output,
        "--size",
        "24x20",
        "--samples",
        "2",
        "--depth",
        "3",
        "--device",
        "cpu",
    ])
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

fn folder() -> (TempDir, impl Fn(&str) -> String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().to_owned();
    (folder, move |name: &str| path.join(name).display().to_string())
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

// Without a device.

#[test]
fn help_and_version_are_on_standard_output() {
    for words in [&["--help"][..], &["render", "--help"], &["devices", "--help"], &["gallery", "--help"]] {
        let output = whitted(words).assert().success().get_output().clone();
        assert!(text(&output.stdout).contains("Usage: whitted"), "{words:?}");
        assert!(output.stderr.is_empty());
    }
    let version = whitted(&["--version"]).assert().success().get_output().clone();
    assert!(text(&version.stdout).contains(env!("CARGO_PKG_VERSION")));
}

#[test]
fn manual_pages_and_completions_are_written() {
    let (folder, at) = folder();
    whitted(&["man", "-o", &at("man")]).assert().success();
    let pages = names(&folder.path().join("man"));
    assert!(
        pages.contains(&"whitted.1".into()) && pages.contains(&"whitted-generate-sphereflake.1".into()),
        "{pages:?}"
    );
    let page = text(&whitted(&["man"]).assert().success().get_output().stdout);
    assert_eq!(page, fs::read_to_string(at("man/whitted.1")).unwrap());
    let shells = ["bash", "zsh", "fish", "elvish", "powershell"];
    for shell in shells {
        let script = text(&whitted(&["completions", shell]).assert().success().get_output().stdout);
        assert!(script.contains("batch-samples"), "{shell}");
    }
    assert_eq!(whitted(&["completions", "tcsh"]).assert().failure().get_output().status.code(), Some(2));
}

#[test]
fn bad_values_are_usage_errors() {
    let (folder, at) = folder();
    let png = at("a.png");
    let cases: &[&[&str]] = &[
        &["-o", &png, "--size", "0x5"],
        &["-o", &png, "--size", "600"],
        &["-o", &png, "--samples", "0"],
        &["-o", &png, "--depth", "0"],
        &["-o", &png, "--depth", "-1"],
        &["-o", &png, "--seed", "x"],
        &["-o", &png, "--crop", "5,5,5,9"],
        &["-o", &png, "--size", "20x10", "--crop", "0,0,21,10"],
        &["-o", &png, "--crop", "1,2,3"],
        &["-o", &png, "--bits", "12"],
        &["-o", &png, "--workgroup", "48"],
        &["-o", &png, "--tile-pixels", "0"],
        &["-o", &png, "--batch-samples", "0"],
        &["-o", &png, "-q", "-v"],
        &["-o", &png, "--no-such-option"],
        &["-o", &at("a.jpg")],
        &["-o", &at("a")],
        &["-o", &at("a.exr"), "--bits", "16"],
        &[],
    ];
    for case in cases {
        let output = whitted(&["render", SCENE]).args(*case).assert().code(2).get_output().clone();
        assert!(output.stdout.is_empty(), "{case:?}");
        assert!(text(&output.stderr).starts_with("error: "), "{case:?}: {}", text(&output.stderr));
    }
    whitted(&["gallery", SCENE, "-o", &at("g"), "--scale", "0"]).assert().code(2);
    whitted(&["no-such-command"]).assert().code(2);
    assert!(names(folder.path()).is_empty());
}

#[test]
fn a_bad_scene_is_told_with_its_place_and_leaves_nothing() {
    let (folder, at) = folder();
    fs::write(at("bad.toml"), "[camera]\nlook_from = \"here\"\n").unwrap();
    for (scene, part) in [("bad.toml", "bad.toml:2:"), ("missing.toml", "missing.toml")] {
        for words in [["render", "-o", &at("a.png")], ["gallery", "-o", &at("g")]] {
            let output = whitted(&words).arg(at(scene)).assert().code(3).get_output().clone();
            assert!(text(&output.stderr).contains(part), "{}", text(&output.stderr));
            assert!(output.stdout.is_empty());
        }
    }
    assert_eq!(names(folder.path()), ["bad.toml"]);
}

#[test]
fn an_output_that_cannot_be_written_is_found_before_the_scene_is_read() {
    let (folder, at) = folder();
    fs::create_dir(at("d.png")).unwrap();
    for (output, part) in [("none/a.png", "there is no directory"), ("d.png", "it is a directory")] {
        let words = ["render", &at("missing.toml"), "-o", &at(output)];
        let output = whitted(&words).assert().code(1).get_output().clone();
        assert!(text(&output.stderr).contains(part), "{}", text(&output.stderr));
    }
    assert_eq!(names(folder.path()), ["d.png"]);
}

#[test]
fn no_driver_says_what_to_install() {
    let (folder, at) = folder();
    let output = small(&at("a.png"))
        .env("VK_ICD_FILENAMES", "/nonexistent.json")
        .env("VK_DRIVER_FILES", "/nonexistent.json")
        .assert()
        .code(4)
        .get_output()
        .clone();
    for package in ["mesa-vulkan-drivers", "libvulkan1"] {
        assert!(text(&output.stderr).contains(package), "{}", text(&output.stderr));
    }
    assert!(names(folder.path()).is_empty());
}

#[cfg(unix)]
#[test]
fn closed_pipes_do_not_panic() {
    use std::process::{Command, Stdio};
    for words in [&["devices"][..], &["render", "/nonexistent.toml", "-o", "a.png"], &["--help"]] {
        let shell = format!("exec {} {} | true", env!("CARGO_BIN_EXE_whitted"), words.join(" "));
        for redirect in ["", " 2>&1"] {
            let shell = shell.replace(" | true", &format!("{redirect} | true"));
            let output = Command::new("sh").args(["-c", &shell]).stdin(Stdio::null()).output().unwrap();
            assert!(!text(&output.stderr).contains("panicked"), "{}", text(&output.stderr));
        }
    }
}

// With the software device.

#[test]
fn devices_lists_the_software_device() {
    let json = whitted(&["devices", "--json"]).assert().success().get_output().stdout.clone();
    let rows: Vec<serde_json::Value> = serde_json::from_slice(&json).unwrap();
    let cpu = rows.iter().find(|row| row["type"] == "cpu").expect("a software device");
    let listing = text(&whitted(&["devices"]).assert().success().get_output().stdout);
    assert!(listing.contains(cpu["name"].as_str().unwrap()), "{listing}");
    assert!(listing.contains(cpu["uuid"].as_str().unwrap()), "{listing}");
}

#[test]
fn an_unknown_device_has_its_own_exit_code() {
    let (folder, at) = folder();
    for device in ["no such device", "99"] {
        whitted(&["render", SCENE, "-o", &at("a.png"), "--device", device]).assert().code(4);
    }
    assert!(names(folder.path()).is_empty());
}

#[test]
fn only_the_image_goes_to_standard_output() {
    let (folder, at) = folder();
    let file = small(&at("a.png")).assert().success().get_output().clone();
    assert!(file.stdout.is_empty());
    assert_eq!(text(&file.stderr).lines().count(), 1, "{}", text(&file.stderr));
    for flag in ["-q", "-v"] {
        let piped = small("-").arg(flag).assert().success().get_output().clone();
        assert!(piped.stdout.starts_with(PNG));
        assert_eq!(piped.stdout, fs::read(at("a.png")).unwrap(), "a file and a pipe get the same bytes");
        assert_eq!(piped.stderr.is_empty(), flag == "-q", "{}", text(&piped.stderr));
    }
    assert_eq!(names(folder.path()), ["a.png"], "no partial file is left");
}

#[test]
fn each_format_holds_the_image() {
    let (_folder, at) = folder();
    for name in ["a.png", "a.exr", "a.hdr"] {
        small(&at(name)).assert().success();
        let image = image::open(at(name)).unwrap();
        assert_eq!((image.width(), image.height()), (24, 20), "{name}");
    }
    small(&at("deep.png")).args(["--bits", "16"]).assert().success();
    assert!(image::open(at("deep.png")).unwrap().as_rgb16().is_some());
}

#[test]
fn metadata_holds_rays_and_on_request_times() {
    let (_folder, at) = folder();
    let holds = |name: &str, text: &str| {
        let bytes = fs::read(at(name)).unwrap();
        bytes.windows(text.len()).any(|w| w == text.as_bytes())
    };
    let rays = format!("primary {}, reflection", 24 * 20 * 2);
    for name in ["a.png", "a.exr", "a.hdr"] {
        small(&at(name)).assert().success();
        assert!(holds(name, &rays) && !holds(name, " s, wall "), "{name}");
        let first = fs::read(at(name)).unwrap();
        small(&at(name)).assert().success();
        assert_eq!(fs::read(at(name)).unwrap(), first, "{name}: equal renders, equal files");
        small(&at(name)).arg("--record-time").assert().success();
        assert!(holds(name, &rays) && holds(name, " s, wall "), "{name}");
    }
    small(&at("b.exr")).args(["--budget"]).assert().success();
    assert!(holds("b.exr", "Error: rmse at most ") && holds("b.exr", "% confidence: sampling "));
}

#[test]
fn the_report_tells_of_the_render() {
    let (_folder, at) = folder();
    small(&at("a.png")).args(["--report", &at("a.json"), "--seed", "3"]).assert().success();
    let report: serde_json::Value = serde_json::from_slice(&fs::read(at("a.json")).unwrap()).unwrap();
    assert_eq!(report["settings"]["width"], 24);
    assert_eq!(report["settings"]["seed"], 3);
    assert_eq!(report["scene"]["file"], SCENE);
    assert_eq!(report["image"]["file"].as_str().unwrap(), at("a.png"));
    assert_eq!(report["image"]["linear_sha256"].as_str().unwrap().len(), 64);
    assert_eq!(report["rays"]["primary"], 24 * 20 * 2);
    assert!(report["time"]["wall"].as_f64().unwrap() >= report["time"]["render"].as_f64().unwrap());
}

#[test]
fn a_crop_is_cut_from_the_same_image() {
    let (_folder, at) = folder();
    small(&at("whole.exr")).assert().success();
    small(&at("part.exr")).args(["--crop", "5,4,19,13"]).assert().success();
    let whole = image::open(at("whole.exr")).unwrap().crop_imm(5, 4, 14, 9);
    // An EXR keeps its place: other readers see it in the whole image, black around.
    let part = image::open(at("part.exr")).unwrap();
    assert_eq!((part.width(), part.height()), (24, 20));
    assert_eq!(part.to_rgb32f().get_pixel(4, 4).0, [0.0; 3]);
    assert_eq!(whole.to_rgb32f(), part.crop_imm(5, 4, 14, 9).into_rgb32f());
    small(&at("part.png")).args(["--crop", "5,4,19,13"]).assert().success();
    assert_eq!(image::open(at("part.png")).unwrap().width(), 14);
    // `compare` looks at the pixels that are there, and at no others.
    let same = |a: &str, b: &str| {
        whitted(&["compare", &at(a), &at(b), "--metric", "rmse", "--threshold", "0"]).assert()
    };
    same("part.exr", "part.exr").success();
    same("part.exr", "whole.exr").success();
    same("whole.exr", "part.exr").success();
    small(&at("other.exr")).args(["--crop", "5,4,19,13", "--seed", "1"]).assert().success();
    same("other.exr", "whole.exr").code(6);
}

#[test]
fn the_device_may_come_from_the_environment() {
    let (_folder, at) = folder();
    let words = ["render", SCENE, "-o", &at("a.png"), "--size", "8x6", "--samples", "1"];
    whitted(&words).env("WHITTED_DEVICE", "cpu").assert().success();
    whitted(&words).env("WHITTED_DEVICE", "no such device").assert().code(4);
}

#[test]
fn verbose_names_every_pass_and_the_device() {
    let (_folder, at) = folder();
    let words = ["-v", "--report", &at("a.json")];
    let output = small(&at("a.png")).args(words).assert().success().get_output().clone();
    let told = text(&output.stderr);
    let report: serde_json::Value = serde_json::from_slice(&fs::read(at("a.json")).unwrap()).unwrap();
    let passes = report["passes"].as_array().unwrap().iter().map(|pass| &pass["name"]);
    for part in passes.chain([&report["device"]["name"]]) {
        assert!(told.contains(part.as_str().unwrap()), "{part} is not in\n{told}");
    }
}

#[test]
fn the_gallery_is_whole() {
    let (_folder, at) = folder();
    whitted(&["gallery", SCENE, "-o", &at("g"), "--scale", "0.03", "--device", "cpu"]).assert().success();
    let names = names(Path::new(&at("g")));
    for name in ["contact_sheet.png", "gallery.json", "samples_10.png", "depth_4.png", "final_cornell.png"] {
        assert!(names.iter().any(|n| n == name), "{name} is not in {names:?}");
    }
}

/// Ends its process even where the test fails before that.
#[cfg(unix)]
struct Stopped(std::process::Child);

#[cfg(unix)]
impl Drop for Stopped {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Starts a render, waits until it is under way, stops it; the last line and the exit code.
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
    // The first line of progress says that the render is under way.
    let mut lines = BufReader::new(child.0.stderr.take().unwrap()).lines().map(Result::unwrap);
    assert!(lines.any(|line| line.starts_with("rendering: ")), "it ended before it was stopped");
    // The shell's own `kill`: the program of that name is not on every machine.
    let interrupt = format!("kill -INT {}", child.0.id());
    assert!(Command::new("sh").args(["-c", &interrupt]).status().unwrap().success());
    (lines.last().unwrap(), child.0.wait().unwrap().code())
}

#[cfg(unix)]
#[test]
fn an_interrupt_ends_with_130_and_a_partial_image() {
    let (folder, at) = folder();
    let words = ["--size", "120x100", "--samples", "1000000", "--batch-samples", "4"];
    let (last, code) = interrupted(&at("a.png"), &words);
    assert!(last.starts_with("interrupted: "), "{last}");
    assert!(last.contains("a.incomplete.png; continue with --resume"), "{last}");
    assert_eq!(code, Some(130));
    assert_eq!(names(folder.path()), ["a.incomplete.png", "a.png.partial"]);
    assert!(fs::read(at("a.incomplete.png")).unwrap().starts_with(PNG));
}

#[cfg(unix)]
#[test]
fn an_interrupted_render_resumes_to_the_same_file() {
    let (folder, at) = folder();
    let output = at("a.exr");
    let words = ["--size", "96x80", "--samples", "3000", "--tile-pixels", "64"];
    let (last, code) = interrupted(&output, &words);
    assert!(
        last.ends_with("continue with --resume (state in {}.partial)".replace("{}", &output).as_str()),
        "{last}"
    );
    assert_eq!(code, Some(130));
    assert_eq!(names(folder.path()), ["a.exr.partial", "a.incomplete.exr"]);

    // Another render does not go on from it, and says why.
    let other = whitted(&["render", SCENE, "-o", &output, "--device", "cpu", "--resume", "--samples", "2"])
        .assert()
        .code(1)
        .get_output()
        .clone();
    for part in ["a.exr.partial", "--samples 3000", "--samples 2", "leave out --resume"] {
        assert!(text(&other.stderr).contains(part), "{part}: {}", text(&other.stderr));
    }
    assert_eq!(names(folder.path()), ["a.exr.partial", "a.incomplete.exr"]);

    let report = at("a.json");
    let resume = ["render", SCENE, "-o", &output, "--device", "cpu", "--resume", "--report", &report];
    whitted(&resume).args(words).assert().success();
    assert_eq!(names(folder.path()), ["a.exr", "a.json"], "the state is gone");
    let report: serde_json::Value = serde_json::from_slice(&fs::read(report).unwrap()).unwrap();
    assert_eq!(report["rays"]["primary"], 96 * 80 * 3000);

    whitted(&["render", SCENE, "-o", &at("b.exr"), "--device", "cpu"]).args(words).assert().success();
    assert!(fs::read(&output).unwrap() == fs::read(at("b.exr")).unwrap(), "not one bit differs");
}

#[test]
fn a_state_file_is_used_only_when_asked_for() {
    let (folder, at) = folder();
    let output = small(&at("a.png")).arg("--resume").assert().success().get_output().clone();
    assert!(text(&output.stderr).starts_with("there is no "), "{}", text(&output.stderr));

    fs::write(at("a.png.partial"), "no state").unwrap();
    let output = small(&at("a.png")).assert().success().get_output().clone();
    assert!(text(&output.stderr).starts_with("warning: "), "{}", text(&output.stderr));
    let output = small(&at("a.png")).arg("--resume").assert().code(1).get_output().clone();
    assert!(text(&output.stderr).contains("cannot continue "), "{}", text(&output.stderr));
    small("-").arg("--resume").assert().code(2);
    assert_eq!(names(folder.path()), ["a.png", "a.png.partial"]);
}

//! `compare` and `profile` as their users meet them: exit codes, streams, and figures that agree with
//! what `render` says. Renders run on the software device.

// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

use assert_cmd::Command;
use serde_json::Value;
use std::fs;
use tempfile::TempDir;
use whitted::plan::passes;

const GLASS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell_glass.toml");
const SMALL: &[&str] =
    &["--size", "24x20", "--samples", "3", "--depth", "3", "--seed", "5", "--device", "cpu"];

fn whitted(words: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_whitted"));
    command.args(words).env_remove("WHITTED_DEVICE");
    command
}

fn folder() -> (TempDir, impl Fn(&str) -> String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().to_owned();
    (folder, move |name: &str| path.join(name).display().to_string())
}

fn json(bytes: &[u8]) -> Value {
    serde_json::from_slice(bytes).unwrap_or_else(|e| panic!("{e}: {}", String::from_utf8_lossy(bytes)))
}

fn file(path: &str) -> Value {
    json(&fs::read(path).unwrap())
}

#[test]
fn renders_are_compared() {
    let (_folder, at) = folder();
    let (exr, png) = (at("a.exr"), at("a.png"));
    for (output, seed) in [(&exr, "5"), (&png, "5"), (&at("b.png"), "6")] {
        let mut command = whitted(&["render", GLASS, "-o", output]);
        command.args(SMALL.iter().map(|w| if *w == "5" { seed } else { w })).assert().success();
    }
    // A PNG holds the codes of the same picture; half a code is the most it may be off.
    let same = whitted(&["compare", &png, &exr, "--metric", "codes", "--threshold", "0", "--json", "-"]);
    let output = { same }.assert().success().get_output().clone();
    let figures = json(&output.stdout);
    assert_eq!(figures["metrics"]["code_differing_pixels"], 0);
    assert!(figures["metrics"]["max_abs"].as_f64().unwrap() > 0.0);
    assert!(String::from_utf8_lossy(&output.stderr).contains("rmse"), "the table gives way to the JSON");

    // Other samples are another picture: each figure says so by exit code 6, and the files are written.
    for metric in ["rmse", "flip", "max", "pixels"] {
        let words = ["compare", &at("b.png"), &png, "--metric", metric, "--threshold", "1e-4"];
        let (diff, figures) = (at("diff.png"), at("figures.json"));
        let mut command = whitted(&words);
        let output =
            command.args(["--diff", &diff, "--json", &figures]).assert().code(6).get_output().clone();
        assert!(String::from_utf8_lossy(&output.stdout).contains("threshold 0.0001"));
        assert!(String::from_utf8_lossy(&output.stderr).starts_with(metric));
        assert_eq!(file(&figures)["judged"]["above"], true);
        assert!(image::open(&diff).unwrap().height() > 20, "picture and legend");
    }
    // Without a threshold nothing is judged.
    let quiet = whitted(&["compare", &at("b.png"), &png, "-q"]).assert().success().get_output().clone();
    assert!(quiet.stdout.is_empty() && quiet.stderr.is_empty());
}

#[test]
fn renders_that_differ_in_noise_only_agree() {
    let (_folder, at) = folder();
    for (name, depth, seed) in [("a.exr", "3", "5"), ("b.exr", "3", "6"), ("wrong.exr", "1", "7")] {
        let mut command = whitted(&["render", GLASS, "-o", &at(name), "--size", "96x64", "--samples", "4"]);
        command.args(["--depth", depth, "--seed", seed, "--device", "cpu", "-q"]).assert().success();
    }
    let compared = |b: &str, more: &[&str]| {
        let mut command = whitted(&["compare", &at("a.exr"), &at(b), "--statistical"]);
        command.args(more);
        command
    };
    // Two seeds differ in noise only, which any threshold near zero takes for a difference.
    let output = compared("b.exr", &[]).assert().success().get_output().clone();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(text.contains("no significant difference") && text.contains("significance of 0.01"), "{text}");
    // Without reflections the picture is biased.
    let output = compared("wrong.exr", &["--json", "-"]).assert().code(6).get_output().clone();
    let figures = json(&output.stdout);
    assert_eq!(figures["statistical"]["significant"], true, "{figures}");
    assert!(String::from_utf8_lossy(&output.stderr).contains("more than noise"));
    for wrong in [&["--significance", "1"][..], &["--threshold", "0.1"], &["--metric", "max"]] {
        compared("b.exr", wrong).assert().code(2);
    }
    whitted(&["compare", &at("a.exr"), &at("b.exr"), "--significance", "0.1"]).assert().code(2);
}

#[test]
fn what_cannot_be_compared_or_profiled_is_told() {
    let (_folder, at) = folder();
    fs::write(at("bad.png"), "no picture").unwrap();
    for (words, code) in [
        (vec!["compare", &at("bad.png"), &at("bad.png")], 1),
        (vec!["compare", &at("none.png"), &at("bad.png")], 1),
        (vec!["compare", &at("bad.png")], 2),
        (vec!["compare", &at("bad.png"), &at("bad.png"), "--diff", "diff.exr"], 2),
        (vec!["compare", &at("bad.png"), &at("bad.png"), "--threshold", "-1"], 2),
        (vec!["compare", &at("bad.png"), &at("bad.png"), "--json", &at("bad.png")], 2),
        (vec!["compare", &at("bad.png"), &at("bad.png"), "--full-scale", "1"], 2),
        (vec!["profile", &at("none.toml")], 3),
        (vec!["profile", GLASS, "--repeats", "0"], 2),
        (vec!["profile", GLASS, "--trace", "-"], 2),
        (vec!["profile", GLASS, "--json", &at("no/folder.json")], 1),
    ] {
        let output = whitted(&words).assert().code(code).get_output().clone();
        assert!(!output.stderr.is_empty() && output.stdout.is_empty(), "{words:?}");
    }
}

/// Complete events of one track: name, beginning and end in microseconds; the longer first.
fn track(trace: &Value, name: &str) -> Vec<(String, f64, f64, Value)> {
    let events = trace["traceEvents"].as_array().unwrap();
    let is_track =
        |e: &&Value| e["name"] == "thread_name" && (e["args"]["name"] == "host") == (name == "host");
    let tid = &events.iter().find(is_track).unwrap()["tid"];
    let complete = events.iter().filter(|e| e["ph"] == "X" && e["tid"] == *tid);
    let mut found: Vec<_> = complete
        .map(|e| {
            let (ts, dur) = (e["ts"].as_f64().unwrap(), e["dur"].as_f64().unwrap());
            (e["name"].as_str().unwrap().to_owned(), ts, ts + dur, e["args"].clone())
        })
        .collect();
    found.sort_by(|a, b| a.1.total_cmp(&b.1).then(b.2.total_cmp(&a.2)));
    found
}

/// True if each event lies within the one it began in. A tenth of a nanosecond is rounding.
fn nest(events: &[(String, f64, f64, Value)]) -> bool {
    let mut open: Vec<f64> = Vec::new();
    events.iter().all(|(_, begin, end, _)| {
        open.retain(|last| *last > begin + 1e-4);
        let fits = open.last().is_none_or(|last| *end <= last + 1e-4);
        open.push(*end);
        fits
    })
}

#[test]
fn a_profile_agrees_with_a_render() {
    let (_folder, at) = folder();
    let mut render = whitted(&["render", GLASS, "-o", &at("a.png"), "--report", &at("report.json")]);
    render.args(SMALL).assert().success();
    let mut profile =
        whitted(&["profile", GLASS, "--repeats", "3", "--json", "-", "--trace", &at("trace.json")]);
    let output = profile.args(SMALL).assert().success().get_output().clone();
    let (report, profile, trace) = (file(&at("report.json")), json(&output.stdout), file(&at("trace.json")));

    // The same render: the same rays, passes, items, and pixels.
    assert_eq!(profile["rays"], report["rays"]);
    assert_eq!(profile["image"]["linear_sha256"], report["image"]["linear_sha256"]);
    for key in ["settings", "plan", "counters"] {
        assert_eq!(profile[key], report[key], "{key}");
    }
    let rows = |v: &Value| -> Vec<(String, u64, u64, u64)> {
        let row = |p: &Value| {
            let number = |key: &str| p[key].as_u64().unwrap();
            (p["name"].as_str().unwrap().to_owned(), number("depth"), number("launches"), number("items"))
        };
        v.as_array().unwrap().iter().map(row).collect()
    };
    assert_eq!(rows(&profile["passes"]), rows(&report["passes"]));
    assert_eq!(rows(&profile["profile"]["passes"]), rows(&report["passes"]));
    for row in profile["profile"]["passes"].as_array().unwrap() {
        let q = |key: &str| row["seconds"][key].as_f64().unwrap();
        assert!(q("lower") <= q("median") && q("median") <= q("upper"), "{row}");
    }
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(text.contains("IQR") && text.contains("3 runs"), "{text}");

    // The trace: every kernel by its name, as often as it is launched, on exactly its items.
    let (host, device) = (track(&trace, "host"), track(&trace, "device"));
    assert!(nest(&host) && nest(&device));
    assert!(device.windows(2).all(|w| w[1].1 >= w[0].2 - 1e-4), "passes overlap");
    for (name, depth, launches, items) in rows(&report["passes"]) {
        assert!(passes::all().any(|p| p.kernel.name() == name));
        let here = device.iter().filter(|e| e.0 == name && e.3["depth"] == depth);
        let (count, sum) = here.fold((0, 0), |(n, sum), e| (n + 1, sum + e.3["items"].as_u64().unwrap()));
        assert_eq!((count, sum), (launches, items), "{name} at depth {depth}");
    }
    assert_eq!(device.len() as u64, rows(&report["passes"]).iter().map(|r| r.2).sum::<u64>());
    for name in [
        "parse scene",
        "open device",
        "build",
        "first dispatch",
        "submit",
        "read pixels",
        "encode image (PNG)",
    ] {
        assert!(host.iter().any(|e| e.0 == name), "no {name} in {host:?}");
    }
    // Each pass lies within its submit.
    for (name, begin, end, args) in &device {
        let submit = host.iter().find(|e| e.3["submit"] == args["submit"]).unwrap();
        assert!(
            submit.1 <= begin + 1e-2 && *end <= submit.2 + 1e-2,
            "{name}: {begin} to {end} in {submit:?}"
        );
    }

    // Planted: a pass that begins before the last has ended.
    let mut wrong = device;
    wrong[1].1 -= 1.0;
    assert!(!nest(&wrong), "an overlap is not noticed");
}

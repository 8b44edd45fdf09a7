//! The pages of `render` and `profile` in a browser: layers are switched through, and what the report says is there.

// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

mod browser;

use assert_cmd::Command;
use browser::{foreign, is_clean, used};
use serde_json::Value;
use std::fs;
use tempfile::TempDir;

const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell.toml");
const SMALL: &[&str] = &["--size", "36x30", "--samples", "4", "--depth", "3", "--device", "cpu", "-q"];

/// Opens every tab in turn.
const USE: &str = "
const contents = [...document.querySelectorAll('.switch label > div')];
const visible = () => contents.map(shown);
report.tabs = [...document.querySelectorAll('.switch span')].map(s => s.textContent);
report.visible = [visible()];
for (const tab of document.querySelectorAll('.switch span')) { tab.click(); report.visible.push(visible()); }
report.tops = contents.map((c, i) => {
  document.querySelectorAll('.switch span')[i].click();
  return c.getBoundingClientRect().top;
});
report.loaded = [...document.images].every(i => i.complete && i.naturalWidth > 0);
report.bars = [...document.querySelectorAll('svg.bars')].map(s => s.querySelectorAll('rect').length);
report.text = document.body.innerText;
";

fn whitted(folder: &TempDir, words: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_whitted"));
    command.current_dir(folder.path()).args(words).args(SMALL).env_remove("WHITTED_DEVICE");
    command
}

/// The page that a command wrote, used; its report, what happened, and the page.
fn page(words: &[&str], report: &str) -> (Value, Value, String) {
    let folder = TempDir::new().unwrap();
    whitted(&folder, words).assert().success();
    let at = |name: &str| fs::read(folder.path().join(name)).unwrap();
    let text = String::from_utf8(at("page.html")).unwrap();
    assert_eq!(foreign(&text), [""; 0]);
    let (used, log) = used(&text, USE);
    assert!(is_clean(&used, &log) && used["loaded"] == true, "{used}\n{log}");
    (serde_json::from_slice(&at(report)).unwrap(), used, text)
}

#[test]
fn layers_are_switched_through() {
    let words = ["render", SCENE, "-o", "a.png", "--aov", "sampling,samples,cost", "--page", "page.html"];
    let (report, used, _) = page(&[&words[..], &["--report", "a.json"]].concat(), "a.json");
    assert_eq!(used["tabs"], serde_json::json!(["picture", "sampling", "samples", "cost"]));
    // The picture first, then each in turn, always one.
    for (i, visible) in used["visible"].as_array().unwrap().iter().enumerate() {
        let open: Vec<usize> =
            visible.as_array().unwrap().iter().enumerate().filter(|v| v.1 == true).map(|v| v.0).collect();
        assert_eq!(open, [i.saturating_sub(1)], "{used}");
    }
    // All at the same place, so that they can be flipped.
    let tops = used["tops"].as_array().unwrap();
    assert!(tops.iter().all(|top| top == &tops[0]), "{tops:?}");

    // Parts and total of the error; the passes up to the last with rays.
    let passes = report["passes"].as_array().unwrap();
    let traced = report["rays"]["by_depth"].as_array().unwrap().len() as u64;
    let live = passes.iter().filter(|p| p["depth"].as_u64().unwrap() <= traced).count();
    let known = |key: &str| usize::from(!report["error"][key].is_null());
    let parts = 4 + known("encoding") + known("not_excluded");
    assert_eq!(used["bars"], serde_json::json!([parts, live + usize::from(live < passes.len())]));
    let text = used["text"].as_str().unwrap();
    for part in ["error at most", "sampling", "36x30", "owen", report["device"]["name"].as_str().unwrap()] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn a_plain_render_and_a_profile_have_a_page() {
    let words = ["render", SCENE, "-o", "a.exr", "--page", "page.html", "--report", "a.json"];
    let (report, used, text) = page(&words, "a.json");
    assert_eq!((&used["tabs"], text.matches("<img ").count()), (&serde_json::json!([]), 1));
    assert!(used["text"].as_str().unwrap().contains(report["image"]["linear_sha256"].as_str().unwrap()));

    let words = ["profile", SCENE, "--repeats", "2", "--page", "page.html", "--json", "a.json"];
    let (report, used, text) = page(&words, "a.json");
    let rows = report["profile"]["passes"].as_array().unwrap().len() as u64;
    assert!(used["bars"][0].as_u64().unwrap() <= rows && text.contains("Profile of "));
    assert!(
        text.matches("<path ").count() as u64 >= 4
            && used["text"].as_str().unwrap().contains("medians of 2 runs")
    );
}

#[test]
fn a_request_is_on_the_page() {
    let folder = TempDir::new().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_whitted"));
    command.current_dir(folder.path()).args(["render", SCENE, "-o", "a.png", "--error", "0.05", "-q"]);
    command.args(["--size", "36x30", "--device", "cpu", "--page", "page.html"]).assert().success();
    let text = fs::read_to_string(folder.path().join("page.html")).unwrap();
    assert!(text.contains("asked for an error of 0.05: kept") && text.contains("asked for</text>"));
}

#[test]
fn what_cannot_be_written_is_refused_before_the_work() {
    let folder = TempDir::new().unwrap();
    for (words, code) in [
        (vec!["render", SCENE, "-o", "a.png", "--page", "page.txt"], 2),
        (vec!["render", SCENE, "-o", "a.png", "--page", "p.html", "--report", "p.html"], 2),
        (vec!["profile", SCENE, "--page", "p.html", "--json", "p.html"], 2),
        (vec!["render", SCENE, "-o", "a.png", "--page", "none/p.html"], 1),
        (vec!["profile", SCENE, "--page", "none/p.html"], 1),
    ] {
        whitted(&folder, &words).assert().code(code);
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

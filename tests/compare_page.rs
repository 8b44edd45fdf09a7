//! Two folders of pictures: what is a pair, which pairs fail, and the page in a browser.

// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

mod browser;

use assert_cmd::Command;
use browser::{foreign, is_clean, used};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// Sorts, hides what passed, enlarges and flips.
const USE: &str = "
const heads = [...document.querySelectorAll('table.sortable th')];
const head = name => heads.find(h => h.textContent === name);
const column = name => [...document.querySelectorAll('table.sortable tbody tr')]
  .map(row => row.cells[head(name).cellIndex]).map(cell => cell.dataset.v ?? cell.textContent);
const rows = () => [...document.querySelectorAll('tbody tr, figure.row')].filter(shown).length;
report.names = [column('picture')];
report.rmse = column('RMSE');
head('picture').firstChild.click();
report.names.push(column('picture'));
report.rows = [rows()];
const box = document.getElementById('failures-only');
for (const _ of [1, 2]) { box.click(); report.rows.push(rows()); }
const figure = [...document.querySelectorAll('figure.row')].find(f => f.querySelectorAll('.view').length === 3);
const views = [...figure.querySelectorAll('.view')];
const open = () => views.map(v => v.querySelector('img').getBoundingClientRect().width > 1000);
report.open = [open()];
views[0].click();
report.open.push(open());
for (const key of ['ArrowRight', 'ArrowRight', 'Escape']) { press(key); report.open.push(open()); }
report.loaded = [...document.images].every(i => i.complete && i.naturalWidth > 0);
";

/// Two folders with one pair of each kind.
struct Folders {
    folder: TempDir,
}

impl Folders {
    fn new() -> Folders {
        let folders = Folders { folder: TempDir::new().unwrap() };
        let save = |name: &str, level: u8, wrong: u8| {
            let mut picture = image::RgbImage::from_pixel(40, 30, image::Rgb([level, 90, 60]));
            (10..20).for_each(|x| picture.put_pixel(x, 15, image::Rgb([wrong, 90, 60])));
            let path = folders.at(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            picture.save(path).unwrap();
        };
        for (name, wrong) in
            [("a/equal.png", 100), ("a/near.png", 101), ("a/deep/far.PNG", 250), ("a/only.png", 1)]
        {
            save(name, 100, wrong);
        }
        for name in ["b/equal.png", "b/near.png", "b/deep/far.PNG", "b/<other>.png"] {
            save(name, 100, 100);
        }
        fs::write(folders.at("a/notes.txt"), "no picture").unwrap();
        fs::write(folders.at("a/broken.exr"), "no picture").unwrap();
        fs::write(folders.at("b/broken.exr"), "no picture").unwrap();
        folders
    }

    fn at(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn compare(&self, more: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_whitted"));
        command.current_dir(self.folder.path()).args(["compare", "a", "b"]).args(more);
        command
    }
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

#[test]
fn pairs_are_found_by_name_and_failures_are_counted() {
    let folders = Folders::new();
    let output =
        folders.compare(&["--threshold", "0.01", "--json", "all.json"]).assert().code(6).get_output().clone();
    let (table, message) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(message.contains("6 pictures, 4 failures"), "{message}");
    let all = json(&folders.at("all.json"));
    let result = |name: &str| -> (bool, String) {
        let pair = all["pairs"].as_array().unwrap().iter().find(|p| p["file"] == name).expect(name);
        (pair["failed"].as_bool().unwrap(), pair["why"].as_str().unwrap_or_default().to_owned())
    };
    assert_eq!((result("equal.png").0, result("near.png").0), (false, false));
    for (name, why) in [
        ("deep/far.PNG", "above the threshold 0.01"),
        ("only.png", "not in b"),
        ("<other>.png", "not in a"),
        ("broken.exr", "cannot read"),
    ] {
        let (failed, said) = result(name);
        assert!(failed && said.contains(why), "{name}: {said}");
        assert!(table.contains(name) && table.contains(why), "{table}");
    }
    // The worst first: the failures without figures, then by the metric.
    let files: Vec<&str> =
        all["pairs"].as_array().unwrap().iter().map(|p| p["file"].as_str().unwrap()).collect();
    assert_eq!(files[3..], ["deep/far.PNG", "near.png", "equal.png"]);
    assert_eq!((&all["failed"], files.len()), (&4.into(), 6));

    // The same folder twice has no failure, but for the picture that cannot be read.
    fs::remove_file(folders.at("a/broken.exr")).unwrap();
    let mut same = Command::new(env!("CARGO_BIN_EXE_whitted"));
    same.current_dir(folders.folder.path())
        .args(["compare", "a", "a", "--threshold", "0"])
        .assert()
        .success();
    same.args(["--metric", "psnr"]).assert().success();
}

#[test]
fn noise_is_judged_over_all_pairs_together() {
    let folders = Folders::new();
    folders.compare(&["--statistical", "--json", "all.json"]).assert().code(6);
    let all = json(&folders.at("all.json"));
    let near = all["pairs"].as_array().unwrap().iter().find(|p| p["file"] == "near.png").unwrap();
    // Ten pixels are too few for noise.
    assert_eq!((&near["statistical"]["exact"], &near["failed"]), (&true.into(), &true.into()));
    let significance = near["statistical"]["significance"].as_f64().unwrap();
    assert!((significance - (1.0 - 0.99f64.powf(1.0 / 6.0))).abs() < 1e-12, "{significance}");
}

#[test]
fn what_cannot_be_carried_out_says_why() {
    let folders = Folders::new();
    fs::create_dir(folders.at("empty")).unwrap();
    for (words, code, why) in [
        (vec!["a", "b/near.png"], 2, "is a folder"),
        (vec!["a/near.png", "b"], 2, "is a folder"),
        (vec!["a", "b", "--diff", "d.png"], 2, "-o PAGE.html"),
        (vec!["a", "b", "-o", "page.txt"], 2, ".html"),
        (vec!["a/near.png", "b/near.png", "-o", "page.html"], 2, "--diff"),
        (vec!["a", "b", "-o", "x.html", "--json", "x.html"], 2, "same file"),
        (vec!["empty", "empty"], 1, ".png, .exr, .hdr, .ppm or .pfm"),
        (vec!["a", "b", "-o", "none/page.html"], 1, "cannot write"),
    ] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_whitted"));
        let command = command.current_dir(folders.folder.path()).arg("compare").args(&words);
        let output = command.assert().code(code).get_output().clone();
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(text.contains(why) && output.stdout.is_empty(), "{words:?}: {text}");
    }
}

#[test]
fn the_page_works_in_a_browser() {
    let folders = Folders::new();
    folders.compare(&["--threshold", "0.01", "-q", "-o", "page.html"]).assert().code(6);
    let page = fs::read_to_string(folders.at("page.html")).unwrap();
    assert_eq!(foreign(&page), [""; 0]);
    let (report, log) = used(&page, USE);
    assert!(is_clean(&report, &log), "{report}\n{log}");
    assert_eq!(report["loaded"], true);

    let names: Vec<Vec<&str>> = (0..2)
        .map(|i| report["names"][i].as_array().unwrap().iter().map(|v| v.as_str().unwrap()).collect())
        .collect();
    assert_eq!(names[0][3..], ["deep/far.PNG", "near.png", "equal.png"]);
    assert!(names[0].contains(&"<other>.png") && names[1].len() == 6 && names[1] != names[0]);
    let rmse: Vec<f64> = report["rmse"].as_array().unwrap()[3..]
        .iter()
        .map(|v| v.as_str().unwrap().parse().unwrap())
        .collect();
    assert!(rmse[0] > 0.01 && rmse[1] > 0.0 && rmse[2] == 0.0, "{rmse:?}");

    // Six rows and six figures; without the two that passed; all again.
    assert_eq!(report["rows"], serde_json::json!([12, 8, 12]));
    // A, B, the difference, and closed again.
    let open: Vec<Option<usize>> =
        (0..5).map(|i| report["open"][i].as_array().unwrap().iter().position(|wide| wide == true)).collect();
    assert_eq!(open, [None, Some(0), Some(1), Some(2), None]);

    // A broken page is noticed.
    let broken =
        page.replacen("document.querySelectorAll(\"table.sortable\")", "document.queryAll(\"t\")", 1);
    assert_ne!(broken, page);
    let (report, log) = used(&broken, USE);
    assert!(!is_clean(&report, &log), "{report}");
}

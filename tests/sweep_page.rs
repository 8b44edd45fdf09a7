//! The page of a sweep in a browser: it needs nothing but itself, sorts, unfolds, enlarges, and
//! reports no error.

// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

mod browser;

use assert_cmd::Command;
use browser::{foreign, used};
use serde_json::Value;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell.toml");

/// Sorts, unfolds and enlarges.
const USE: &str = "
const heads = [...document.querySelectorAll('table.sortable th')];
const head = name => heads.find(h => h.textContent === name);
const column = name => [...document.querySelectorAll('table.sortable tbody tr')]
  .map(row => row.cells[head(name).cellIndex]).map(cell => cell.dataset.v ?? cell.textContent);
const columns = () => heads.filter(h => getComputedStyle(h).display !== 'none').length;
const open = () => [...document.querySelectorAll('.views')[0].querySelectorAll('input')].map(i => i.checked);
Object.assign(report, { columns: [columns()], rmse: [column('RMSE')], depth: [], width: [], open: [] });
for (const _ of [1, 2]) { head('RMSE').firstChild.click(); report.rmse.push(column('RMSE')); }
head('depth').firstChild.click();
report.depth = column('depth');
for (const _ of [1, 2]) { document.querySelector('label[for=all-columns]').click(); report.columns.push(columns()); }
const view = document.querySelector('.view'), image = view.querySelector('img');
report.width.push(image.getBoundingClientRect().width);
view.click();
report.width.push(image.getBoundingClientRect().width);
report.open.push(open());
for (const key of ['ArrowRight', 'ArrowLeft', 'ArrowLeft', 'Escape']) { press(key); report.open.push(open()); }
";

/// The page of a small sweep.
fn sweep(folder: &Path) -> String {
    let out = folder.join("sweep");
    Command::new(env!("CARGO_BIN_EXE_whitted"))
        .args([
            "sweep",
            SCENE,
            "--size",
            "36x30",
            "--device",
            "cpu",
            "--repeats",
            "1",
            "--truth-samples",
            "64",
        ])
        .args(["--over", "samples=1..4", "sampler=all", "depth=1,2", "precision=robust,f64", "-q", "-o"])
        .arg(&out)
        .env_remove("WHITTED_DEVICE")
        .assert()
        .success();
    fs::read_to_string(out.join("index.html")).unwrap()
}

fn numbers(list: &Value) -> Vec<f64> {
    list.as_array().unwrap().iter().map(|v| v.as_str().unwrap().parse().unwrap()).collect()
}

#[test]
fn the_page_works_in_a_browser() {
    let folder = TempDir::new().unwrap();
    let page = sweep(folder.path());
    assert_eq!(foreign(&page), [""; 0]);
    assert_eq!(
        foreign(&format!("{page}<img src=\"https://example.com/a-picture-from-elsewhere.png\">")).len(),
        1
    );

    let (report, log) = used(&page, USE);
    assert_eq!(report["problems"].as_array().unwrap().len(), 0, "{report}\n{log}");
    assert!(!log.contains("CONSOLE"), "{log}");

    // Sorted by number, then the other way round, and no row is lost.
    let [before, up, down] = [0, 1, 2].map(|i| numbers(&report["rmse"][i]));
    assert_eq!(before.len(), 3 * 3 * 2 * 2);
    assert!(up.is_sorted() && down.iter().rev().is_sorted() && !before.is_sorted());
    let sorted = |mut list: Vec<f64>| {
        list.sort_by(f64::total_cmp);
        list
    };
    assert_eq!((sorted(before), sorted(down)), (up.clone(), up));
    assert!(numbers(&report["depth"]).is_sorted());

    // Four axes and eight columns, then all, then again the first.
    let columns: Vec<u64> = (0..3).map(|i| report["columns"][i].as_u64().unwrap()).collect();
    assert!(columns[0] == 12 && columns[1] > 20 && columns[2] == columns[0], "{columns:?}");

    // A picture fills the window; the keys show its neighbours and close it.
    assert!(report["width"][0].as_f64().unwrap() > 300.0 && report["width"][1].as_f64().unwrap() > 1000.0);
    let open: Vec<Option<usize>> = (0..5)
        .map(|i| report["open"][i].as_array().unwrap().iter().position(|checked| checked == true))
        .collect();
    assert_eq!(open, [Some(0), Some(1), Some(0), Some(2), None]);

    // One sample lies at the centre of the pixel with every sampler: one picture with all their
    // names.
    let names = "<li><b>samples=1 sampler=";
    let row = page
        .split("<figure class=\"row\">")
        .find(|row| row.contains(names))
        .expect("a picture of one sample");
    assert!(row.matches(names).count() >= 3, "{}", &row[..600]);
    assert_eq!(row.matches("<img ").count(), 2, "picture and difference");
}

#[test]
fn a_broken_page_is_noticed() {
    let folder = TempDir::new().unwrap();
    let page = sweep(folder.path());
    let broken =
        page.replacen("document.querySelectorAll(\"table.sortable\")", "document.queryAll(\"table\")", 1);
    assert_ne!(broken, page);
    let (report, log) = used(&broken, USE);
    assert!(
        report["problems"].as_array().unwrap().iter().any(|p| p.to_string().contains("queryAll")),
        "{report}\n{log}"
    );
}

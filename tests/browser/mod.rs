//! Pages in headless Chromium: opened from a file, used by a script, and judged by what the script reports.

// Each test file uses a part of it.
#![allow(dead_code)]

use serde_json::Value;
use std::fs;
use std::process::Command;
use tempfile::TempDir;

/// Notes what goes wrong while the page loads.
const WATCH: &str = "<script>window.problems = [];
addEventListener('error', e => problems.push(e.message));
console.error = (...words) => problems.push(words.join(' '));</script>";

/// Before the script that uses the page: what it reports, and helpers.
const BEFORE: &str = "<script>
const press = key => document.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true, cancelable: true }));
const shown = element => getComputedStyle(element).display !== 'none' && element.getBoundingClientRect().width > 0;
const report = {};
try {
";
/// After it.
const AFTER: &str = "
} catch (e) { problems.push(String(e)); }
report.problems = problems;
const out = document.createElement('pre');
out.id = 'report';
out.textContent = JSON.stringify(report);
document.body.append(out);
</script>";

/// Opens `page` in a browser, runs `script`, which uses the page as a reader does and writes what happened into
/// `report`; returns that and the browser's log. `report.problems` are the errors that the page raised.
pub fn used(page: &str, script: &str) -> (Value, String) {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("page.html");
    let page = page.replacen("<head>", &format!("<head>{WATCH}"), 1);
    // The page's own script comes last in its body.
    let (body, end) = page.rsplit_once("</body>").expect("a body");
    fs::write(&file, format!("{body}{BEFORE}{script}{AFTER}</body>{end}")).unwrap();
    let output = Command::new("chromium")
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--no-first-run",
            "--disable-background-networking",
        ])
        .args(["--disable-component-update", "--disable-sync", "--window-size=1300,900"])
        .args(["--enable-logging=stderr", "--v=0", "--dump-dom"])
        .arg(format!("--user-data-dir={}", folder.path().join("profile").display()))
        .arg(format!("file://{}", file.display()))
        .output()
        .expect(
            "this test needs `chromium` in the PATH: run ./whitted.sh setup, or install the package chromium",
        );
    let (dom, log) =
        (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr).into_owned());
    let report = dom.split("<pre id=\"report\">").nth(1).and_then(|rest| rest.split("</pre>").next());
    let report = report.unwrap_or_else(|| panic!("the page did not report\n{log}\n{dom}"));
    let report = report.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    (serde_json::from_str(&report).unwrap(), log)
}

/// No error in the page or in the browser's console.
pub fn is_clean(report: &Value, log: &str) -> bool {
    report["problems"].as_array().is_some_and(Vec::is_empty) && !log.contains("CONSOLE")
}

/// Addresses that a browser would load, except those inside the page.
pub fn foreign(page: &str) -> Vec<&str> {
    let starts = ["src=\"", "href=\"", "url(", "@import"];
    let addresses = starts.iter().flat_map(|start| page.split(start).skip(1));
    addresses
        .filter(|a| !a.starts_with("data:image/png;base64,") && !a.starts_with('#'))
        .filter_map(|a| a.split(['"', ')']).next())
        .collect()
}

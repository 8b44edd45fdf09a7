//! The benchmark's arithmetic, and its comparison with POV-Ray. Nothing here asserts a time.

#[path = "../benches/frames/cases.rs"]
#[allow(dead_code)]
mod cases;
#[path = "../benches/frames/paired.rs"]
mod paired;
#[path = "../benches/frames/tell.rs"]
#[allow(dead_code)]
mod tell;

use paired::{Run, in_turn, rows, work};
use std::path::Path;
use std::process::{Command, Output};

fn run(render: f64, scan: f64) -> Run {
    Run { seconds: [("scan".into(), scan), ("render".into(), render)].into(), rays: 200, picture: "a".into() }
}

/// A machine that slows down ninefold over three pairs: the ratio within each pair says 1, but for the one
/// that was disturbed. The medians' ratio would say 4.
#[test]
fn ratios_are_taken_within_pairs() {
    let pairs =
        [(run(1.0, 1.0), run(1.0, 2.0)), (run(4.0, 1.0), run(1.0, 2.0)), (run(9.0, 1.0), run(9.0, 2.0))];
    let rows = rows(&pairs, &["wall", "render", "scan"]);
    let names: Vec<&str> = rows.iter().map(|r| r.what.as_str()).collect();
    assert_eq!(names, ["render", "scan"]);
    assert_eq!((rows[0].first.median, rows[0].second.median, rows[0].ratio.median), (4.0, 1.0, 1.0));
    assert_eq!((rows[0].ratio.lower, rows[0].ratio.upper), (1.0, 2.5));
    assert_eq!((rows[1].ratio.median, rows[1].ratio.range()), (0.5, 0.0));
}

#[test]
fn what_not_all_runs_timed_has_no_row() {
    let mut without = run(1.0, 1.0);
    without.seconds.remove("scan");
    assert_eq!(rows(&[(run(1.0, 1.0), without)], &[]).len(), 1);
    assert_eq!(rows(&[(run(1.0, 0.0), run(1.0, 1.0))], &[]).len(), 1);
    assert!(rows(&[], &["render"]).is_empty());
}

#[test]
fn the_first_place_changes_hands() {
    let order = std::cell::RefCell::new(String::new());
    let say = |c: char| order.borrow_mut().push(c);
    let mut a = || {
        say('a');
        Ok::<_, ()>('a')
    };
    let mut b = || {
        say('b');
        Ok::<_, ()>('b')
    };
    assert_eq!(in_turn(3, &mut a, &mut b), Ok(vec![('a', 'b'); 3]));
    assert_eq!(*order.borrow(), "abbaab");
    let failed: Result<Vec<(char, char)>, &str> = in_turn(3, &mut || Ok('a'), &mut || Err("no"));
    assert_eq!(failed, Err("no"));
}

/// Each way in which two ways of drawing can fail to do the same work is told.
#[test]
fn other_work_is_noticed() {
    let same = work(&[(run(1.0, 1.0), run(2.0, 2.0))]);
    assert_eq!((same.same_bits, same.rays_apart()), (Some(true), Some(0.0)));
    assert_eq!(tell::same_work(&same, Some("that"), None), "200 rays each; the same bits");
    let other = |change: fn(&mut Run)| {
        let mut late = run(1.0, 1.0);
        change(&mut late);
        let pairs = [(run(1.0, 1.0), run(1.0, 1.0)), (run(1.0, 1.0), late.clone())];
        (work(&pairs), work(&[(run(1.0, 1.0), late)]))
    };
    // A picture that differs in one run of many is a difference.
    assert_eq!(other(|r| r.picture = "b".into()).0.same_bits, Some(false));
    assert_eq!(other(|r| r.picture.clear()).0.same_bits, None);
    let fewer = other(|r| r.rays = 160).1;
    let text = tell::same_work(&fewer, Some("that"), None);
    assert!(text.contains("+25.00 %, not the same work"), "{text}");
}

#[test]
fn tables_have_a_row_for_each_row() {
    let pairs = [(run(0.25, 0.001), run(0.5, 0.004))];
    let (rows, work) = (rows(&pairs, &tell::ORDER), work(&pairs));
    let text = tell::table(&rows, &work, "this", Some("that"));
    let lines: Vec<Vec<&str>> = text.lines().map(|l| l.split_whitespace().collect()).collect();
    assert_eq!(
        lines[1],
        "render 250 ms 0.00 s 500 ms 0.00 s 0.500 0.500 to 0.500".split(' ').collect::<Vec<_>>()
    );
    assert_eq!(lines[2][9], "0.250");
    let alone = tell::table(&rows, &work, "this", None);
    assert!(alone.lines().any(|l| l.starts_with("render") && l.trim_end().ends_with(" 800")), "{alone}");
}

/// The script on a small scene; None where there is no Python that can run it.
fn povray(more: &[&str]) -> Option<Output> {
    let new = "import sys; sys.exit(sys.version_info < (3, 11))";
    if !Command::new("python3").args(["-c", new]).status().is_ok_and(|s| s.success()) {
        eprintln!("skipped: no python3 of 3.11 or newer");
        return None;
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let output = Command::new("python3")
        .arg(root.join("benches/povray.py"))
        .arg(root.join("scenes/cornell_glass.toml"))
        .args(["--whitted", env!("CARGO_BIN_EXE_whitted"), "--pictures-only", "--size", "90x60"])
        .args(more)
        .env("WHITTED_DEVICE", "cpu")
        .output();
    Some(output.expect("python3 runs"))
}

#[test]
fn without_povray_the_script_says_so_and_is_content() {
    let Some(output) = povray(&["--povray", "/no/such/program"]) else { return };
    assert!(output.status.success());
    assert!(String::from_utf8_lossy(&output.stdout).contains("POV-Ray is not installed"));
}

/// An independent renderer draws the same picture with the same rays; a wrong falloff of light is noticed.
#[test]
fn povray_draws_the_same_picture() {
    let Some(output) = povray(&[]) else { return };
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    if text.contains("not installed") {
        eprintln!("skipped: {text}");
        return;
    }
    assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
    assert!(text.contains("RMSE") && !text.contains("not the same work"), "{text}");
    let wrong = povray(&["--planted-power", "1.9"]).expect("it just ran");
    assert!(String::from_utf8_lossy(&wrong.stderr).contains("pictures differ"), "{wrong:?}");
}

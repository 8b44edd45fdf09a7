//! Renders that are killed, as by a power cut or the out-of-memory killer, go on from their last state: the same file
//! and the same counts as of a render that was left alone.
#![cfg(unix)]
// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant, SystemTime};
use tempfile::TempDir;
use whitted::settings::sampler::pcg4d;

const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell.toml");
/// Kills of each render.
const KILLS: u32 = 4;

/// Ends its process even where the test fails before that.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // On Unix this is SIGKILL, which a process cannot answer.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn start(folder: &TempDir, words: &[&str]) -> Running {
    let child = Command::new(env!("CARGO_BIN_EXE_whitted"))
        .current_dir(folder.path())
        .args(["render", SCENE, "--device", "cpu", "-q", "--checkpoint", "0.05"])
        .args(words)
        .stderr(Stdio::null())
        .spawn();
    Running(child.unwrap())
}

fn done(folder: &TempDir, words: &[&str]) {
    let mut running = start(folder, words);
    assert_eq!(running.0.wait().unwrap().code(), Some(0), "{words:?}");
}

/// Waits for a state that was written after `since`; false if the render ended instead.
fn kept(running: &mut Running, state: &Path, since: SystemTime) -> bool {
    let begin = Instant::now();
    loop {
        if fs::metadata(state).and_then(|m| m.modified()).is_ok_and(|time| time > since) {
            return true;
        }
        if running.0.try_wait().unwrap().is_some() {
            return false;
        }
        assert!(begin.elapsed() < Duration::from_secs(240), "no state is written");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Kills a render at random moments, lets it go on each time, and gives how often that was.
fn killed(folder: &TempDir, out: &str, words: &[&str]) -> u32 {
    let state = folder.path().join(format!("{out}.partial"));
    for kill in 0..KILLS {
        let since = fs::metadata(&state).and_then(|m| m.modified()).unwrap_or(SystemTime::UNIX_EPOCH);
        let mut running = start(folder, &[words, &["-o", out, "--resume"]].concat());
        if !kept(&mut running, &state, since) {
            return kill;
        }
        let [random, ..] = pcg4d([kill, words.len() as u32, 7, 7]);
        std::thread::sleep(Duration::from_millis(u64::from(random % 150)));
    }
    KILLS
}

fn counts(folder: &TempDir, name: &str) -> Value {
    let mut report: Value = serde_json::from_slice(&fs::read(folder.path().join(name)).unwrap()).unwrap();
    let whole = report.as_object_mut().unwrap();
    for key in ["time", "plan", "passes"] {
        whole.remove(key).unwrap();
    }
    whole["image"]["file"] = Value::Null;
    report
}

/// `words` killed and resumed, against the same left alone.
fn check(words: &str, extension: &str) {
    let folder = tempfile::tempdir().unwrap();
    let words: Vec<&str> = words.split_whitespace().collect();
    let (whole, out) = (format!("whole.{extension}"), format!("a.{extension}"));
    let report = ["--report", "a.json"];
    done(&folder, &[&words[..], &["-o", &whole, "--report", "whole.json"]].concat());
    let kills = killed(&folder, &out, &words);
    assert!(kills > 0, "the render ended before it was killed");
    done(&folder, &[&words[..], &["-o", &out, "--resume"], &report].concat());
    if extension != "share" {
        let same = fs::read(folder.path().join(out)).unwrap() == fs::read(folder.path().join(whole)).unwrap();
        assert!(same, "not one byte differs after {kills} kills");
    }
    assert_eq!(counts(&folder, "a.json"), counts(&folder, "whole.json"), "after {kills} kills");
    assert!(!folder.path().join(format!("a.{extension}.partial")).exists(), "the state is gone");
}

#[test]
fn a_plain_render() {
    // One tile: all states are of samples inside it.
    check("--size 120x100 --samples 400 --depth 4", "exr");
}

#[test]
fn a_share() {
    check("--size 160x120 --samples 400 --depth 4 --share 2/2", "share");
}

#[test]
fn a_budget() {
    check("--size 64x50 --samples 256 --depth 4 --budget", "exr");
}

#[test]
fn an_error() {
    check("--size 64x50 --precision robust --error 0.002", "exr");
}

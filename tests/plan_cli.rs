//! `whitted plan` and `whitted render --receipt` as a user meets them.

// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

fn whitted(folder: &Path, words: &str) -> Output {
    let scenes = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/");
    Command::new(env!("CARGO_BIN_EXE_whitted"))
        .current_dir(folder)
        .args(words.replace("scenes/", scenes).split(' '))
        .env("WHITTED_DEVICE", "cpu")
        .output()
        .unwrap()
}

fn json(folder: &Path, file: &str) -> Value {
    serde_json::from_str(&std::fs::read_to_string(folder.join(file)).unwrap()).unwrap()
}

#[test]
fn a_plan_tells_what_follows_from_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let done = whitted(folder.path(), "plan scenes/many_lights.toml --size 64x48 --depth 7 --json plan.json");
    assert!(done.status.success(), "{done:?}");
    let plan = json(folder.path(), "plan.json");
    // Nothing reflects or refracts, and nine lights are sampled one after the other.
    assert_eq!((&plan["reach"]["last"], &plan["search"]["kind"]), (&1.into(), &"brute force".into()));
    let shadow = plan["plan"]["kernels"].as_array().unwrap().iter().find(|k| k["kernel"] == "shadow");
    assert_eq!(shadow.unwrap()["launches"], 9);
    assert!(String::from_utf8_lossy(&done.stdout).contains("9 lights"));
    assert!(plan["time"]["render"].as_f64().unwrap() > 0.0);
    assert_eq!(plan["time"]["by_depth"].as_array().unwrap().len(), 1);
    let sum: u64 =
        plan["plan"]["buffers"].as_array().unwrap().iter().map(|b| b["bytes"].as_u64().unwrap()).sum();
    // All but the self-test's one number, which is no buffer of a frame.
    assert_eq!(plan["plan"]["bytes"].as_u64().unwrap() - sum, 4);
}

/// The largest image takes 160 GiB of the host's memory.
#[test]
fn a_refused_plan_is_told_with_its_exit_code() {
    let folder = tempfile::tempdir().unwrap();
    let words = "plan scenes/cornell.toml --size 65535x65535 --json plan.json";
    let refused = whitted(folder.path(), words);
    assert_eq!(refused.status.code(), Some(1), "{refused:?}");
    let text = String::from_utf8(refused.stdout).unwrap();
    let plan = json(folder.path(), "plan.json");
    assert!(plan["time"].is_null() && plan["refused"]["exit_code"] == 1, "{plan}");
    let why = plan["refused"]["message"].as_str().unwrap();
    assert!(why.contains("65535x65535") && text.contains(why), "{text}");
    let absent = whitted(folder.path(), "plan scenes/cornell.toml --from absent.json");
    assert_eq!(absent.status.code(), Some(1), "{absent:?}");
    assert!(String::from_utf8_lossy(&absent.stderr).contains("absent.json"));
}

#[test]
fn a_report_foretells_another_render() {
    let folder = tempfile::tempdir().unwrap();
    let render =
        "render scenes/two_mirrors.toml -o a.png --size 64x48 --samples 2 --depth 4 --report a.json -q";
    assert!(whitted(folder.path(), render).status.success());
    let words = "plan scenes/two_mirrors.toml --size 64x48 --samples 4 --depth 5 --from a.json --json - -q";
    let done = whitted(folder.path(), words);
    assert!(done.status.success(), "{done:?}");
    let plan: Value = serde_json::from_slice(&done.stdout).unwrap();
    let (time, report) = (&plan["time"], json(folder.path(), "a.json"));
    let rays = |v: &Value| v["traced"].as_u64().unwrap();
    for depth in 0..4 {
        assert_eq!(rays(&time["by_depth"][depth]), 2 * rays(&report["rays"]["by_depth"][depth]));
    }
    assert_eq!(time["by_depth"][4]["extrapolated"], true);
    // Of depth 1 nothing follows for depth 2: a trial then says so.
    let shallow =
        "render scenes/two_mirrors.toml -o b.png --size 64x48 --samples 2 --depth 1 --report b.json -q";
    assert!(whitted(folder.path(), shallow).status.success());
    let tried = whitted(folder.path(), "plan scenes/two_mirrors.toml --size 64x48 --depth 2 --from b.json");
    assert!(
        tried.status.success() && String::from_utf8_lossy(&tried.stderr).contains("a trial instead"),
        "{tried:?}"
    );
    assert!(String::from_utf8_lossy(&tried.stdout).contains("a trial of"), "{tried:?}");
    // Another scene's report says nothing of this one.
    let other = whitted(folder.path(), "plan scenes/cornell.toml --from a.json");
    assert_eq!(other.status.code(), Some(2), "{other:?}");
    assert!(String::from_utf8_lossy(&other.stderr).contains("scene"), "{other:?}");
}

#[test]
fn a_receipt_prices_what_is_absent() {
    let folder = tempfile::tempdir().unwrap();
    let words = "render scenes/many_lights.toml -o a.png --size 40x30 --samples 1 --receipt --report a.json";
    let done = whitted(folder.path(), words);
    assert!(done.status.success(), "{done:?}");
    let receipt = &json(folder.path(), "a.json")["receipt"];
    let absent = receipt["absent"].as_array().unwrap();
    let names: Vec<&str> = absent.iter().map(|a| a["feature"].as_str().unwrap()).collect();
    // It has triangles, a sphere and lights; all else it does without.
    let expected = [
        "wide-spheres",
        "smooth-normals",
        "refraction",
        "nested-media",
        "branching",
        "secondary",
        "hierarchy",
        "lone-rays",
        "storage",
    ];
    let depth = json(folder.path(), "a.json")["settings"]["depth"].as_u64().unwrap();
    assert_eq!(
        names,
        expected.iter().filter(|f| depth > 1 || **f != "secondary").copied().collect::<Vec<_>>()
    );
    assert!(absent.iter().all(|a| a["pixels_differ"] == 0 && a["ratio"]["median"].as_f64().unwrap() > 0.0));
    assert!(receipt["bytes_taken"].as_u64() >= receipt["bytes_planned"].as_u64());
    // Half of the rows were tried.
    let rays = receipt["rays_over_predicted"].as_f64().unwrap();
    assert!((0.8..1.2).contains(&rays), "{rays}");
    let said = String::from_utf8(done.stderr).unwrap();
    assert!(said.contains("left out") && said.contains("same bits"), "{said}");
}

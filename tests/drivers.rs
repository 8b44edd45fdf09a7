//! What a driver can do is asked: the more capable of two is taken, a file that is no driver is named, compiled code
//! does not pass from one vector width to another, and an interrupt is answered while a driver compiles.

// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

#[path = "common/drivers.rs"]
mod drivers;

use drivers::{both, lavapipe, swift_shader, whitted};
use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

const SMALL: [&str; 4] = ["--size", "20x15", "--samples", "1"];

fn json(output: &Output) -> serde_json::Value {
    assert!(output.status.success(), "{}", both(output));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Renders small on `drivers` with more `options`; the report.
fn render(
    folder: &Path,
    drivers: &[&Path],
    options: &[&str],
    variables: &[(&str, &str)],
) -> serde_json::Value {
    let report = folder.join("report.json");
    let output = whitted(drivers, &folder.join("cache"))
        .args(["render", "scenes/mesh_glass.toml"])
        .args(SMALL)
        .arg("-o")
        .arg(folder.join("image.png"))
        .arg("--report")
        .arg(&report)
        .args(options)
        .envs(variables.iter().copied())
        .output()
        .unwrap();
    assert!(output.status.success(), "{options:?} {variables:?}: {}{}", output.status, both(&output));
    serde_json::from_slice(&fs::read(report).unwrap()).unwrap()
}

#[test]
fn the_more_capable_of_two_drivers_is_taken() {
    let folder = tempfile::tempdir().unwrap();
    let (lavapipe, swift_shader) = (lavapipe(), swift_shader());
    for drivers in [[&*lavapipe, &*swift_shader], [&*swift_shader, &*lavapipe]] {
        let all = json(&whitted(&drivers, folder.path()).args(["devices", "--json"]).output().unwrap());
        let all = all.as_array().unwrap();
        assert_eq!(all.len(), 2, "{all:?}");
        for device in all {
            let is_lavapipe = device["name"].as_str().unwrap().starts_with("llvmpipe");
            assert_eq!(device["default"], is_lavapipe, "{device}");
            assert_eq!(device["behind"].is_null(), is_lavapipe, "{device}");
            // Forms were measured for both drivers.
            assert_eq!(device["switched"]["packets"], is_lavapipe, "{device}");
        }
        let text = both(&whitted(&drivers, folder.path()).arg("devices").output().unwrap());
        assert!(text.contains("; the default computes in f64"), "{text}");
        for options in [&["--precision", "f64"][..], &["--device", "cpu"]] {
            let report = render(folder.path(), &drivers, options, &[]);
            assert!(report["device"]["name"].as_str().unwrap().starts_with("llvmpipe"), "{report}");
        }
        let report = render(folder.path(), &drivers, &["--device", "swiftshader"], &[]);
        assert!(report["device"]["name"].as_str().unwrap().starts_with("SwiftShader"), "{report}");
    }
}

#[test]
fn a_file_that_is_no_driver_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let garbage = folder.path().join("garbage.json");
    fs::write(&garbage, "no driver").unwrap();
    let empty = folder.path().join("empty");
    fs::create_dir(&empty).unwrap();
    let missing = folder.path().join("missing.json");
    let lavapipe = lavapipe();
    for (file, why) in [(&garbage, "not JSON"), (&empty, "without driver files"), (&missing, "No such file")]
    {
        let told = |text: &str| text.contains(&file.display().to_string()) && text.contains(why);
        let output = whitted(&[file], folder.path()).arg("devices").output().unwrap();
        assert_eq!(output.status.code(), Some(4), "{}", both(&output));
        assert!(told(&both(&output)), "{}", both(&output));
        // Beside a driver that is one, it is a warning.
        let output = whitted(&[file, &lavapipe], folder.path()).arg("devices").output().unwrap();
        assert!(
            output.status.success() && told(&String::from_utf8_lossy(&output.stderr)),
            "{}",
            both(&output)
        );
        let report = render(folder.path(), &[file, &lavapipe], &[], &[]);
        assert!(told(&report["warnings"].to_string()), "{report}");
    }
}

/// Mesa's disk cache takes code for one vector width for code for another; so each has a cache of its own.
#[test]
fn compiled_code_stays_with_its_vector_width() {
    let folder = tempfile::tempdir().unwrap();
    let lavapipe = lavapipe();
    let hash = |variables: &[(&str, &str)]| {
        render(folder.path(), &[&lavapipe], &[], variables)["image"]["linear_sha256"].clone()
    };
    let widths = ["128", "512"].map(|width| hash(&[("LP_NATIVE_VECTOR_WIDTH", width)]));
    let usual = hash(&[]);
    assert_eq!(widths, [usual.clone(), usual.clone()]);
    assert_eq!(hash(&[("LP_NATIVE_VECTOR_WIDTH", "128")]), usual);
    let is_there = |name: &str| folder.path().join("cache").join(name).is_dir();
    assert!(is_there("whitted/mesa-128-bit-vectors") && is_there("whitted/mesa-512-bit-vectors"));
    assert!(is_there("mesa_shader_cache"));
    let names: Vec<String> = fs::read_dir(folder.path().join("cache/whitted"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.starts_with("pipelines-"))
        .collect();
    assert_eq!(names.len(), 3, "subgroups of 4, 8 and 16: {names:?}");
}

/// Mesa maps its cache's index without asking for room: on a file system in memory that is full, writing to it ends
/// the process.
#[test]
fn a_full_file_system_in_memory_ends_no_render() {
    let folder = tempfile::tempdir().unwrap();
    let script = "mount -t tmpfs -o size=1m none \"$XDG_CACHE_HOME\" || exit 77; \
                  head -c 2M /dev/zero >\"$XDG_CACHE_HOME/fill\" 2>&1; exec \"$@\"";
    let (lavapipe, cache) = (lavapipe(), folder.path().join("cache"));
    fs::create_dir(&cache).unwrap();
    let image = folder.path().join("image.png");
    let program = whitted(&[&lavapipe], &cache);
    let run = |options: &[&str]| {
        Command::new("unshare")
            .args(["--map-root-user", "--mount", "sh", "-c", script, "sh"])
            .arg(program.get_program())
            .args(["render", "scenes/mesh_glass.toml", "-o"])
            .arg(&image)
            .args(options)
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .envs(program.get_envs().filter_map(|(name, value)| Some((name, value?))))
            .env_remove("MESA_SHADER_CACHE_DISABLE")
            .output()
    };
    // Where it gets as far as the program, that refuses this.
    match run(&["--no-such-option"]) {
        Ok(output) if output.status.code() == Some(2) => {}
        Ok(output) => return println!("skipped: no namespace of its own: {}", both(&output)),
        Err(error) => return println!("skipped: no unshare: {error}"),
    }
    let output = run(&SMALL).unwrap();
    let text = both(&output);
    assert!(output.status.success(), "{}{text}", output.status);
    assert!(
        text.contains("the driver's cache of compiled kernels is off") && text.contains("0 MiB free"),
        "{text}"
    );
}

/// The first dispatches of large kernels compile for seconds. Whether the driver is still at it when the signal
/// comes or not, the process ends with the documented code, and before the kernels' time is over.
#[cfg(unix)]
#[test]
fn an_interrupt_is_answered_while_kernels_compile() {
    let folder = tempfile::tempdir().unwrap();
    let lavapipe = lavapipe();
    let start = |samples: &str| {
        whitted(&[&lavapipe], folder.path())
            .args(["render", "scenes/nested_glass.toml", "--general", "all", "--size", "400x300", "-v"])
            .args(["--samples", samples, "-o"])
            .arg(folder.path().join("image.png"))
            .env("MESA_SHADER_CACHE_DISABLE", "true")
            .stderr(Stdio::piped())
            .spawn()
            .unwrap()
    };
    for wait in [300, 1000] {
        let mut child = start("1000");
        sleep(Duration::from_millis(wait));
        assert!(child.try_wait().unwrap().is_none(), "it ended by itself");
        let begun = Instant::now();
        let killed = Command::new("kill").arg(child.id().to_string()).status().unwrap();
        assert!(killed.success());
        let output = child.wait_with_output().unwrap();
        println!("after {wait} ms: {:?}, {}", begun.elapsed(), String::from_utf8_lossy(&output.stderr));
        assert_eq!(output.status.code(), Some(130), "{}", both(&output));
        assert!(both(&output).contains("interrupted"), "{}", both(&output));
    }
}

//! Kernels compiled by RADV for a GPU that is not there: none spills, none loses waves unnoticed. The figures are those
//! of docs/design/navi21.md, which `WHITTED_UPDATE_DOCS=1 cargo test --test absent_gpu` rewrites.

// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

use serde_json::Value;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

const PAGE: &str = "docs/design/navi21.md";
/// What is compiled: name, file, arguments. Between them they have every form.
const SUBJECTS: &[(&str, &str, &[&str])] = &[
    ("brute force, f32", "scenes/cornell_glass.toml", &[]),
    ("brute force, f64", "scenes/cornell_glass.toml", &["--precision", "f64"]),
    ("hierarchy, f32", "flake", &[]),
    ("hierarchy, f64", "flake", &["--precision", "f64"]),
];

fn radv() -> PathBuf {
    let folders = ["/usr/share/vulkan/icd.d", "/usr/local/share/vulkan/icd.d", "/etc/vulkan/icd.d"];
    let files = folders.iter().filter_map(|f| std::fs::read_dir(f).ok()).flatten().flatten();
    let found = files.map(|f| f.path()).find(|f| {
        let name = f.file_name().unwrap_or_default().to_string_lossy().into_owned();
        // Debian 13 has one file for all processors.
        name == "radeon_icd.json" || name == format!("radeon_icd.{}.json", std::env::consts::ARCH)
    });
    found.expect("Mesa's RADV (Debian and Ubuntu: `apt-get install mesa-vulkan-drivers`)")
}

fn whitted() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_whitted"));
    command
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .env_remove("WHITTED_DEVICE")
        .env_remove("VK_ICD_FILENAMES")
        .env("VK_DRIVER_FILES", radv())
        .env("RADV_FORCE_FAMILY", "navi21");
    command
}

fn output(command: &mut Command) -> String {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// What the driver says of a subject's kernels.
fn compiled(file: &str, arguments: &[&str], flake: &Path) -> Value {
    let file = if file == "flake" { flake } else { Path::new(file) };
    let text = output(whitted().arg("kernels").arg(file).args(arguments).args(["--json", "-"]));
    serde_json::from_str(&text).unwrap()
}

fn flake(folder: &Path) -> PathBuf {
    let file = folder.join("flake.toml");
    output(whitted().args(["generate", "sphereflake", "-o"]).arg(&file));
    file
}

/// One of the driver's statistics of a kernel.
fn figure(kernel: &Value, name: &str) -> u64 {
    let statistics = kernel["executables"][0]["statistics"].as_array().unwrap();
    let of = |s: &&Value| s["name"].as_str().unwrap() == name;
    statistics.iter().find(of).unwrap_or_else(|| panic!("no `{name}` in {kernel}"))["value"].as_u64().unwrap()
}

fn table(found: &[(&str, Value)]) -> String {
    let mut text = String::from(
        "| scene | kernel | VGPRs | waves a SIMD, of 32 | scratch, bytes a wave | shared, bytes a workgroup | code, bytes |\n\
         |---|---|---:|---:|---:|---:|---:|\n",
    );
    for (name, found) in found {
        for kernel in found["kernels"].as_array().unwrap() {
            let of = |name| figure(kernel, name);
            let parts = if kernel["in_parts"] == true { ", in parts" } else { "" };
            writeln!(
                text,
                "| {name} | `{}`{parts} | {} | {} | {} | {} | {} |",
                kernel["kernel"].as_str().unwrap(),
                of("VGPRs"),
                of("Subgroups per SIMD"),
                of("Scratch size"),
                of("LDS size"),
                of("Code size")
            )
            .unwrap();
        }
    }
    text
}

fn page(found: &[(&str, Value)]) -> String {
    let driver = found[0].1["device"]["driver"].as_str().unwrap();
    format!(
        "# Kernels compiled for a GPU\n\n\
         What {driver} makes of the kernels for navi21 (an AMD GPU of 2020), in waves of 64. Nothing of this has run: the numbers are the\n\
         compiler's, and `RADV_FORCE_FAMILY=navi21 whitted kernels SCENE --device navi21` prints more of them. No kernel spills registers,\n\
         which `tests/absent_gpu.rs` checks. Rays of the hierarchy's kernels keep their stack in scratch memory\n\
         ([what else was tried](decisions/039-stack-of-a-ray.md)). The scenes: `scenes/cornell_glass.toml`, and the sphereflake of\n\
         `whitted generate`.\n\n\
         {}",
        table(found)
    )
}

#[test]
fn no_kernel_spills_and_none_loses_waves_unnoticed() {
    let folder = tempfile::tempdir().unwrap();
    let flake = flake(folder.path());
    let found: Vec<(&str, Value)> =
        SUBJECTS.iter().map(|(name, file, arguments)| (*name, compiled(file, arguments, &flake))).collect();
    for (name, found) in &found {
        let kernels = found["kernels"].as_array().unwrap();
        assert!(kernels.iter().any(|k| k["kernel"] == "intersect") && kernels.len() >= 9, "{found}");
        for kernel in kernels {
            for spilled in ["Spilled SGPRs", "Spilled VGPRs"] {
                assert_eq!(figure(kernel, spilled), 0, "{name}, {}: {spilled}", kernel["kernel"]);
            }
        }
    }
    let (page, file) = (page(&found), Path::new(env!("CARGO_MANIFEST_DIR")).join(PAGE));
    if std::env::var_os("WHITTED_UPDATE_DOCS").is_some() {
        std::fs::write(&file, &page).unwrap();
    }
    let written = std::fs::read_to_string(&file).unwrap();
    // Another compiler gives other figures.
    let driver = found[0].1["device"]["driver"].as_str().unwrap();
    if written.contains(&format!("What {driver} makes of")) {
        assert!(page == written, "{PAGE} has other figures than\n{page}");
    } else {
        println!("{PAGE} is of another driver than {driver}: not compared");
    }
}

/// As a user meets it.
#[test]
fn code_is_shown_and_what_has_no_answer_says_so() {
    let text = output(whitted().args(["kernels", "scenes/cornell.toml", "--isa"]));
    for part in ["intersect", "in parts", "VGPRs", "; intersect, ", "v_mul_f32"] {
        assert!(text.contains(part), "no {part}");
    }
    let lavapipe = whitted()
        .env_remove("VK_DRIVER_FILES")
        .args(["kernels", "scenes/cornell.toml", "--device", "cpu"])
        .output()
        .unwrap();
    // Newer drivers answer.
    let said = String::from_utf8_lossy(&lavapipe.stderr).into_owned();
    assert!(
        lavapipe.status.success() || (lavapipe.status.code() == Some(4) && said.contains("does not tell")),
        "{said}"
    );
    // Absent hardware renders nothing.
    let render = whitted().args(["render", "scenes/cornell.toml", "-o", "never.png"]).output().unwrap();
    assert_eq!(render.status.code(), Some(4));
    assert!(String::from_utf8_lossy(&render.stderr).contains("it has no memory"));
}

//! Every kernel has its twin, its test and its place in ARCHITECTURE.md, under the same word.

// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

use std::path::Path;
use whitted::kernels::KERNELS;

fn read(path: &str) -> String {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    std::fs::read_to_string(&file).unwrap_or_else(|e| panic!("{path}: {e}"))
}

#[test]
fn every_kernel_has_a_twin() {
    for kernel in KERNELS {
        let twin = read(&format!("src/cpu/twin/{}.rs", kernel.name));
        assert!(twin.contains(&format!("glsl/{}.comp", kernel.name)), "{}: twin of what?", kernel.name);
        assert!(twin.contains(&format!("pub fn {}(", kernel.name)), "{}: no such function", kernel.name);
    }
}

#[test]
fn every_library_file_has_a_twin() {
    for entry in std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("glsl/lib")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap();
        match name {
            // Declarations, and the pixel's samples, whose twin is used by the oracle too.
            "prelude" => {}
            "sampler" => assert!(read("src/sampler.rs").contains("pcg4d")),
            _ => assert!(
                read(&format!("src/cpu/twin/lib/{name}.rs")).contains(&format!("glsl/lib/{name}.glsl"))
            ),
        }
    }
}

#[test]
fn every_kernel_has_a_test() {
    let tests = read("tests/kernels.rs");
    for kernel in KERNELS {
        assert!(tests.contains(&format!("#[test]\nfn {}() {{", kernel.name)), "{} has no test", kernel.name);
    }
}

#[test]
fn every_kernel_is_described() {
    let text = read("ARCHITECTURE.md");
    for kernel in KERNELS {
        assert!(text.contains(&format!("`{}`", kernel.name)), "{} is not in ARCHITECTURE.md", kernel.name);
    }
}

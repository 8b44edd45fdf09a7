//! Every kernel has its twin, its test and its place in ARCHITECTURE.md, under the same word.

// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

use std::path::Path;
use whitted::kernel::table::KERNELS;
use whitted::plan::passes;

fn read(path: &str) -> String {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    std::fs::read_to_string(&file).unwrap_or_else(|e| panic!("{path}: {e}"))
}

/// Kernels of the frame.
fn frame() -> impl Iterator<Item = &'static str> {
    passes::all().map(|p| p.kernel.name())
}

#[test]
fn every_kernel_has_a_twin() {
    for name in frame() {
        let twin = read(&format!("src/reference/twin/{name}.rs"));
        assert!(twin.contains(&format!("glsl/{name}.comp")), "{name}: twin of what?");
        assert!(twin.contains(&format!("pub fn {name}(")), "{name}: no such function");
    }
}

#[test]
fn every_library_file_has_a_twin() {
    for entry in std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("glsl/lib")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap();
        match name {
            // Declarations, and loads that compute nothing: the twins index, and tests/kernels.rs compares
            // texel views with them. The pixel's samples have a twin that the oracle uses too.
            "prelude" | "fetch" => {}
            // How a subgroup works together: the twins work alone and find the same.
            "lanes" => {}
            "children" => assert!(read("src/reference/twin/trace.rs").contains("glsl/lib/children.glsl")),
            "packet" => assert!(read("src/reference/twin/lib/trace.rs").contains("glsl/lib/packet.glsl")),
            "sampler" => assert!(read("src/settings/sampler.rs").contains("glsl/lib/sampler.glsl")),
            _ => assert!(
                read(&format!("src/reference/twin/lib/{name}.rs")).contains(&format!("glsl/lib/{name}.glsl"))
            ),
        }
    }
}

#[test]
fn every_kernel_has_a_test() {
    let tests = read("tests/kernels.rs");
    for name in frame() {
        assert!(tests.contains(&format!("#[test]\nfn {name}() {{")), "{name} has no test");
    }
    // Outside the frame there is one, which has its own judge.
    let others: Vec<_> = KERNELS.iter().map(|k| k.name).filter(|name| frame().all(|f| f != *name)).collect();
    assert_eq!(others, ["selftest"]);
    assert!(read("src/render/self_test.rs").contains("#[test]"), "selftest has no test");
}

#[test]
fn every_kernel_is_described() {
    let text = read("ARCHITECTURE.md");
    for kernel in KERNELS {
        assert!(text.contains(&format!("`{}`", kernel.name)), "{} is not in ARCHITECTURE.md", kernel.name);
    }
}

//! Every kernel has its twin, its test and its place in the architecture page, under the same word.

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
    let library = Path::new(env!("CARGO_MANIFEST_DIR")).join("glsl/lib");
    let folders = std::fs::read_dir(library).unwrap().map(|e| e.unwrap().path());
    let files = folders.flat_map(|f| std::fs::read_dir(f).unwrap().map(|e| e.unwrap().path()));
    for path in files {
        let name = path.file_stem().unwrap().to_str().unwrap();
        let twin = match name {
            // Declarations, and loads that compute nothing: the twins index, and tests/kernels.rs compares
            // texel views with them.
            "prelude" | "fetch" => continue,
            // How a subgroup works together: the twins work alone and find the same.
            "lanes" => continue,
            "children" => "reference/twin/trace",
            "packet" => "reference/twin/lib/traverse",
            // The oracle takes the same samples.
            "sampler" => "settings/sampler",
            _ => &format!("reference/twin/lib/{name}"),
        };
        assert!(read(&format!("src/{twin}.rs")).contains(&format!("{name}.glsl")), "{twin}: twin of what?");
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
    let text = read("docs/design/architecture.md");
    for kernel in KERNELS {
        assert!(text.contains(&format!("`{}`", kernel.name)), "{} is not in the page", kernel.name);
    }
}

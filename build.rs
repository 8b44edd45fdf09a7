//! Turns `glsl/*.comp` into SPIR-V, checks it against `src/kernel/abi/`, and writes the typed kernel table
//! `kernels.rs`.
//!
//! shaderc compiles the kernels where `--cfg whitted_shaderc` says that libshaderc can be linked, which
//! `./whitted.sh setup` writes into `.cargo/config.toml`. Elsewhere the kernels are those of
//! `glsl/kernels.pack`, provided that it was made from these sources.
//!
//! With the feature `defects` the kernels are compiled once more in the folder `defects`, from sources with planted
//! mistakes (`src/kernel/defects.rs`).

#[path = "src/kernel/abi/mod.rs"]
#[allow(dead_code, unused_imports)]
mod abi;
#[path = "src/kernel/defects.rs"]
#[allow(dead_code)]
mod defects;
#[path = "src/kernel/spirv.rs"]
#[allow(dead_code)]
mod spirv;
#[cfg(whitted_shaderc)]
#[path = "build/compile.rs"]
mod compile;
#[path = "build/pack.rs"]
#[allow(dead_code)] // A build either writes a pack or reads one.
mod pack;
#[path = "build/sources.rs"]
mod sources;
#[path = "build/table.rs"]
mod table;

use pack::Compiled;
use std::path::{Path, PathBuf};
use std::{env, fs, process};

fn main() {
    for path in ["src/kernel/abi", "src/kernel/defects.rs", "src/kernel/spirv.rs", "glsl", "build"] {
        println!("cargo:rerun-if-changed={path}");
    }
    // The log of HEAD grows with every commit, HEAD itself only changes with the branch.
    if Path::new(".git/logs/HEAD").exists() {
        println!("cargo:rerun-if-changed=.git/logs/HEAD");
    }
    // Only of a repository that is this package's own, not of one that holds a copy of the package.
    if Path::new(".git").exists()
        && let Ok(out) = process::Command::new("git").args(["rev-parse", "--short=12", "HEAD"]).output()
        && out.status.success()
    {
        println!("cargo:rustc-env=WHITTED_GIT={}", String::from_utf8_lossy(&out.stdout).trim());
    }
    if let Err(message) = build() {
        eprintln!("{message}");
        process::exit(1);
    }
}

fn build() -> Result<(), String> {
    let out = PathBuf::from(env::var("OUT_DIR").map_err(|e| e.to_string())?);
    let sources = sources::read()?;
    let digest = sources::digest(&sources)?;
    let compiled = kernels(&out, &sources, &digest)?;
    table::write(&out, &sources, &compiled, table::Kernels::Shipped)?;
    if env::var_os("CARGO_FEATURE_DEFECTS").is_none() {
        return Ok(());
    }
    let out = out.join("defects");
    fs::create_dir_all(&out).map_err(|e| format!("{}: {e}", out.display()))?;
    table::write(&out, &sources, &planted(&sources)?, table::Kernels::Planted)
}

/// Compiles the kernels, and packs them where a test and `./whitted.sh kernels` find them.
#[cfg(whitted_shaderc)]
fn kernels(out: &Path, sources: &[sources::Source], digest: &str) -> Result<Vec<Compiled>, String> {
    let compiled = compile::all(sources, false)?;
    let file = out.join("kernels.pack");
    fs::write(&file, pack::write(digest, &compile::tools(), &compiled)?).map_err(|e| e.to_string())?;
    println!("cargo:rustc-env=WHITTED_KERNELS={}", file.display());
    Ok(compiled)
}

/// Unpacks the kernels that travel with the package.
#[cfg(not(whitted_shaderc))]
fn kernels(_: &Path, _: &[sources::Source], digest: &str) -> Result<Vec<Compiled>, String> {
    let bytes = fs::read(pack::FILE).map_err(|e| format!("{}: {e}", pack::FILE))?;
    let pack = pack::read(&bytes).map_err(|e| format!("{}: {e}", pack::FILE))?;
    if pack.digest == digest {
        return Ok(pack.kernels);
    }
    Err(format!(
        "The kernels' sources (glsl, src/kernel/abi) have changed since {} was made, so it cannot stand for them.\n\
         Run `./whitted.sh setup` once: the build then compiles the sources itself, with shaderc.",
        pack::FILE
    ))
}

/// Compiles the kernels with every planted mistake to choose from.
#[cfg(whitted_shaderc)]
fn planted(sources: &[sources::Source]) -> Result<Vec<Compiled>, String> {
    compile::all(sources, true)
}

/// Planted mistakes are compiled, never packed.
#[cfg(not(whitted_shaderc))]
fn planted(_: &[sources::Source]) -> Result<Vec<Compiled>, String> {
    Err("Tests compile kernels with planted mistakes, which needs shaderc: run `./whitted.sh setup` once."
        .into())
}

fn text_of(path: &Path) -> Result<String, String> {
    fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))
}

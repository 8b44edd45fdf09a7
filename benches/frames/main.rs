//! The project's benchmark: `cargo bench`. Passes and whole renders of fixed scenes, each against a way of
//! doing the same work that needs no baseline kept by hand: every primitive tested instead of the hierarchy,
//! the kernels' twins on the CPU, or (`--against`) the program of another commit. All figures are ratios
//! taken within one run, in turn; times alone mean little on a shared machine.

mod cases;
mod paired;
mod processes;
mod tell;
mod twins;

use anyhow::{Context, Result, bail};
use cases::{CASES, Case, Second};
use clap::Parser;
use std::path::{Path, PathBuf};
use std::process::Command;
use tell::Teller;

/// Times fixed scenes against brute force, the CPU twins, or another commit's program.
#[derive(Parser)]
struct Options {
    /// Only these scenes (cornell, flake, flake2, mesh1k, mesh70k, mesh280k, mesh1m)
    scenes: Vec<String>,
    /// Pairs of runs, after a warm-up of both
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    repeats: u32,
    /// Program to be held against this build, process by process
    #[arg(long, value_name = "PROGRAM")]
    against: Option<PathBuf>,
    /// What `--against` is called in the tables [default: its file name]
    #[arg(long, value_name = "NAME")]
    called: Option<String>,
    /// Write every figure as a line of JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Cargo says so.
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() -> std::process::ExitCode {
    match run(&Options::parse()) {
        Ok(()) => std::process::ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            std::process::ExitCode::FAILURE
        }
    }
}

fn run(options: &Options) -> Result<()> {
    let program = Path::new(env!("CARGO_BIN_EXE_whitted"));
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("bench-scenes");
    let wanted = chosen(&options.scenes, options.against.is_some())?;
    write_scenes(program, &folder, &wanted)?;
    let mut teller = Teller::default();
    match &options.against {
        None => twins::run(&folder, &wanted, options.repeats as usize, &mut teller)?,
        Some(other) => {
            let name = options
                .called
                .clone()
                .unwrap_or_else(|| other.file_name().unwrap_or(other.as_os_str()).to_string_lossy().into());
            processes::run(program, other, &name, &folder, &wanted, options.repeats as usize, &mut teller)?;
        }
    }
    teller.finish(options.json.as_deref())
}

/// The cases of the scenes named; without names those that take little time.
fn chosen(names: &[String], against: bool) -> Result<Vec<&'static Case>> {
    if let Some(unknown) = names.iter().find(|n| !CASES.iter().any(|c| c.scene == **n)) {
        let mut known: Vec<&str> = CASES.iter().map(|c| c.scene).collect();
        known.dedup();
        bail!("there is no scene called {unknown}; take some of {}", known.join(", "));
    }
    let asked = |c: &&Case| if names.is_empty() { c.usual } else { names.iter().any(|n| n == c.scene) };
    // Two programs draw the whole picture; small ones are for slow twins.
    let fits = |c: &&Case| !against || c.second == Second::Nothing;
    Ok(CASES.iter().filter(asked).filter(fits).collect())
}

fn write_scenes(program: &Path, folder: &Path, cases: &[&Case]) -> Result<()> {
    let mut names: Vec<&str> = cases.iter().map(|c| c.scene).collect();
    names.dedup();
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/scenes.sh");
    let status = Command::new("sh").arg(script).arg(program).arg(folder).args(&names).status();
    if !status.with_context(|| format!("cannot run sh {script}"))?.success() {
        bail!("{script} could not write {}", names.join(", "));
    }
    Ok(())
}

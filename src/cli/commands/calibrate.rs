//! `whitted calibrate`.

mod families;

use super::command_line;
use crate::atomic_file;
use crate::cli::args::{CalibrateArgs, Promise};
use crate::cli::console::{Console, print};
use crate::cli::delivery::write_json;
use crate::cli::failure::Failure;
use crate::cli::progress::{self, Progress, Style};
use crate::cli::read;
use crate::lab::calibrate::{Calibration, Plan};
use crate::render::Renderer;
use crate::scene::Scene;
use anyhow::Context;
use std::path::{Path, PathBuf};

/// Where the scenes are if none is named.
const FOLDER: &str = "scenes";

/// Measures how often the promises are kept.
pub fn run(args: &CalibrateArgs, console: &mut Console) -> Result<(), Failure> {
    if !args.families.is_empty() {
        return families::run(args, console);
    }
    let json_file = args.json.iter().filter(|p| p.as_os_str() != "-");
    for path in args.output.iter().chain(json_file) {
        atomic_file::check(path).with_context(|| format!("cannot write {}", path.display()))?;
    }
    let scenes = scenes(args, console)?;
    let plan = plan(args);
    progress::catch_interrupts()?;
    let mut renderer = Renderer::new(&args.device.choice())?;
    let style = Style::choose(console.is_quiet(), console.is_verbose());
    let mut bar = Progress::new(style, "calibrating");
    let mut say = |name: &str| {
        if console.is_verbose() {
            console.say(name);
        }
    };
    let measured = Calibration::measure(&mut renderer, &scenes, &plan, &mut bar, &mut say);
    drop(bar);
    let calibration = measured?;
    let page = calibration.page(&command_line());
    match &args.json {
        Some(path) if path.as_os_str() == "-" => {
            let text =
                serde_json::to_string_pretty(&calibration).context("cannot express the trials as JSON")?;
            print(&(text + "\n"))?;
        }
        Some(path) => write_json(path, &calibration)?,
        None => {}
    }
    match &args.output {
        Some(path) => atomic_file::write(path, |out| out.write_all(page.as_bytes()))
            .with_context(|| format!("cannot write {}", path.display()))?,
        None if args.json.as_deref() == Some(Path::new("-")) => console.say(&page),
        None => print(&page)?,
    }
    match calibration.complete {
        true => Ok(()),
        false => Err(Failure::Interrupted("interrupted: the tables hold the trials finished so far".into())),
    }
}

/// The list of an option, or its default if it is not given; empty if `--only` leaves its promise out.
fn list<T: Clone>(args: &CalibrateArgs, promise: Promise, given: &[T], default: &[T]) -> Vec<T> {
    match args.only.is_empty() || args.only.contains(&promise) {
        false => Vec::new(),
        true if given.is_empty() => default.to_vec(),
        true => given.to_vec(),
    }
}

fn plan(args: &CalibrateArgs) -> Plan {
    Plan {
        width: args.size.width,
        height: args.size.height,
        seeds: args.seeds.unwrap_or(20),
        runs: args.runs,
        samples: list(args, Promise::Budget, &args.samples, &[16, 64]),
        errors: list(args, Promise::Error, &args.errors, &[0.02, 0.01]),
        times: list(args, Promise::Time, &args.times, &[0.5]),
        confidence: args.confidence,
    }
}

/// The scenes named, or all there are.
fn scenes(args: &CalibrateArgs, console: &mut Console) -> Result<Vec<(String, Scene)>, Failure> {
    let mut files = args.scenes.clone();
    if files.is_empty() {
        let entries = std::fs::read_dir(FOLDER).into_iter().flatten().flatten();
        files.extend(entries.map(|e| e.path()).filter(|p| p.extension().is_some_and(|e| e == "toml")));
        files.sort();
    }
    if files.is_empty() {
        return Err(Failure::Usage(format!("no scene given, and none in the folder {FOLDER}")));
    }
    let one = |path: &PathBuf| {
        let name = path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        Ok::<_, Failure>((name, read::scene(path, &args.read, console)?))
    };
    files.iter().map(one).collect()
}

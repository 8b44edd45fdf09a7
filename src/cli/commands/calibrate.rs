//! `whitted calibrate`.

use super::command_line;
use crate::atomic_file;
use crate::cli::args::{CalibrateArgs, Promise};
use crate::cli::console::{Console, print};
use crate::cli::failure::Failure;
use crate::cli::files::Files;
use crate::cli::progress::{self, Progress, Style};
use crate::cli::read;
use crate::lab::calibrate::{CalibrateError, Calibration, Plan, SceneFile, Store, Trials, choose};
use crate::render::{Observer, Renderer};
use anyhow::Context;
use std::path::Path;

/// Where the scenes are if none is named.
const FOLDER: &str = "scenes";

/// Measures how often the promises are kept.
pub fn run(args: &CalibrateArgs, console: &mut Console) -> Result<(), Failure> {
    let plan = plan(args, console)?;
    if let Some(folder) = &args.keep {
        keep(&plan, folder)?;
        if args.output.is_none() {
            return Ok(());
        }
    }
    let records = args.output.as_ref().map(|output| output.with_extension("jsonl"));
    if records.is_some() && records == args.output {
        return Err(Failure::Usage("-o names the tables: FILE.md; the records go to FILE.jsonl".into()));
    }
    // Records of an earlier run are read as well, by the same name.
    let files = Files::new()
        .writes("-o", args.output.as_deref())
        .writes("--page", args.page.as_deref())
        .writes("the records", records.as_deref());
    plan.files.iter().fold(files, |files, file| files.reads_scene(&file.scene)).check()?;
    progress::catch_interrupts()?;
    let mut renderer = Renderer::new(&args.device.choice())?;
    let header = plan.header(&renderer);
    let mut store = match &records {
        Some(records) => Store::open(records, &header).map_err(anyhow::Error::from)?,
        None => Store::default(),
    };
    let style = Style::choose(console.is_quiet(), console.is_verbose());
    let mut begin = |place: usize, of: usize, name: &str| -> Box<dyn Observer> {
        Box::new(Progress::new(style, &format!("scene {place} of {of}: {name}")))
    };
    let measured = plan.measure(&mut renderer, &mut store, &mut begin);
    // What is there is worth its tables, whatever ended the work.
    let calibration = plan.collect(header, &store);
    write(args, &calibration)?;
    match measured {
        Ok(()) if calibration.is_complete() => Ok(()),
        Ok(()) => Err(Failure::Interrupted(format!(
            "interrupted after {} of {} scenes{}",
            calibration.scenes.len(),
            plan.list().len(),
            if records.is_some() { "; the same command continues" } else { "" }
        ))),
        Err(CalibrateError::Scene(error)) => Err(error.into()),
        Err(CalibrateError::Render(error)) => Err(error.into()),
        Err(error @ CalibrateError::Store(_)) => Err(anyhow::Error::from(error).into()),
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

fn plan(args: &CalibrateArgs, console: &mut Console) -> Result<Plan, Failure> {
    let families = choose(&args.families).map_err(|why| Failure::Usage(format!("--families: {why}")))?;
    let times: &[f64] = if args.only.contains(&Promise::Time) { &[0.5] } else { &[] };
    let trials = Trials {
        seed: args.seed,
        width: args.size.width,
        height: args.size.height,
        seeds: args.seeds,
        samples: list(args, Promise::Budget, &args.samples, &[4, 16, 64]),
        errors: list(args, Promise::Error, &args.errors, &[0.01, 0.003]),
        times: list(args, Promise::Time, &args.times, times),
        confidence: args.confidence,
        truth_rays: args.truth_rays,
    };
    Ok(Plan { files: files(args, console)?, families, scenes: args.draws, trials })
}

/// The scenes named; all of the folder if nothing is asked for.
fn files(args: &CalibrateArgs, console: &mut Console) -> Result<Vec<SceneFile>, Failure> {
    let mut paths = args.scenes.clone();
    if paths.is_empty() && args.families.is_empty() {
        let entries = std::fs::read_dir(FOLDER).into_iter().flatten().flatten();
        paths.extend(entries.map(|e| e.path()).filter(|p| p.extension().is_some_and(|e| e == "toml")));
        paths.sort();
        if paths.is_empty() {
            return Err(Failure::Usage(format!("no scene given, and none in the folder {FOLDER}")));
        }
    }
    let mut files: Vec<SceneFile> = Vec::new();
    for path in &paths {
        let name = path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        if files.iter().any(|file| file.name == name) {
            let why = format!("two scenes are called `{name}`: tables could not tell them apart");
            return Err(Failure::Usage(why));
        }
        files.push(SceneFile { name, scene: read::scene(path, &args.read, None, console)? });
    }
    Ok(files)
}

/// Writes the plan's drawn scenes to `folder`, which is created if it is missing.
fn keep(plan: &Plan, folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).with_context(|| format!("cannot create {}", folder.display()))?;
    for (family, number) in plan.drawn() {
        let text = family.text(number, plan.trials.seed, [plan.trials.width, plan.trials.height]);
        let path = folder.join(family.file(number));
        put(&path, &text)?;
    }
    Ok(())
}

fn put(path: &Path, text: &str) -> Result<(), Failure> {
    atomic_file::write(path, |out| out.write_all(text.as_bytes()))
        .with_context(|| format!("cannot write {}", path.display()))?;
    Ok(())
}

fn write(args: &CalibrateArgs, calibration: &Calibration) -> Result<(), Failure> {
    let command = command_line();
    match &args.output {
        Some(output) => put(output, &calibration.markdown(&command))?,
        None => print(&calibration.markdown(&command))?,
    }
    if let Some(page) = &args.page {
        let text =
            calibration.html(&command).map_err(|why| anyhow::anyhow!("cannot draw the plots: {why}"))?;
        put(page, &text)?;
    }
    Ok(())
}

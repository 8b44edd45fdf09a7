//! `whitted calibrate --families`.

use super::list;
use crate::atomic_file;
use crate::cli::args::{CalibrateArgs, Promise};
use crate::cli::commands::command_line;
use crate::cli::console::Console;
use crate::cli::failure::Failure;
use crate::cli::files::Files;
use crate::cli::progress::{self, Progress, Style};
use crate::lab::calibrate::families::{FamilyCalibration, FamilyError, FamilyPlan, Store, Trials, choose};
use crate::render::{Observer, Renderer};
use anyhow::Context;
use std::path::Path;

/// Measures scenes drawn from families.
pub fn run(args: &CalibrateArgs, console: &mut Console) -> Result<(), Failure> {
    let plan = plan(args)?;
    files(args).check()?;
    if let Some(folder) = &args.keep {
        keep(&plan, folder)?;
    }
    let Some(output) = &args.output else {
        return match &args.keep {
            Some(_) => Ok(()),
            None => Err(Failure::Usage(
                "--families writes records while it runs: name the tables with -o FILE.md".into(),
            )),
        };
    };
    let records = output.with_extension("jsonl");
    if records == *output {
        return Err(Failure::Usage("-o names the tables: FILE.md; the records go to FILE.jsonl".into()));
    }
    progress::catch_interrupts()?;
    let mut renderer = Renderer::new(&args.device.choice())?;
    let header = plan.header(&renderer);
    let mut store = Store::open(&records, &header).map_err(anyhow::Error::from)?;
    let style = Style::choose(console.is_quiet(), console.is_verbose());
    let mut begin = |place: usize, of: usize, name: &str| -> Box<dyn Observer> {
        Box::new(Progress::new(style, &format!("scene {place} of {of}: {name}")))
    };
    let measured = plan.measure(&mut renderer, &mut store, &mut begin);
    // What is there is worth its tables, whatever ended the work.
    let calibration = plan.collect(header, &store);
    write(args, output, &calibration)?;
    match measured {
        Ok(()) if calibration.is_complete() => Ok(()),
        Ok(()) => Err(Failure::Interrupted(format!(
            "interrupted after {} of {} scenes; the same command continues",
            calibration.scenes.len(),
            plan.list().len()
        ))),
        Err(FamilyError::Scene(error)) => Err(error.into()),
        Err(FamilyError::Render(error)) => Err(error.into()),
        Err(error @ FamilyError::Store(_)) => Err(anyhow::Error::from(error).into()),
    }
}

/// The files it writes; records of an earlier run are read as well, by the same name.
fn files(args: &CalibrateArgs) -> Files {
    let files = Files::new().writes("-o", args.output.as_deref()).writes("--page", args.page.as_deref());
    let records = args.output.iter().map(|output| output.with_extension("jsonl"));
    records.fold(files, |files, records| files.writes("the records", Some(&records)))
}

fn plan(args: &CalibrateArgs) -> Result<FamilyPlan, Failure> {
    let families = choose(&args.families).map_err(|why| Failure::Usage(format!("--families: {why}")))?;
    let trials = Trials {
        seed: args.seed,
        width: args.size.width,
        height: args.size.height,
        seeds: args.seeds.unwrap_or(4),
        samples: list(args, Promise::Budget, &args.samples, &[4, 16, 64]),
        errors: list(args, Promise::Error, &args.errors, &[0.01, 0.003]),
        times: list(args, Promise::Time, &args.times, &[]),
        confidence: args.confidence,
        truth_rays: args.truth_rays,
    };
    Ok(FamilyPlan { families, scenes: args.draws, trials })
}

/// Writes the plan's scenes to `folder`, which is created if it is missing.
fn keep(plan: &FamilyPlan, folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).with_context(|| format!("cannot create {}", folder.display()))?;
    for (family, number) in plan.list() {
        let text = family.text(number, plan.trials.seed, [plan.trials.width, plan.trials.height]);
        let path = folder.join(family.file(number));
        atomic_file::write(&path, |out| out.write_all(text.as_bytes()))
            .with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(())
}

fn write(args: &CalibrateArgs, output: &Path, calibration: &FamilyCalibration) -> Result<(), Failure> {
    let command = command_line();
    let put = |path: &Path, text: String| {
        atomic_file::write(path, |out| out.write_all(text.as_bytes()))
            .with_context(|| format!("cannot write {}", path.display()))
    };
    put(output, calibration.markdown(&command))?;
    if let Some(page) = &args.page {
        let text =
            calibration.html(&command).map_err(|why| anyhow::anyhow!("cannot draw the plots: {why}"))?;
        put(page, text)?;
    }
    Ok(())
}

//! `whitted render`.

use super::bounded_image;
use super::plan;
use super::reference::{Reference, compared};
use crate::cli::args::{Output, RenderArgs};
use crate::cli::console::Console;
use crate::cli::delivery::{Deliver, settings, validated, writable};
use crate::cli::failure::Failure;
use crate::cli::progress::{self, Progress, Style};
use crate::cli::read;
use crate::cli::state::StateFile;
use crate::image::{Bits, Format};
use crate::lab::receipt::{ReceiptError, measure};
use crate::render::{Renderer, ResumeState, Tiles};
use crate::report::Report;
use crate::report::explain::ExplainedPlan;
use crate::report::receipt;
use std::io::{self, IsTerminal};
use std::time::Instant;

/// Renders one image.
pub fn run(args: &RenderArgs, started: Instant, console: &mut Console) -> Result<(), Failure> {
    let format = check(args)?;
    let state = state_file(args);
    if bounded_image::is_wanted(args) {
        return bounded_image::run(args, format, state, started, console);
    }
    let earlier = match &state {
        Some(state) => state.earlier(args.resume, console)?,
        None => None,
    };
    let before = earlier.as_ref().map_or(0.0, |earlier| earlier.time.wall);
    let scene = read::scene(&args.scene, &args.read, console)?;
    let mut settings = settings(&args.picture, &args.schedule, &scene)?;
    bounded_image::set_replicates(args, &mut settings)?;
    let reference = Reference::of(args, &settings)?;
    progress::catch_interrupts()?;
    let mut renderer = Renderer::open(&args.device.choice(), args.validate)?;
    let style = Style::choose(console.is_quiet(), console.is_verbose());
    let mut prepared = renderer.prepare(&scene, &settings)?;
    let outline = match args.receipt {
        true => {
            let time = plan::trial(&mut prepared, &mut Progress::new(style, "trial"))?;
            let outline = prepared.explain(&args.scene.display().to_string());
            Some(ExplainedPlan { time: Some(time), ..outline })
        }
        false => None,
    };
    let mut progress = Progress::new(style, "rendering");
    let (rendered, reference) = compared(reference.as_ref(), &mut progress, |observer| match earlier {
        Some(earlier) => prepared.resume(earlier, observer),
        None => prepared.render_with(observer),
    });
    drop(progress);
    let mut rendered = rendered.map_err(|error| match &state {
        Some(state) => state.explain(error),
        None => error.into(),
    })?;
    rendered.report.reference = reference;
    let (done, unfinished) = (rendered.done, rendered.unfinished.take());
    let mut wrong = Vec::new();
    if let Some(outline) = outline.filter(|_| done == 1.0) {
        let mut say = |what: &str| console.say(&format!("receipt: measuring {what}"));
        let receipt = measure(
            &mut renderer,
            &scene,
            &mut prepared,
            outline,
            &rendered.report,
            &mut say,
            &progress::interrupted,
        );
        match receipt {
            Ok(receipt) => {
                wrong = receipt.wrong();
                rendered.report.receipt = Some(receipt);
            }
            Err(ReceiptError::Interrupted) => console.say("interrupted: no receipt"),
            Err(ReceiptError::Render(error)) => return Err(error.into()),
        }
    }
    let report = Deliver { args, format, layers: &[], before }.deliver(rendered, started, console)?;
    if done < 1.0 {
        return Err(interrupted(&report, done, unfinished, state)?);
    }
    if let Some(receipt) = &report.receipt {
        console.say(&receipt::text(receipt));
    }
    if !wrong.is_empty() {
        return Err(Failure::Other(anyhow::anyhow!(
            "the image changes with {} switched on, which is a bug: please report it",
            wrong.join(", ")
        )));
    }
    if let Some(state) = state.filter(|_| args.resume) {
        state.remove()?;
    }
    validated(&renderer.validation_messages(), console)?;
    match report.counters.lost() {
        Some(why) => Err(Failure::Unsound(format!("{why}; it is in {}", report.image.file))),
        None => Ok(()),
    }
}

/// The state file of an interrupted render; none for standard output.
fn state_file(args: &RenderArgs) -> Option<StateFile> {
    match &args.output {
        Output::Stdout => None,
        Output::File(path, _) => Some(StateFile::of(path)),
    }
}

/// Checks, before the work starts, the image's format and that the files can be written.
fn check(args: &RenderArgs) -> Result<Format, Failure> {
    let format = match &args.output {
        Output::Stdout if io::stdout().is_terminal() => {
            return Err(Failure::Usage(
                "-o - would write a PNG to the terminal: redirect standard output or name a file".into(),
            ));
        }
        Output::Stdout if args.resume => {
            return Err(Failure::Usage(
                "--resume needs an image file, but -o - writes to standard output".into(),
            ));
        }
        Output::Stdout => Format::Png(Bits::Eight),
        Output::File(path, format) => {
            writable(path)?;
            *format
        }
    };
    bounded_image::check(args)?;
    if let Some(path) = &args.report {
        writable(path)?;
        if matches!(&args.output, Output::File(image, _) if image == path) {
            return Err(Failure::Usage("--report and --output name the same file".into()));
        }
    }
    if let Some(path) = &args.page {
        writable(path)?;
        if args.report.as_ref() == Some(path) {
            return Err(Failure::Usage("--report and --page name the same file".into()));
        }
    }
    match (args.bits.as_deref(), format) {
        (Some("16"), Format::Png(_)) => Ok(Format::Png(Bits::Sixteen)),
        (Some(_), Format::Exr | Format::Hdr) => Err(Failure::Usage("--bits applies to PNG only".into())),
        _ => Ok(format),
    }
}

/// Stores finished tiles for `--resume` and describes the progress.
fn interrupted(
    report: &Report,
    done: f64,
    unfinished: Option<ResumeState<Tiles>>,
    state: Option<StateFile>,
) -> Result<Failure, Failure> {
    let then = match (state, unfinished) {
        (Some(file), Some(unfinished)) => file.save(unfinished, report)?,
        _ => "it cannot be resumed, since no tile is finished".into(),
    };
    Ok(Failure::Interrupted(format!(
        "interrupted: {:.1} % of the work is done, the image so far is in {}; {then}",
        100.0 * done,
        report.image.file
    )))
}

#[cfg(test)]
mod tests;

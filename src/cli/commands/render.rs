//! `whitted render`.

use super::bounded_image;
use super::plan;
use crate::cli::args::{Output, RenderArgs};
use crate::cli::console::Console;
use crate::cli::delivery::{Deliver, settings, validated, writable};
use crate::cli::failure::Failure;
use crate::cli::progress::{self, Progress, Style};
use crate::cli::state::StateFile;
use crate::image::{Bits, Format};
use crate::lab::receipt::{ReceiptError, measure};
use crate::render::{Renderer, Unfinished};
use crate::report::Report;
use crate::report::receipt;
use crate::scene::Scene;
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
        Some(state) => state.earlier(args.resume, Unfinished::read, console)?,
        None => None,
    };
    let before = earlier.as_ref().map_or(0.0, |earlier| earlier.time.wall);
    let scene = Scene::load(&args.scene)?;
    let mut settings = settings(&args.picture, &args.schedule, &scene)?;
    bounded_image::set_replicates(args, &mut settings)?;
    progress::catch_interrupts()?;
    let mut renderer = Renderer::open(&args.device.choice(), args.validate)?;
    let style = Style::choose(console.is_quiet(), console.is_verbose());
    let outline = match args.receipt {
        true => Some(plan::before(&mut renderer, &args.scene, &scene, &settings, style)?),
        false => None,
    };
    let mut progress = Progress::new(style, "rendering");
    let rendered = match earlier {
        Some(earlier) => renderer.resume(&scene, &settings, earlier, &mut progress),
        None => renderer.render_with(&scene, &settings, &mut progress),
    };
    drop(progress);
    let mut rendered = rendered.map_err(|error| match &state {
        Some(state) => state.explain(error),
        None => error.into(),
    })?;
    let (done, unfinished) = (rendered.done, rendered.unfinished.take());
    let mut wrong = Vec::new();
    if let Some(outline) = outline.filter(|_| done == 1.0) {
        let mut progress = Progress::new(style, "measuring what is absent");
        let receipt = measure(&mut renderer, &scene, &settings, outline, &rendered.report, &mut progress);
        match receipt {
            Ok(receipt) => {
                wrong = receipt.wrong();
                rendered.report.receipt = Some(receipt);
            }
            Err(ReceiptError::Interrupted) => console.say("interrupted: there is no receipt"),
            Err(ReceiptError::Render(error)) => return Err(error.into()),
        }
    }
    let report = Deliver { args, format, channels: &[], before }.deliver(rendered, started, console)?;
    if done < 1.0 {
        return Err(interrupted(&report, done, unfinished, state)?);
    }
    if let Some(receipt) = &report.receipt {
        console.say(&receipt::text(receipt));
    }
    if !wrong.is_empty() {
        return Err(Failure::Other(anyhow::anyhow!(
            "the image differs from that of general kernels with {}: please report this",
            wrong.join(", ")
        )));
    }
    if let Some(state) = state.filter(|_| args.resume) {
        state.remove()?;
    }
    validated(&renderer.validation_messages(), console)
}

/// Where an interrupted render is kept; nowhere for standard output.
fn state_file(args: &RenderArgs) -> Option<StateFile> {
    match &args.output {
        Output::Stdout => None,
        Output::File(path, _) => Some(StateFile::of(path)),
    }
}

/// Checks what can be checked before the work: the image's format, and that the files can be written.
fn check(args: &RenderArgs) -> Result<Format, Failure> {
    let format = match &args.output {
        Output::Stdout if io::stdout().is_terminal() => {
            return Err(Failure::Usage("-o - would write a PNG to the terminal: redirect or pipe it".into()));
        }
        Output::Stdout if args.resume => {
            return Err(Failure::Usage("--resume needs an image file; -o - keeps no state".into()));
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
    match (args.bits.as_deref(), format) {
        (Some("16"), Format::Png(_)) => Ok(Format::Png(Bits::Sixteen)),
        (Some(_), Format::Exr | Format::Hdr) => {
            Err(Failure::Usage("--bits is for PNG; EXR and HDR have their own precision".into()))
        }
        _ => Ok(format),
    }
}

/// Keeps what is finished for `--resume`, and says how far it is.
fn interrupted(
    report: &Report,
    done: f64,
    unfinished: Option<Unfinished>,
    state: Option<StateFile>,
) -> Result<Failure, Failure> {
    let then = match (state, unfinished) {
        (Some(state), Some(mut unfinished)) => {
            unfinished.time = report.time.clone();
            state.save(|out| unfinished.write(out))?;
            format!("go on with --resume (from {})", state.path().display())
        }
        _ => "nothing is kept to resume from, as no tile is finished".into(),
    };
    Ok(Failure::Interrupted(format!(
        "interrupted: {:.1} % of the work is done and saved in {}; {then}",
        100.0 * done,
        report.image.file
    )))
}

#[cfg(test)]
mod tests;

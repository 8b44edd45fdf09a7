//! `whitted render`.

use super::bounded_image;
use super::plan;
use super::reference::{Reference, compared};
use crate::cli::args::{Output, RenderArgs};
use crate::cli::console::Console;
use crate::cli::delivery::{Deliver, render_settings, validated, writable};
use crate::cli::failure::Failure;
use crate::cli::progress::{self, Progress, Style};
use crate::cli::state::{Keeper, KeptState, StateFile};
use crate::image::{Bits, Format};
use crate::lab::receipt::{ReceiptError, measure};
use crate::render::Renderer;
use crate::report::Report;
use crate::report::explain::ExplainedPlan;
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
    let mut earlier = match &state {
        Some(state) => state.earlier(args.resume, console)?,
        None => None,
    };
    let kept = kept_state(args);
    let more = args.more && earlier.is_none();
    if let Some(kept) = kept.as_ref().filter(|_| more) {
        earlier = Some(kept.read()?);
    }
    let before = earlier.as_ref().map_or(0.0, |earlier| earlier.time.wall);
    let scene = Scene::load(&args.scene)?;
    let mut settings = render_settings(args, &scene)?;
    bounded_image::set_replicates(args, &mut settings)?;
    settings.schedule.share = args.share.unwrap_or_default();
    let reference = Reference::of(args, &settings)?;
    progress::catch_interrupts()?;
    let mut renderer = Renderer::open(&args.device.choice(), args.validate)?;
    let style = style(args, console);
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
    let (rendered, reference) = compared(reference.as_ref(), &mut progress, |observer| {
        let keeper = &mut Keeper::new(observer, state.as_ref(), args.checkpoint);
        match earlier {
            Some(earlier) if more => prepared.more(earlier, keeper),
            Some(earlier) => prepared.resume(earlier, keeper),
            None => prepared.render_with(keeper),
        }
    });
    drop(progress);
    let mut rendered = rendered.map_err(|error| match (&state, &kept) {
        (_, Some(kept)) if more => kept.explain(error),
        (Some(state), _) => state.explain(error),
        (None, _) => error.into(),
    })?;
    rendered.report.reference = reference;
    let done = rendered.done;
    let wall = before + started.elapsed().as_secs_f64();
    rendered.report.time.wall = wall;
    if let Some(state) = &mut rendered.state {
        state.time.wall = wall;
    }
    // First what costs most to get again.
    let then = match (&state, rendered.state.take_if(|_| done < 1.0)) {
        (Some(file), Some(unfinished)) => file.save(unfinished, &rendered.report)?,
        _ => "it cannot be resumed".to_owned(),
    };
    if let (Some(kept), Some(state)) = (&kept, rendered.state.as_ref().filter(|_| args.share.is_none())) {
        kept.write(state)?;
    }
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
        return Err(interrupted(args, &report, done, &then));
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
    if let Some(state) = &state {
        state.remove()?;
    }
    validated(&renderer.validation_messages(), console)?;
    match report.counters.lost() {
        Some(why) => Err(Failure::Unsound(format!("{why}; it is in {}", report.image.file))),
        None => Ok(()),
    }
}

/// How progress is shown: as asked for, or as it suits.
pub(super) fn style(args: &RenderArgs, console: &Console) -> Style {
    args.progress.unwrap_or_else(|| Style::choose(console.is_quiet(), console.is_verbose()))
}

/// The state file of an interrupted render; none for standard output.
fn state_file(args: &RenderArgs) -> Option<StateFile> {
    match &args.output {
        Output::Stdout => None,
        Output::File(path, _) | Output::Share(path) => Some(StateFile::of(path, args.resume)),
    }
}

/// The state of the finished image, where it is to be read or written.
fn kept_state(args: &RenderArgs) -> Option<KeptState> {
    match &args.output {
        Output::File(path, _) => (args.more || args.keep_state).then(|| KeptState::of(path)),
        Output::Share(path) => args.more.then(|| KeptState::share(path)),
        Output::Stdout => None,
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
        Output::Stdout if args.progress == Some(Style::OpenJd) => {
            return Err(Failure::Usage("--progress openjd and -o - both write to standard output".into()));
        }
        Output::Stdout if args.resume || args.more || args.keep_state => {
            return Err(Failure::Usage(
                "--resume, --continue and --keep-state need an image file, but -o - writes to standard output"
                    .into(),
            ));
        }
        Output::Share(_) if args.share.is_none() => {
            return Err(Failure::Usage("a file .share is written with --share I/N only".into()));
        }
        Output::Stdout | Output::File(..) if args.share.is_some() => {
            return Err(Failure::Usage(
                "--share writes no image but a share: name the file .share, and join all shares with `whitted merge`"
                    .into(),
            ));
        }
        // Not used: a share is no image.
        Output::Share(path) => {
            writable(path)?;
            Format::Exr
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

/// Describes the progress, and how to go on.
fn interrupted(args: &RenderArgs, report: &Report, done: f64, then: &str) -> Failure {
    let so_far = match &args.output {
        Output::Share(_) => String::new(),
        _ => format!(" the image so far is in {};", report.image.file),
    };
    Failure::Interrupted(format!("interrupted: {:.1} % of the work is done,{so_far} {then}", 100.0 * done))
}

#[cfg(test)]
mod tests;

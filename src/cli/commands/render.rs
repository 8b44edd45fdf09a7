//! `whitted render`.

use super::plan;
use super::reference::{Reference, compared};
use super::{bounded_image, frames};
use crate::cli::args::{Output, RenderArgs};
use crate::cli::console::Console;
use crate::cli::delivery::{
    Deliver, Delivered, files, fits_host, remove_unfinished, render_settings, up, validated, variables,
};
use crate::cli::failure::Failure;
use crate::cli::progress::{self, Progress, Style};
use crate::cli::read;
use crate::cli::state::{KeptState, StateFile, checkpoints};
use crate::cli::surfaces::{self, FirstSurfaces};
use crate::image::{Bits, Format};
use crate::lab::receipt::{ReceiptError, measure};
use crate::render::Renderer;
use crate::report::Report;
use crate::report::explain::ExplainedPlan;
use crate::report::receipt;
use std::io::{self, IsTerminal};
use std::time::Instant;

/// Renders one image, or one for each frame.
pub fn run(args: &RenderArgs, started: Instant, console: &mut Console) -> Result<(), Failure> {
    match args.frames.list().as_slice() {
        [] if args.frames.skip_existing => {
            Err(Failure::Usage("--skip-existing needs --frames, or --frame".into()))
        }
        [] => picture(args, &mut Device::default(), started, console),
        list => frames::run(args, list, started, console),
    }
}

/// The device, opened when the first picture needs it.
#[derive(Default)]
pub(super) struct Device(Option<Renderer>);

impl Device {
    /// The renderer; from now on Ctrl-C asks it to stop.
    pub(super) fn open(&mut self, args: &RenderArgs) -> Result<&mut Renderer, Failure> {
        let renderer = match self.0.take() {
            Some(renderer) => renderer,
            None => {
                progress::catch_interrupts()?;
                Renderer::open(&args.device.choice(), args.validate)?
            }
        };
        Ok(self.0.insert(renderer))
    }
}

/// Renders one image.
pub(super) fn picture(
    args: &RenderArgs,
    device: &mut Device,
    started: Instant,
    console: &mut Console,
) -> Result<(), Failure> {
    let state = state_file(args);
    let format = check(args, state.as_ref())?;
    if bounded_image::is_wanted(args) {
        return bounded_image::run(args, format, state, device, started, console);
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
    let scene = read::scene(&args.scene, &args.read, args.picture.size, console)?;
    files(args, state.as_ref()).reads_scene(&scene).check()?;
    let mut settings = render_settings(args, &scene)?;
    bounded_image::set_replicates(args, &mut settings)?;
    fits_host(args, &settings, format)?;
    settings.schedule.share = args.share.unwrap_or_default();
    let reference = Reference::of(args, &settings)?;
    let renderer = device.open(args)?;
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
        let keeper = &mut checkpoints(observer, state.as_ref(), args.checkpoint);
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
        state.set_reading(variables(args), up(args));
    }
    let mut wrong = Vec::new();
    if let Some(outline) = outline.filter(|_| done == 1.0) {
        let mut say = |what: &str| console.say(&format!("receipt: measuring {what}"));
        let receipt = measure(
            renderer,
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
    let surfaces = match done == 1.0 {
        true => FirstSurfaces::trace(args, &scene, &rendered.report, renderer, style)?,
        false => None,
    };
    let complete = surfaces.is_some();
    let surfaces = surfaces.unwrap_or_default();
    // A finished share is delivered in place of an image.
    let drawn = rendered.state.take_if(|_| !complete || args.share.is_none());
    let keep = |report: &Report| match (&state, &kept, drawn) {
        (Some(file), _, Some(unfinished)) if !complete => file.save(unfinished, report).map(Some),
        (_, Some(kept), Some(finished)) if complete => kept.write(&finished).map(|()| None),
        _ => Ok(None),
    };
    let fault = rendered.fault();
    let deliver = Deliver { args, format, layers: &[], surfaces: &surfaces, before, complete };
    let Delivered { report, kept: said } = deliver.deliver(rendered, started, keep, console)?;
    if !complete {
        return Err(interrupted(args, &report, done, said));
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
        remove_unfinished(args, state)?;
    }
    validated(&renderer.validation_messages(), console)?;
    match fault {
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
fn check(args: &RenderArgs, state: Option<&StateFile>) -> Result<Format, Failure> {
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
        Output::Share(_) => Format::Exr,
        Output::Stdout => Format::Png(Bits::Eight),
        Output::File(_, format) => *format,
    };
    bounded_image::check(args)?;
    surfaces::check(args, format)?;
    files(args, state).check()?;
    match (args.bits.as_deref(), format) {
        (None, format) => Ok(format),
        (Some(bits), format) => {
            let bits = if bits == "16" { Bits::Sixteen } else { Bits::Eight };
            format.with_bits(bits).ok_or_else(|| Failure::Usage("--bits applies to PNG and PPM only".into()))
        }
    }
}

/// Describes the progress of an interrupted render; `said` says how it can be continued.
fn interrupted(args: &RenderArgs, report: &Report, done: f64, said: Option<String>) -> Failure {
    let then = said.unwrap_or("it cannot be resumed".into());
    let so_far = match &args.output {
        Output::Share(_) => String::new(),
        _ => format!(" the image so far is in {};", report.image.file),
    };
    Failure::Interrupted(format!("interrupted: {:.1} % of the work is done,{so_far} {then}", 100.0 * done))
}

#[cfg(test)]
mod tests;

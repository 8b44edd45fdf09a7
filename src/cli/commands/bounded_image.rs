//! `whitted render` with `--budget`, `--error`, `--time` or `--aov`: an image with bounded error.

use super::reference::{Reference, compared};
use super::render::{Device, style};
use crate::accuracy::promise::{Layer, Request, Target};
use crate::cli::args::{Output, RenderArgs};
use crate::cli::console::Console;
use crate::cli::delivery::{self, Deliver, Delivered};
use crate::cli::failure::Failure;
use crate::cli::progress::{Progress, Style};
use crate::cli::read;
use crate::cli::state::{StateFile, checkpoints};
use crate::cli::surfaces::FirstSurfaces;
use crate::image::Format;
use crate::render::Rendered;
use crate::report::Report;
use crate::settings::{Precision, Settings};
use crate::units;
use std::time::Instant;

/// True if any option concerns the image's error.
pub(super) fn is_wanted(args: &RenderArgs) -> bool {
    let a = &args.accuracy;
    a.error.is_some() || a.time.is_some() || a.budget || !a.aov.is_empty()
}

/// Sets the replicates of a render without an error estimate.
pub(super) fn set_replicates(args: &RenderArgs, settings: &mut Settings) -> Result<(), Failure> {
    if args.settings_of.is_none() {
        settings.replicates = replicates(args.accuracy.replicates, settings.samples)?;
    }
    Ok(())
}

/// The request in the arguments; also sets the replicates of `settings`.
fn request(
    args: &RenderArgs,
    format: Format,
    settings: &mut Settings,
    started: Instant,
) -> Result<Request, Failure> {
    let a = &args.accuracy;
    let target = match (a.error, a.time) {
        (Some(error), _) => Target::Error(error),
        (_, Some(seconds)) => Target::Time { seconds, from: started, layers: painted(args) },
        _ => Target::Settings,
    };
    if target == Target::Settings {
        if settings.samples < 2 {
            return Err(Failure::Usage(
                "the error of one sample per pixel cannot be estimated: use --samples 2 or more, or --error"
                    .into(),
            ));
        }
        set_replicates(args, settings)?;
    }
    Ok(Request {
        target,
        confidence: a.confidence,
        keep_depth: args.picture.depth.is_some(),
        keep_precision: args.picture.precision.is_some_and(|p| p != Precision::Auto),
        file: Some(format),
        keep_bits: args.bits.is_some(),
    })
}

/// Pictures to write besides the image: layers, and all of them again on a page.
fn painted(args: &RenderArgs) -> u32 {
    let layers = args.accuracy.aov.len() as u32;
    if args.page.is_some() { 2 * layers + 1 } else { layers }
}

/// The number asked for, or 1.
fn replicates(asked: Option<u32>, samples: u32) -> Result<u32, Failure> {
    match asked {
        Some(r) if samples.is_multiple_of(r) => Ok(r),
        Some(r) => Err(Failure::Usage(format!("--replicates {r} does not divide --samples {samples}"))),
        None => Ok(1),
    }
}

/// Renders and delivers.
pub(super) fn run(
    args: &RenderArgs,
    format: Format,
    state: Option<StateFile>,
    device: &mut Device,
    started: Instant,
    console: &mut Console,
) -> Result<(), Failure> {
    let earlier = match &state {
        Some(state) => state.earlier(args.resume, console)?,
        None => None,
    };
    let before = earlier.as_ref().map_or(0.0, |earlier| earlier.time.wall);
    let scene = read::scene(&args.scene, &args.read, args.picture.size, console)?;
    delivery::files(args, state.as_ref()).reads_scene(&scene).check()?;
    let mut settings = delivery::render_settings(args, &scene)?;
    let request = request(args, format, &mut settings, started)?;
    delivery::fits_host(args, &settings, format)?;
    let reference = Reference::of(args, &settings)?;
    let renderer = device.open(args)?;
    let label = match request.target {
        Target::Settings => "rendering".to_owned(),
        Target::Error(error) => format!("rendering to an error of {}", units::number(error)),
        Target::Time { seconds, .. } => format!("rendering for {}", units::seconds(seconds)),
    };
    let mut progress = Progress::new(style(args, console), &label);
    let (known, reference) = compared(reference.as_ref(), &mut progress, |observer| {
        let keeper = &mut checkpoints(observer, state.as_ref(), args.checkpoint);
        match earlier {
            Some(earlier) => renderer.resume_bounded(&scene, &settings, &request, earlier, keeper),
            None => renderer.render_bounded_with(&scene, &settings, &request, keeper),
        }
    });
    drop(progress);
    let mut known = known.map_err(|error| match &state {
        Some(state) => state.explain(error),
        None => error.into(),
    })?;
    known.report.reference = reference;
    if args.accuracy.aov.contains(&Layer::Tests) && !known.cancelled {
        let style = Style::choose(console.is_quiet(), console.is_verbose());
        let mut progress = Progress::new(style, "counting tests");
        known.tests = renderer.tests_per_pixel(&scene, &settings, &mut progress)?;
    }
    let format = known.file.unwrap_or(format);
    let layers: Vec<(Layer, Vec<f64>)> = args.accuracy.aov.iter().map(|l| (*l, known.layer(*l))).collect();
    let (cancelled, unfinished) = (known.cancelled, known.unfinished.take());
    let rendered = Rendered {
        width: known.samples.width,
        height: known.height,
        linear: known.linear(),
        done: known.done,
        report: known.report,
        state: None,
    };
    let keep = |report: &Report| match (&state, unfinished) {
        (Some(file), Some(unfinished)) if cancelled => file.save(unfinished, report).map(Some),
        _ => Ok(None),
    };
    let surfaces = match cancelled {
        true => None,
        false => FirstSurfaces::trace(args, &scene, &rendered.report, renderer, style(args, console))?,
    };
    let complete = surfaces.is_some();
    let surfaces = surfaces.unwrap_or_default();
    let deliver = Deliver { args, format, layers: &layers, surfaces: &surfaces, before, complete };
    let Delivered { report, kept } = deliver.deliver(rendered, started, keep, console)?;
    let file = &report.image.file;
    delivery::validated(&renderer.validation_messages(), console)?;
    if !complete {
        let then = kept.map_or(String::new(), |kept| format!("; {kept}"));
        return Err(Failure::Interrupted(format!("interrupted: the image so far is in {file}{then}")));
    }
    if let Some(state) = &state {
        delivery::remove_unfinished(args, state)?;
    }
    if let (Some(void), None) = (report.error.as_ref().and_then(|e| e.void.as_ref()), report.asked.met) {
        return Err(Failure::Unmet(format!("{void}; the image is in {file}")));
    }
    match (report.asked.met, &report.asked.unmet_why) {
        (Some(false), why) => {
            Err(Failure::Unmet(format!("{}; the image is in {file}", why.as_deref().unwrap_or_default())))
        }
        _ => Ok(()),
    }
}

/// Checks combinations of options before the work starts.
pub(super) fn check(args: &RenderArgs) -> Result<(), Failure> {
    let a = &args.accuracy;
    if !a.aov.is_empty() && matches!(args.output, Output::Stdout) {
        return Err(Failure::Usage(
            "--aov writes files next to the image, so -o needs a file name instead of -".into(),
        ));
    }
    if !args.layers.is_empty() && matches!(args.output, Output::Stdout) {
        return Err(Failure::Usage(
            "--layers writes files next to the image, so -o needs a file name instead of -".into(),
        ));
    }
    let rounding = a.aov.iter().any(|layer| matches!(layer, Layer::Rounding | Layer::RoundingPaths));
    if rounding && (a.error.is_some() || a.time.is_some()) {
        return Err(Failure::Usage(
            "--aov rounding renders every sample in f64 too: use it with --budget, not with --error or --time".into(),
        ));
    }
    if a.aov.contains(&Layer::Tests) && (a.error.is_some() || a.time.is_some()) {
        return Err(Failure::Usage(
            "--aov tests traces every sample once more to count: use it with --budget, not with --error or --time".into(),
        ));
    }
    if args.picture.precision == Some(Precision::Fast) && a.error.is_some() {
        return Err(Failure::Usage(
            "--precision fast has no error bound; --error needs robust or f64".into(),
        ));
    }
    Ok(())
}

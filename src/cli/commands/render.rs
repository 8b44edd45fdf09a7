//! `whitted render`.

use super::bounded_image;
use super::{load, plan};
use crate::atomic_file;
use crate::cli::args::{Crop, Output, PictureArgs, RenderArgs, ScheduleArgs, Size};
use crate::cli::console::Console;
use crate::cli::failure::Failure;
use crate::cli::progress::{self, Progress, Style};
use crate::cli::state::StateFile;
use crate::image::{Bits, Format, Metadata, View, linear_sha256};
use crate::lab::receipt::{self, Receipt, ReceiptError};
use crate::render::{Rendered, Renderer, Unfinished};
use crate::report::Report;
use crate::report::table;
use crate::scene::Scene;
use crate::settings::Settings;
use anyhow::Context;
use std::io::{self, BufWriter, IsTerminal, Write};
use std::path::{Path, PathBuf};
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
    let (scene, scene_seconds) = load(&args.scene)?;
    let mut settings = settings(&args.picture, &args.schedule, &scene)?;
    bounded_image::set_replicates(args, &mut settings)?;
    progress::catch_interrupts()?;
    let mut renderer = Renderer::new(&args.device.choice(), args.validate)?;
    let style = Style::choose(console.is_quiet(), console.is_verbose());
    let outline = match args.receipt {
        true => Some(plan::before(&mut renderer, &args.scene, &scene, &settings, style)?),
        false => None,
    };
    let mut progress = Progress::new(style, "rendering");
    let rendered = renderer.resume(&scene, &settings, earlier, &mut progress);
    drop(progress);
    let mut rendered = rendered.map_err(|error| match &state {
        Some(state) => state.explain(error),
        None => error.into(),
    })?;
    rendered.report.time.scene += scene_seconds;
    let (done, unfinished) = (rendered.done, rendered.unfinished.take());
    let mut wrong = Vec::new();
    if let Some(outline) = outline.filter(|_| done == 1.0) {
        let mut progress = Progress::new(style, "measuring what is absent");
        let receipt =
            Receipt::new(&mut renderer, &scene, &settings, outline, &rendered.report, &mut progress);
        match receipt {
            Ok(receipt) => {
                wrong = receipt.wrong();
                rendered.report.receipt = Some(receipt);
            }
            Err(ReceiptError::Interrupted) => console.say("interrupted: there is no receipt"),
            Err(ReceiptError::Render(error)) => return Err(error.into()),
        }
    }
    let report = Deliver { args, format, channels: &[] }.deliver(rendered, started, console)?;
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

fn writable(path: &Path) -> Result<(), Failure> {
    Ok(atomic_file::check(path).with_context(|| format!("cannot write {}", path.display()))?)
}

/// The scene's settings under those of the command line.
pub(super) fn settings(
    args: &PictureArgs,
    schedule: &ScheduleArgs,
    scene: &Scene,
) -> Result<Settings, Failure> {
    let mut settings = Settings::of(scene);
    if let Some(Size { width, height }) = args.size {
        (settings.width, settings.height) = (width, height);
    }
    settings.samples = args.samples.unwrap_or(settings.samples);
    settings.depth = args.depth.unwrap_or(settings.depth);
    settings.sampler = args.sampler;
    settings.cutoff = args.cutoff;
    settings.seed = args.seed;
    settings.precision = args.precision.unwrap_or_default();
    settings.origin = args.origin;
    if let Some(Crop(crop)) = args.crop {
        let [.., x1, y1] = crop;
        let Settings { width, height, .. } = settings;
        if x1 > width || y1 > height {
            return Err(Failure::Usage(format!(
                "--crop reaches to {x1},{y1}, outside the image of {width}x{height} pixels"
            )));
        }
        settings.crop = Some(crop);
    }
    settings.schedule = schedule.schedule();
    Ok(settings)
}

/// How image and report are delivered.
pub(super) struct Deliver<'a> {
    pub(super) args: &'a RenderArgs,
    pub(super) format: Format,
    /// Numbers beside the colours, for formats that have room.
    pub(super) channels: &'a [(&'a str, Vec<f32>)],
}

impl Deliver<'_> {
    /// Writes image and report, and says so; gives the report.
    pub(super) fn deliver(
        &self,
        mut rendered: Rendered,
        started: Instant,
        console: &mut Console,
    ) -> Result<Report, Failure> {
        if rendered.done == 0.0 {
            return Err(Failure::Interrupted("interrupted before the first pixel; nothing is saved".into()));
        }
        let report = &mut rendered.report;
        report.scene.file = self.args.scene.display().to_string();
        report.image.file = match &self.args.output {
            Output::Stdout => "-".into(),
            Output::File(path, _) => path.display().to_string(),
        };
        report.image.linear_sha256 = linear_sha256(&rendered.linear);
        self.write_image(&rendered)?;
        let report = &mut rendered.report;
        report.time.wall += started.elapsed().as_secs_f64();
        bounded_image::late(report);
        if let Some(path) = &self.args.report {
            write_json(path, report)?;
        }
        if console.is_verbose() {
            console.say(&table::report(report));
        }
        console.say(&table::summary(report));
        for line in table::error(report).iter().chain(&table::warnings(report)) {
            console.say(line);
        }
        Ok(rendered.report)
    }

    fn write_image(&self, rendered: &Rendered) -> Result<(), Failure> {
        let view = View { width: rendered.width, height: rendered.height, linear: &rendered.linear };
        let metadata = Metadata::of(&rendered.report, rendered.done);
        let encode = |out: &mut dyn Write| self.format.encode_with(view, self.channels, &metadata, out);
        Ok(match &self.args.output {
            Output::Stdout => {
                let mut out = BufWriter::new(io::stdout().lock());
                let written = encode(&mut out).and_then(|()| out.flush());
                written.context("cannot write the image to standard output")
            }
            Output::File(path, _) => atomic_file::write(path, |out| encode(out))
                .with_context(|| format!("cannot write {}", path.display())),
        }?)
    }
}

/// Names the pictures of layers.
pub(super) fn say_layers(names: &[PathBuf], console: &mut Console) {
    for name in names {
        console.say(&format!("layer: {}", name.display()));
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

/// Writes `value` as JSON.
pub(super) fn write_json(path: &Path, value: &impl serde::Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(value).context("cannot express the report as JSON")?;
    Ok(atomic_file::write(path, |out| writeln!(out, "{text}"))
        .with_context(|| format!("cannot write {}", path.display()))?)
}

/// Fails if the validation layer had anything to say.
pub(super) fn validated(messages: &[String], console: &mut Console) -> Result<(), Failure> {
    for message in messages {
        console.error(message);
    }
    match messages.len() {
        0 => Ok(()),
        n => Err(Failure::Other(anyhow::anyhow!("{n} messages from the Vulkan validation layer"))),
    }
}

#[cfg(test)]
mod tests;

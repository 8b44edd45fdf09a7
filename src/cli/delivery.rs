//! What the commands that render share: settings from arguments, delivery of image, report and JSON.

use super::args::{Crop, Output, PictureArgs, RenderArgs, ScheduleArgs, Size};
use super::commands::command_line;
use super::console::Console;
use super::failure::Failure;
use crate::accuracy::promise::{self, Layer};
use crate::image::{Format, Metadata, View};
use crate::lab::render_page::{self, RenderPage};
use crate::render::{Rendered, State};
use crate::report::{Report, SettingsInfo, text};
use crate::scene::Scene;
use crate::settings::Settings;
use crate::{atomic_file, units};
use anyhow::Context;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Checks that a file can be written, before the work whose result it gets.
pub(crate) fn writable(path: &Path) -> Result<(), Failure> {
    Ok(atomic_file::check(path).with_context(|| format!("cannot write {}", path.display()))?)
}

/// The scene's settings under those of the command line.
pub(crate) fn settings(
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
                "--crop ends at {x1},{y1}, outside the image of {width}x{height} pixels"
            )));
        }
        settings.crop = Some(crop);
    }
    settings.schedule = schedule.schedule();
    Ok(settings)
}

/// The settings of a render: those of another's plan or report, or of the command line.
pub(crate) fn render_settings(args: &RenderArgs, scene: &Scene) -> Result<Settings, Failure> {
    let Some(path) = &args.settings_of else { return settings(&args.picture, &args.schedule, scene) };
    /// What plans and reports have in common.
    #[derive(serde::Deserialize)]
    struct Chosen {
        settings: SettingsInfo,
    }
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let chosen: Chosen = serde_json::from_str(&text)
        .with_context(|| format!("{} is no plan or report of this program", path.display()))?;
    let of =
        |why: String| Failure::Usage(format!("the settings of {} cannot be used: {why}", path.display()));
    chosen.settings.to_settings(args.schedule.schedule()).map_err(of)
}

/// How image and report are delivered.
pub(crate) struct Deliver<'a> {
    pub(crate) args: &'a RenderArgs,
    pub(crate) format: Format,
    /// Layers, for the page and for formats that can hold them.
    pub(crate) layers: &'a [(Layer, Vec<f64>)],
    /// Wall time of the earlier parts of a resumed render, seconds.
    pub(crate) before: f64,
}

impl Deliver<'_> {
    /// Writes image and report, and says so; gives the report.
    pub(crate) fn deliver(
        &self,
        mut rendered: Rendered,
        started: Instant,
        console: &mut Console,
    ) -> Result<Report, Failure> {
        if rendered.done == 0.0 {
            return Err(Failure::Interrupted(
                "interrupted before the first pixel; nothing was written".into(),
            ));
        }
        let report = &mut rendered.report;
        report.image.file = match &self.args.output {
            Output::Stdout => "-".into(),
            Output::File(path, _) | Output::Share(path) => path.display().to_string(),
        };
        report.time.wall = self.before + started.elapsed().as_secs_f64();
        self.write_image(&rendered)?;
        // The page has no effect on what was rendered, and takes time of its own.
        let clock = |report: &mut Report| {
            report.time.wall = self.before + started.elapsed().as_secs_f64();
            late(report);
        };
        clock(&mut rendered.report);
        if let Some(path) = &self.args.page {
            let view = View { width: rendered.width, height: rendered.height, linear: &rendered.linear };
            let (report, layers) = (&rendered.report, self.layers);
            write_page(
                path,
                &RenderPage {
                    view,
                    done: rendered.done,
                    report,
                    layers,
                    profile: None,
                    command: command_line(),
                },
            )?;
            clock(&mut rendered.report);
        }
        let report = &rendered.report;
        if let Some(path) = &self.args.report {
            write_json(path, report)?;
        }
        if console.is_verbose() {
            console.say(&text::report(report));
        }
        console.say(&text::summary(report));
        for line in text::error(report).iter().chain(&text::reference(report)).chain(&text::warnings(report))
        {
            console.say(line);
        }
        Ok(rendered.report)
    }

    fn write_image(&self, rendered: &Rendered) -> Result<(), Failure> {
        let view = View { width: rendered.width, height: rendered.height, linear: &rendered.linear };
        let metadata = Metadata::of(&rendered.report, rendered.done);
        let metadata = if self.args.record_time { metadata.with_times(&rendered.report) } else { metadata };
        let channels: Vec<(&str, Vec<f32>)> = match self.format {
            Format::Exr => {
                self.layers.iter().map(|(l, v)| (l.name(), v.iter().map(|x| *x as f32).collect())).collect()
            }
            _ => Vec::new(),
        };
        let encode = |out: &mut dyn Write| self.format.encode_with(view, &channels, &metadata, out);
        Ok(match &self.args.output {
            Output::Stdout => {
                let mut out = BufWriter::new(io::stdout().lock());
                let written = encode(&mut out).and_then(|()| out.flush());
                written.context("cannot write the image to standard output")
            }
            Output::File(path, _) => atomic_file::write(path, |out| encode(out))
                .with_context(|| format!("cannot write {}", path.display())),
            Output::Share(path) => match &rendered.state {
                Some(state) if rendered.done == 1.0 => atomic_file::write(path, |out| state.write(out))
                    .with_context(|| format!("cannot write {}", path.display())),
                _ => Ok(()),
            },
        }?)
    }
}

/// Writes the page of a render or profile.
pub(crate) fn write_page(path: &Path, page: &RenderPage<'_>) -> Result<(), Failure> {
    let cannot = || format!("cannot write {}", path.display());
    let text = render_page::page(page).with_context(cannot)?;
    Ok(atomic_file::write(path, |out| out.write_all(text.as_bytes())).with_context(cannot)?)
}

/// Names the pictures of layers.
pub(crate) fn say_layers(names: &[PathBuf], console: &mut Console) {
    for name in names {
        console.say(&format!("layer: {}", name.display()));
    }
}

/// Marks `--time` as not kept if the process took longer.
fn late(report: &mut Report) {
    let asked = &mut report.asked;
    if let (Some(time), Some(true)) = (asked.time, asked.met)
        && report.time.wall > (1.0 + promise::LATE) * time
    {
        asked.met = Some(false);
        asked.unmet_why = Some(format!("the render took {}", units::seconds(report.time.wall)));
    }
}

/// Writes `value` as JSON.
pub(crate) fn write_json(path: &Path, value: &impl serde::Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(value).context("cannot express the report as JSON")?;
    Ok(atomic_file::write(path, |out| writeln!(out, "{text}"))
        .with_context(|| format!("cannot write {}", path.display()))?)
}

/// Prints the messages of the validation layer; fails if there are any.
pub(crate) fn validated(messages: &[String], console: &mut Console) -> Result<(), Failure> {
    for message in messages {
        console.error(message);
    }
    match messages.len() {
        0 => Ok(()),
        n => Err(Failure::Other(anyhow::anyhow!("{n} messages from the Vulkan validation layer"))),
    }
}

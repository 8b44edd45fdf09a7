//! What the commands that render share: settings from arguments, delivery of image, report and JSON.

use super::args::{Crop, Output, PictureArgs, RenderArgs, ScheduleArgs, Size};
use super::commands::command_line;
use super::console::Console;
use super::failure::Failure;
use super::files::Files;
use super::state::{KeptState, StateFile, remove};
use super::surfaces::{self, FirstSurfaces};
use crate::accuracy::promise::{self, Layer};
use crate::image::{Bits, Format, Metadata, More, View, heat};
use crate::lab::render_page::{self, RenderPage};
use crate::plan::host_memory::{self, HostWork, LARGEST_FILE};
use crate::render::{RenderError, Rendered, State};
use crate::report::{Report, SettingsInfo, text};
use crate::scene::{Scene, is_model};
use crate::settings::Settings;
use crate::{atomic_file, units};
use anyhow::Context;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

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

/// Checks, before the device is opened, that the host can hold the image while it is rendered and written.
pub(crate) fn fits_host(args: &RenderArgs, settings: &Settings, format: Format) -> Result<(), Failure> {
    let a = &args.accuracy;
    let bounded = a.error.is_some() || a.time.is_some() || a.budget || !a.aov.is_empty();
    let work = if bounded { HostWork::Bounded } else { HostWork::Image };
    // Codes or channels, and what is encoded of them in a buffer that doubles as it grows.
    let file = match format {
        Format::Png(Bits::Eight) | Format::Ppm(Bits::Eight) => 3 + 6,
        Format::Png(Bits::Sixteen) | Format::Ppm(Bits::Sixteen) => 6 + 12,
        Format::Pfm => 12 + 24,
        Format::Hdr => 12 + 8,
        Format::Exr => LARGEST_FILE,
    };
    // A layer is an f64, and a channel of an EXR or a coloured picture; a page holds a PNG as text; a reference is read
    // as four channels and kept as three.
    let more = 8 * 2 * a.aov.len() as u64
        + 12 * 2 * (args.layers.len() as u64 + u64::from(args.alpha))
        + if args.page.is_some() { 12 } else { 0 }
        + if a.reference.is_some() { 12 + 16 } else { 0 };
    let free = crate::host::memory::free();
    Ok(host_memory::check(settings.region(), work, file + more, free).map_err(RenderError::from)?)
}

/// The variables of the scene's text, for a report.
pub(crate) fn variables(args: &RenderArgs) -> Vec<String> {
    args.read.variables.iter().map(|(name, value)| format!("{name}={value}")).collect()
}

/// What `--up` names, for a report.
pub(crate) fn up(args: &RenderArgs) -> Option<String> {
    args.read.up.map(|axis| axis.name().to_owned())
}

/// How image, layers, page and report are delivered.
pub(crate) struct Deliver<'a> {
    pub(crate) args: &'a RenderArgs,
    pub(crate) format: Format,
    /// Layers, for the page, for formats that can hold them, and as pictures beside others.
    pub(crate) layers: &'a [(Layer, Vec<f64>)],
    /// Alpha and layers of the first surfaces.
    pub(crate) surfaces: &'a FirstSurfaces,
    /// Wall time of the earlier parts of a resumed render, seconds.
    pub(crate) before: f64,
    /// False for an interrupted render: all files then go beside those of a complete one, so that a file under its own
    /// name is always complete.
    pub(crate) complete: bool,
}

/// What was delivered.
pub(crate) struct Delivered {
    pub(crate) report: Report,
    /// What `keep` said of the resume state.
    pub(crate) kept: Option<String>,
}

impl Deliver<'_> {
    /// Saves the resume state by `keep`, then writes image, layers, page and report, and says so. What cannot be written
    /// keeps nothing else from being saved.
    ///
    /// # Errors
    /// The first failure, once all is tried; of an interrupted render only one of its state or image, since page and
    /// report can be made again from the state.
    pub(crate) fn deliver(
        &self,
        mut rendered: Rendered,
        started: Instant,
        keep: impl FnOnce(&Report) -> Result<Option<String>, Failure>,
        console: &mut Console,
    ) -> Result<Delivered, Failure> {
        if rendered.done == 0.0 {
            return Err(Failure::Interrupted(
                "interrupted before the first pixel; nothing was written".into(),
            ));
        }
        let report = &mut rendered.report;
        report.image.file = match &self.args.output {
            Output::Stdout => "-".into(),
            Output::File(path, _) => self.place(path).display().to_string(),
            Output::Share(path) => path.display().to_string(),
        };
        report.scene.variables = variables(self.args);
        report.scene.up = up(self.args);
        report.time.wall = self.before + started.elapsed().as_secs_f64();
        let mut failures = Vec::new();
        let kept = keep(report).unwrap_or_else(|failure| {
            failures.push(failure);
            None
        });
        failures.extend(self.write_image(&rendered).err());
        let names = self.write_layers(&rendered).unwrap_or_else(|failure| {
            failures.push(failure);
            Vec::new()
        });
        let essential = if self.complete { usize::MAX } else { failures.len() };
        // The page has no effect on what was rendered, and takes time of its own.
        let clock = |report: &mut Report| {
            report.time.wall = self.before + started.elapsed().as_secs_f64();
            late(report);
        };
        clock(&mut rendered.report);
        if let Some(path) = &self.args.page {
            failures.extend(self.write_page(&self.place(path), &rendered).err());
            clock(&mut rendered.report);
        }
        if let Some(path) = &self.args.report {
            failures.extend(write_json(&self.place(path), &rendered.report).err());
        }
        self.say(&rendered.report, &names, console);
        let mut failures = failures.into_iter().enumerate();
        let first = failures.next();
        for (_, other) in failures {
            console.error(&format!("error: {}", other.message()));
        }
        match first {
            Some((at, failure)) if at < essential => return Err(failure),
            Some((_, failure)) => console.error(&format!("error: {}", failure.message())),
            None => {}
        }
        Ok(Delivered { report: rendered.report, kept })
    }

    /// Where a file of this render goes.
    fn place(&self, path: &Path) -> PathBuf {
        if self.complete { path.to_owned() } else { atomic_file::incomplete(path) }
    }

    fn say(&self, report: &Report, layers: &[PathBuf], console: &mut Console) {
        if console.is_verbose() {
            console.say(&text::report(report));
        }
        console.say(&text::summary(report));
        for line in text::error(report).iter().chain(&text::reference(report)).chain(&text::warnings(report))
        {
            console.say(line);
        }
        for name in layers {
            console.say(&format!("layer: {}", name.display()));
        }
        if is_model(&self.args.scene) {
            console.say(&in_a_scene(&self.args.scene));
        }
    }

    fn write_page(&self, path: &Path, rendered: &Rendered) -> Result<(), Failure> {
        let view = View { width: rendered.width, height: rendered.height, linear: &rendered.linear };
        let (report, layers, done) = (&rendered.report, self.layers, rendered.done);
        let command = command_line();
        let surfaces = &self.surfaces.pictures(rendered)?;
        write_page(path, &RenderPage { view, done, report, layers, surfaces, profile: None, command })
    }

    fn write_image(&self, rendered: &Rendered) -> Result<(), Failure> {
        let view = View { width: rendered.width, height: rendered.height, linear: &rendered.linear };
        let metadata = Metadata::of(&rendered.report, rendered.done);
        let metadata = if self.args.record_time { metadata.with_times(&rendered.report) } else { metadata };
        let channels = match self.format {
            Format::Exr => surfaces::channels(self.layers, &self.surfaces.found),
            _ => Vec::new(),
        };
        let more = More { alpha: self.surfaces.found.alpha.as_deref(), channels };
        let covered = self.surfaces.without_background(&rendered.linear);
        let view = View { linear: covered.as_deref().unwrap_or(&rendered.linear), ..view };
        let encode = |out: &mut dyn Write| self.format.encode_with(view, &more, &metadata, out);
        Ok(match &self.args.output {
            Output::Stdout => {
                let mut out = BufWriter::new(io::stdout().lock());
                let written = encode(&mut out).and_then(|()| out.flush());
                written.context("cannot write the image to standard output")
            }
            Output::File(path, _) => {
                let path = self.place(path);
                atomic_file::write(&path, |out| encode(out))
                    .with_context(|| format!("cannot write {}", path.display()))
            }
            Output::Share(path) => match &rendered.state {
                Some(state) if self.complete => atomic_file::write(path, |out| state.write(out))
                    .with_context(|| format!("cannot write {}", path.display())),
                _ => Ok(()),
            },
        }?)
    }

    /// Writes layers as pictures next to an image whose format cannot hold them; returns their paths.
    fn write_layers(&self, rendered: &Rendered) -> Result<Vec<PathBuf>, Failure> {
        let (Output::File(path, _), false) = (&self.args.output, self.format == Format::Exr) else {
            return Ok(Vec::new());
        };
        let path = self.place(path);
        let mut names = Vec::new();
        for (layer, values) in self.layers {
            let name = layer_file(&path, layer.name());
            let what = format!("{}: {}", layer.name(), layer.unit());
            let painted = heat::paint(values, rendered.width, heat::Range::Auto, &what);
            let metadata = Metadata::of(&rendered.report, rendered.done);
            atomic_file::write(&name, |out| painted.write(&metadata, out))
                .with_context(|| format!("cannot write {}", name.display()))?;
            names.push(name);
        }
        for (layer, picture) in self.surfaces.pictures(rendered)? {
            let name = layer_file(&path, layer.name());
            atomic_file::write(&name, |out| out.write_all(&picture.png))
                .with_context(|| format!("cannot write {}", name.display()))?;
            names.push(name);
        }
        Ok(names)
    }
}

/// The picture of a layer beside `image`.
fn layer_file(image: &Path, layer: &str) -> PathBuf {
    image.with_extension(format!("{layer}.png"))
}

/// The pictures of layers beside `image`; none if it can hold them.
fn layer_files(args: &RenderArgs, image: &Path) -> Vec<PathBuf> {
    match &args.output {
        Output::File(_, format) if *format != Format::Exr => {
            let names = args.accuracy.aov.iter().map(|layer| layer.name());
            let surfaces = args.layers.iter().map(|layer| layer.name());
            names.chain(surfaces).map(|layer| layer_file(image, layer)).collect()
        }
        _ => Vec::new(),
    }
}

/// The files of a render that is interrupted.
fn incomplete_files(args: &RenderArgs) -> Vec<PathBuf> {
    let given = [&args.report, &args.page].into_iter().flatten();
    let mut files: Vec<PathBuf> = given.map(|path| atomic_file::incomplete(path)).collect();
    if let Output::File(path, _) = &args.output {
        let image = atomic_file::incomplete(path);
        files.extend(layer_files(args, &image));
        files.push(image);
    }
    files
}

/// Removes the state that a render kept on its way, and what an interrupted one left, once it is continued to the end.
pub(crate) fn remove_unfinished(args: &RenderArgs, state: &StateFile) -> Result<(), Failure> {
    state.remove()?;
    if !args.resume {
        return Ok(());
    }
    incomplete_files(args).iter().try_for_each(|path| remove(path))
}

/// The files of `whitted render`, without those that its scene names.
pub(crate) fn files(args: &RenderArgs, state: Option<&StateFile>) -> Files {
    let mut files = Files::new().reads("the scene", &args.scene);
    if let Some(truth) = &args.accuracy.reference {
        files = files.reads("--reference", truth);
    }
    if let Some(of) = &args.settings_of {
        files = files.reads("--as", of);
    }
    let image = match &args.output {
        Output::Stdout => Path::new("-"),
        Output::File(path, _) | Output::Share(path) => path,
    };
    if matches!(args.output, Output::File(..)) && (args.more || args.keep_state) {
        files = files.may_write("the kept state", KeptState::of(image).path());
    }
    files = files.writes("-o", Some(image));
    files = files.writes("--report", args.report.as_deref()).writes("--page", args.page.as_deref());
    for layer in layer_files(args, image) {
        files = files.writes("the layer", Some(&layer));
    }
    for path in incomplete_files(args) {
        files = files.may_write("the interrupted", &path);
    }
    match state {
        Some(state) => files.may_write("the state", state.to()),
        None => files,
    }
}

/// How a model that was drawn by itself gets into a scene.
fn in_a_scene(model: &Path) -> String {
    let model = model.display();
    format!(
        "in a scene: [[mesh]] with the line  file = \"{model}\"\n\
         `whitted import {model} -o scene.toml` writes camera and lights too"
    )
}

/// Writes the page of a render or profile.
pub(crate) fn write_page(path: &Path, page: &RenderPage<'_>) -> Result<(), Failure> {
    let cannot = || format!("cannot write {}", path.display());
    let text = render_page::page(page).with_context(cannot)?;
    Ok(atomic_file::write(path, |out| out.write_all(text.as_bytes())).with_context(cannot)?)
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

//! `whitted gallery`.

use crate::atomic_file;
use crate::cli::args::GalleryArgs;
use crate::cli::console::Console;
use crate::cli::delivery::write_json;
use crate::cli::failure::Failure;
use crate::cli::files::Files;
use crate::cli::progress::{self, Progress, Style};
use crate::cli::read;
use crate::image::{Bits, Format, Metadata, View};
use crate::lab::gallery::{self, Cell, Picture, Section, Sheet, Subject};
use crate::render::{RenderError, Rendered, Renderer};
use crate::report::Report;
use crate::report::text;
use crate::scene::Scene;
use crate::settings::Settings;
use crate::units::{plural, seconds, short};
use anyhow::Context;
use serde::Serialize;
use std::fs;
use std::path::Path;
use std::time::Instant;

/// One picture in `gallery.json`.
#[derive(Serialize)]
struct Entry {
    /// `samples`, `depth` or `final`.
    row: &'static str,
    report: Report,
}

/// Renders all pictures, then the sheet.
pub fn run(args: &GalleryArgs, started: Instant, console: &mut Console) -> Result<(), Failure> {
    let subjects = subjects(args, console)?;
    let files = subjects.iter().fold(Files::new(), |files, subject| files.reads_scene(&subject.scene));
    files.fills("-o", &args.output).check()?;
    prepare(&args.output)?;
    progress::catch_interrupts()?;
    let mut renderer = Renderer::new(&args.device.choice())?;
    let style = Style::choose(console.is_quiet(), console.is_verbose());
    let mut draw = |scene: &Scene, settings: &Settings, name: &str| {
        renderer.render_with(scene, settings, &mut Progress::new(style, name))
    };
    make(args, &subjects, &mut draw, started, console)
}

/// The scene and, if there is one, its sibling.
fn subjects(args: &GalleryArgs, console: &mut Console) -> Result<Vec<Subject>, Failure> {
    let mut subject = |path: &Path| {
        let scene = read::scene(path, &args.read, None, console)?;
        let name = path.file_stem().map_or("scene".into(), |stem| stem.to_string_lossy().into_owned());
        Ok::<_, Failure>(Subject { name, scene })
    };
    let mut subjects = vec![subject(&args.scene)?];
    if let Some(sibling) = gallery::sibling(&args.scene) {
        subjects.push(subject(&sibling)?);
    }
    Ok(subjects)
}

fn prepare(folder: &Path) -> Result<(), Failure> {
    fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    let probe = folder.join("gallery.json");
    Ok(atomic_file::check(&probe).with_context(|| format!("cannot write {}", probe.display()))?)
}

/// Draws one picture; the name is for the progress shown.
type Draw<'a> = dyn FnMut(&Scene, &Settings, &str) -> Result<Rendered, RenderError> + 'a;

fn make(
    args: &GalleryArgs,
    subjects: &[Subject],
    draw: &mut Draw<'_>,
    started: Instant,
    console: &mut Console,
) -> Result<(), Failure> {
    let rows = gallery::rows(subjects, args.seed, args.scale);
    let total: usize = rows.iter().map(|row| row.pictures.len()).sum();
    let mut entries: Vec<Entry> = Vec::with_capacity(total);
    let mut sections = Vec::new();
    for row in rows {
        let mut cells = Vec::new();
        for picture in &row.pictures {
            let subject = &subjects[picture.subject];
            let mut rendered = draw(&subject.scene, &picture.settings, &picture.name)?;
            if rendered.done < 1.0 {
                return Err(Failure::Interrupted(format!(
                    "interrupted: {} of {total} pictures are in {}; no contact sheet",
                    entries.len(),
                    args.output.display(),
                )));
            }
            save(&args.output, picture, &mut rendered, started)?;
            if console.is_verbose() {
                console.say(&text::report(&rendered.report));
            }
            console.say(&text::summary(&rendered.report));
            let named = (row.name == "final").then_some(subject.name.as_str());
            cells.push(cell(&rendered, named));
            entries.push(Entry { row: row.name, report: rendered.report });
        }
        sections.push(Section { heading: row.heading, cells });
    }
    write_json(&args.output.join("gallery.json"), &entries)?;
    let path = args.output.join("contact_sheet.png");
    let device = entries.first().map_or("", |entry| entry.report.device.name.as_str());
    let subtitle = format!("whitted {} on {device}", env!("CARGO_PKG_VERSION"));
    let sheet = Sheet { title: subjects[0].name.clone(), subtitle: subtitle.clone(), sections };
    let metadata = Metadata::new([("Software", subtitle.as_str()), ("Scene", &args.scene.to_string_lossy())]);
    atomic_file::write(&path, |out| sheet.encode(&metadata, out))
        .with_context(|| format!("cannot write {}", path.display()))?;
    console.say(&format!("{}: {total} pictures", path.display()));
    Ok(())
}

/// Completes the report and writes the picture.
fn save(folder: &Path, picture: &Picture, rendered: &mut Rendered, started: Instant) -> Result<(), Failure> {
    let path = folder.join(format!("{}.png", picture.name));
    let report = &mut rendered.report;
    report.image.file = path.display().to_string();
    report.time.wall = started.elapsed().as_secs_f64();
    let metadata = Metadata::of(&rendered.report, rendered.done);
    let view = view(rendered);
    Ok(atomic_file::write(&path, |out| Format::Png(Bits::Eight).encode(view, &metadata, out))
        .with_context(|| format!("cannot write {}", path.display()))?)
}

/// The picture with its captions; `name` where scenes differ along the row.
fn cell(rendered: &Rendered, name: Option<&str>) -> Cell {
    let Report { settings, rays, time, .. } = &rendered.report;
    let name = name.map_or(String::new(), |name| format!("{name}: "));
    let captions = [
        format!("{name}{}, depth {}", plural(settings.samples.into(), "sample"), settings.depth),
        format!("{} rays in {}", short(rays.total() as f64), seconds(time.render)),
    ];
    Cell::new(view(rendered), captions)
}

fn view(rendered: &Rendered) -> View<'_> {
    View { width: rendered.width, height: rendered.height, linear: &rendered.linear }
}

#[cfg(test)]
mod tests;

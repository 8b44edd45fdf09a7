//! `whitted profile`.

use super::command_line;
use crate::cli::args::{ProfileArgs, Size};
use crate::cli::console::{self, Console};
use crate::cli::delivery::{write_json, write_page};
use crate::cli::failure::Failure;
use crate::cli::files::Files;
use crate::cli::progress::{self, Progress, Style};
use crate::cli::read;
use crate::image::{Bits, Format, Metadata, View};
use crate::lab::profile::{self, Profile};
use crate::lab::render_page::RenderPage;
use crate::plan::Plan;
use crate::plan::{memory_traffic, passes};
use crate::render::{Prepared, Rendered, Renderer};
use crate::report::Report;
use crate::report::text;
use crate::report::timeline::{self, Dispatched, Phase, RenderTimeline, Submit};
use crate::scene::Scene;
use crate::settings::{Precision, Schedule, Settings};
use anyhow::{Context, anyhow};
use std::path::Path;
use std::time::Instant;

/// Renders several times and prints where the time goes.
pub fn run(args: &ProfileArgs, started: Instant, console: &mut Console) -> Result<(), Failure> {
    if args.trace.as_ref().is_some_and(|p| p.as_os_str() == "-") {
        return Err(Failure::Usage("--trace needs a file".into()));
    }
    files(args).check()?;
    let begin = Instant::now();
    let scene = read::scene(&args.scene, &args.read, args.size, console)?;
    files(args).reads_scene(&scene).check()?;
    let mut phases = vec![Phase::since("parse scene", begin)];
    let settings = settings(args, &scene);
    progress::catch_interrupts()?;
    let begin = Instant::now();
    let mut renderer = Renderer::new(&args.device.choice())?;
    phases.push(Phase::since("open device", begin));

    let style = Style::choose(console.is_quiet(), console.is_verbose());
    let mut prepared = renderer.prepare(&scene, &settings)?;
    let mut draw = |prepared: &mut Prepared, name: &str| {
        let begin = Instant::now();
        let rendered = prepared.render_with(&mut Progress::new(style, name))?;
        if rendered.done < 1.0 {
            return Err(Failure::Interrupted("interrupted: no profile".into()));
        }
        let RenderTimeline { phases: inner, submits } = prepared.take_timeline();
        phases.push(Phase::since(name, begin));
        phases.extend(inner);
        Ok::<_, Failure>((rendered, submits))
    };
    let (first, _) = draw(&mut prepared, "warm-up")?;
    let mut runs: Vec<Report> = Vec::new();
    for run in 1..=args.repeats {
        runs.push(draw(&mut prepared, &format!("run {run}"))?.0.report);
    }
    let mut tests = None;
    if args.tests {
        let schedule = Schedule { count_tests: true, ..settings.schedule };
        let mut counting = renderer.prepare(&scene, &Settings { schedule, ..settings })?;
        tests = draw(&mut counting, "counting tests")?.0.report.tests;
    }
    let (plan, precision) = (prepared.plan().clone(), prepared.settings().precision);
    if let Some(path) = &args.trace {
        prepared.keep_submits(true);
        let (rendered, submits) = draw(&mut prepared, "traced frame")?;
        let begin = Instant::now();
        encode(&rendered)?;
        phases.push(Phase::since("encode image (PNG)", begin));
        write_trace(path, started, &rendered.report.device.name, &phases, &submits, &plan, precision)?;
    }
    let mut profile = Profile::new(&runs, &first.report.time, &plan, precision)
        .ok_or_else(|| anyhow!("the device reported times that are not numbers"))?;
    let report = &mut profile.report;
    report.tests = tests;
    report.time.wall = started.elapsed().as_secs_f64();
    if let Some(path) = &args.page {
        let view = View { width: first.width, height: first.height, linear: &first.linear };
        let Profile { report, profile: spread } = &profile;
        let (profile, command) = (Some(spread), command_line());
        write_page(
            path,
            &RenderPage { view, done: first.done, report, layers: &[], surfaces: &[], profile, command },
        )?;
    }
    tell(args, &profile, console)
}

/// Its files, without those that the scene names.
fn files(args: &ProfileArgs) -> Files {
    let files = Files::new().reads("the scene", &args.scene);
    let files = files.writes("--json", args.json.as_deref()).writes("--trace", args.trace.as_deref());
    files.writes("--page", args.page.as_deref()).prints()
}

/// The scene's settings under those of the command line.
fn settings(args: &ProfileArgs, scene: &Scene) -> Settings {
    let mut settings = Settings::of(scene);
    if let Some(Size { width, height }) = args.size {
        (settings.width, settings.height) = (width, height);
    }
    settings.samples = args.samples.unwrap_or(settings.samples);
    settings.depth = args.depth.unwrap_or(settings.depth);
    settings.seed = args.seed;
    settings.precision = args.precision;
    settings.schedule = args.schedule.schedule();
    settings
}

/// Encodes the image as `render` does, without writing it.
fn encode(rendered: &Rendered) -> Result<(), Failure> {
    let view = View { width: rendered.width, height: rendered.height, linear: &rendered.linear };
    let metadata = Metadata::of(&rendered.report, rendered.done);
    Ok(Format::Png(Bits::Eight)
        .encode(view, &metadata, &mut Vec::new())
        .context("cannot encode the image")?)
}

fn write_trace(
    path: &Path,
    started: Instant,
    device: &str,
    phases: &[Phase],
    submits: &[Submit],
    plan: &Plan,
    precision: Precision,
) -> Result<(), Failure> {
    let bytes = |d: &Dispatched| {
        let pass = passes::all().find(|p| p.kernel == d.kernel)?;
        Some(memory_traffic::of(pass, plan, precision).bytes(d.items?, d.children?, d.samples))
    };
    write_json(path, &timeline::trace(started, device, phases, submits, bytes))
}

fn tell(args: &ProfileArgs, profile: &Profile, console: &mut Console) -> Result<(), Failure> {
    let text = text::about(&profile.report) + "\n" + &profile::text(profile);
    for line in text::warnings(&profile.report) {
        console.say(&line);
    }
    match &args.json {
        Some(path) if path.as_os_str() == "-" => {
            let json = serde_json::to_string_pretty(profile).context("cannot express the profile as JSON")?;
            console.say(&text);
            console::print(&(json + "\n"))
        }
        other => {
            if let Some(path) = other {
                write_json(path, profile)?;
            }
            if console.is_quiet() { Ok(()) } else { console::print(&text) }
        }
    }
}

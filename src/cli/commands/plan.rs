//! `whitted plan`.

use crate::accuracy::promise::{Request, Settled};
use crate::cli::args::PlanArgs;
use crate::cli::console::{self, Console};
use crate::cli::delivery::{settings, write_json};
use crate::cli::failure::Failure;
use crate::cli::files::Files;
use crate::cli::progress::{self, Progress, Style};
use crate::cli::read;
use crate::plan::host_memory::{self, HostWork};
use crate::plan::predicted_time::{Model, Unpredictable, Work};
use crate::plan::tiles::tiles;
use crate::plan::{Plan, Purpose};
use crate::prepare::Packed;
use crate::render::{Prepared, RenderError, Renderer, Trial};
use crate::report::Report;
use crate::report::explain::{self, ExplainedPlan, PlannedError, Refused};
use crate::report::prediction::Prediction;
use crate::scene::Scene;
use crate::settings::{Precision, Settings};
use crate::units::{figure, plural};
use anyhow::Context;
use std::path::Path;

/// Prints what a render needs.
pub fn run(args: &PlanArgs, console: &mut Console) -> Result<(), Failure> {
    files(args).check()?;
    let earlier = args.from.as_deref().map(report).transpose()?;
    let scene = read::scene(&args.scene, &args.read, args.picture.size, console)?;
    files(args).reads_scene(&scene).check()?;
    let scene_seconds = scene.read_time.0.as_secs_f64();
    let mut asked = settings(&args.picture, &args.schedule, &scene)?;
    progress::catch_interrupts()?;
    let mut renderer = Renderer::new(&args.device.choice())?;
    let settled = match args.error {
        Some(error) => Some(settle(args, error, &scene, &mut asked, &mut renderer, console)?),
        None => None,
    };
    let file = args.scene.display().to_string();
    let built = renderer.build(&scene, &asked, Purpose::Image)?;
    let (mut outline, warnings) = (renderer.explain(&built, &file), built.warnings().to_vec());
    let mut failure = None;
    match built.planned.plan() {
        Err(error) => failure = Some(Failure::from(RenderError::from(error))),
        Ok(_) if fits(&asked).is_err() => failure = fits(&asked).err(),
        Ok(plan) => {
            let reported = match earlier {
                Some(report) => {
                    check(&report, &outline, &built.planned.packed)?;
                    let from = of_report(&report, plan, &built.planned.settings);
                    if let Err(why) = &from {
                        console.say(&format!("{why}: running a trial instead"));
                    }
                    from.ok()
                }
                None => None,
            };
            let style = Style::choose(console.is_quiet(), console.is_verbose());
            let mut progress = Progress::new(style, "trial");
            outline.time = match reported {
                None if !args.no_trial => {
                    let prepared = renderer.prepare_built(&scene, built).map_err(Failure::from);
                    match prepared.and_then(|mut p| trial(&mut p, &mut progress)) {
                        Ok(time) => Some(Prediction { start: time.start.map(|s| s + scene_seconds), ..time }),
                        Err(error) => {
                            failure = Some(error);
                            None
                        }
                    }
                }
                known => known,
            };
        }
    }
    if let Some(Settled { asked, expected, pixels, met, .. }) = settled {
        outline.error = Some(PlannedError { asked, expected, pixels });
        if !met && failure.is_none() {
            failure = Some(Failure::Unmet(format!(
                "the error is expected to be {} even with {} per pixel, more than {}",
                figure(expected),
                plural(outline.settings.samples.into(), "sample"),
                figure(asked)
            )));
        }
    }
    outline.refused = failure.as_ref().map(|f| Refused { message: f.message(), exit_code: f.exit_code() });
    tell(args, &outline, console)?;
    for warning in warnings {
        console.say(&format!("warning: {warning}"));
    }
    failure.map_or(Ok(()), Err)
}

/// Checks that the host can hold the image, written in the smallest format.
fn fits(settings: &Settings) -> Result<(), Failure> {
    let (region, free) = (settings.region(), crate::host::memory::free());
    Ok(host_memory::check(region, HostWork::Image, 0, free).map_err(RenderError::from)?)
}

/// Its files, without those that the scene names.
fn files(args: &PlanArgs) -> Files {
    let files = Files::new().reads("the scene", &args.scene);
    let files = args.from.iter().fold(files, |files, from| files.reads("--from", from));
    files.writes("--json", args.json.as_deref()).prints()
}

/// Chooses settings for an error, and puts them in place of those asked for.
fn settle(
    args: &PlanArgs,
    error: f64,
    scene: &Scene,
    asked: &mut Settings,
    renderer: &mut Renderer,
    console: &Console,
) -> Result<Settled, Failure> {
    let request = Request {
        keep_depth: args.picture.depth.is_some(),
        keep_precision: args.picture.precision.is_some_and(|p| p != Precision::Auto),
        ..Request::error(error)
    };
    let style = Style::choose(console.is_quiet(), console.is_verbose());
    let mut progress = Progress::new(style, "choosing settings");
    let settled = renderer.settle(scene, asked, &request, &mut progress)?;
    if progress::interrupted() {
        return Err(Failure::Interrupted("interrupted; no settings were chosen".into()));
    }
    asked.clone_from(&settled.settings);
    Ok(settled)
}

/// A report written by `render` or `profile`.
pub(super) fn report(path: &Path) -> Result<Report, Failure> {
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let report = serde_json::from_str(&text)
        .with_context(|| format!("{} is not a report of `whitted render --report`", path.display()))?;
    Ok(report)
}

/// Rejects a report of another device, scene or precision.
fn check(report: &Report, now: &ExplainedPlan, packed: &Packed) -> Result<(), Failure> {
    let counts =
        [packed.scene_features.triangles, packed.scene_features.spheres, packed.scene_features.lights];
    let then = [report.scene.triangles, report.scene.spheres, report.scene.lights];
    let differs = if report.device.name != now.device.name {
        Some(format!("device ({})", report.device.name))
    } else if counts != then {
        Some(format!("scene ({})", report.scene.file))
    } else if report.settings.precision != now.settings.precision {
        Some(format!("precision ({})", report.settings.precision))
    } else {
        None
    };
    match differs {
        Some(what) => Err(Failure::Usage(format!(
            "the report of --from has a different {what}; leave out --from to run a trial"
        ))),
        None => Ok(()),
    }
}

/// Predicts the planned render from the report of another.
fn of_report(report: &Report, plan: &Plan, settings: &Settings) -> Result<Prediction, Unpredictable> {
    predict(&Model::of_report(report)?, plan, settings)
}

/// The time of the planned render after a model.
fn predict(model: &Model, plan: &Plan, settings: &Settings) -> Result<Prediction, Unpredictable> {
    let [x0, y0, x1, y1] = settings.region();
    let pixels = u64::from(x1 - x0) * u64::from(y1 - y0);
    let tiles = tiles([x0, y0, x1, y1], plan.tile_pixels).len() as u64;
    let batches = tiles * u64::from(settings.samples.div_ceil(plan.batch_samples));
    model.predict(&Work { plan, pixels, samples: pixels * u64::from(settings.samples), batches })
}

/// Traces some bands of the image and predicts the time of the whole.
pub(super) fn trial(prepared: &mut Prepared, progress: &mut Progress) -> Result<Prediction, Failure> {
    let start = prepared.seconds();
    let mut trial = Trial::new(prepared);
    let model = trial.model(progress)?.context("the trial was cut short")?;
    let mut time =
        predict(&model, prepared.plan(), prepared.settings()).context("the trial was cut short")?;
    time.start = Some(start);
    Ok(time)
}

fn tell(args: &PlanArgs, outline: &ExplainedPlan, console: &mut Console) -> Result<(), Failure> {
    let text = explain::text(outline);
    match &args.json {
        Some(path) if path.as_os_str() == "-" => {
            let json = serde_json::to_string_pretty(outline).context("cannot express the plan as JSON")?;
            console.say(&text);
            console::print(&(json + "\n"))
        }
        other => {
            if let Some(path) = other {
                write_json(path, outline)?;
            }
            if console.is_quiet() { Ok(()) } else { console::print(&text) }
        }
    }
}

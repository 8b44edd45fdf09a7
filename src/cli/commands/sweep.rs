//! `whitted sweep`.

use super::command_line;
use crate::cli::args::{Size, SweepArgs};
use crate::cli::console::{Console, print};
use crate::cli::failure::Failure;
use crate::cli::files::Files;
use crate::cli::progress::{self, Progress, Style};
use crate::cli::read;
use crate::lab::sweep::axes::{Axis, Value, grid};
use crate::lab::sweep::{Plan, Record, SweepError, Watch, run as sweep};
use crate::render::{Observer, Renderer};
use crate::report::table::{Align, Table};
use crate::settings::{Precision, Settings};
use crate::units::{figure, seconds};
use anyhow::Context;

/// Runs a sweep and prints the Pareto front.
pub fn run(args: &SweepArgs, console: &mut Console) -> Result<(), Failure> {
    let scene = read::scene(&args.scene, &args.read, args.size, console)?;
    // The grid is checked before the device is opened: a mistake in it costs nothing.
    grid(&scene, &args.over).map_err(Failure::Usage)?;
    Files::new()
        .reads("the scene", &args.scene)
        .reads_scene(&scene)
        .fills("-o", &args.output)
        .prints()
        .check()?;
    std::fs::create_dir_all(&args.output)
        .with_context(|| format!("cannot make the folder {}", args.output.display()))?;
    progress::catch_interrupts()?;
    let mut renderer = Renderer::new(&args.device.choice())?;
    let axes = within(&args.over, renderer.device().has_double(), console);
    let mut points = grid(&scene, &axes).map_err(Failure::Usage)?;
    let mut base = Settings::of(&scene);
    if let Some(Size { width, height }) = args.size {
        (base.width, base.height) = (width, height);
    }
    if !axes.iter().any(|a| a.name == "precision") {
        let (settled, warnings) = renderer.settled(&scene, &base);
        points.iter_mut().for_each(|p| p.precision = settled.precision);
        warnings.iter().for_each(|w| console.say(&format!("warning: {w}")));
    }
    let plan = Plan {
        scene,
        base,
        axes: axes.iter().map(|a| a.name.to_owned()).collect(),
        points,
        folder: args.output.clone(),
        repeats: args.repeats,
        truth_samples: args.truth_samples,
        errors: args.error.clone(),
        command: command_line(),
        oracle: args.oracle,
        fresh: args.fresh,
    };
    let record = sweep(&mut renderer, &plan, &mut Shown(console)).map_err(|error| match error {
        SweepError::Render(error) => error.into(),
        SweepError::Stopped => Failure::Interrupted(format!(
            "interrupted: finished settings are in {}; the same command continues from there",
            args.output.display()
        )),
        other => Failure::Other(anyhow::Error::new(other)),
    })?;
    console.say(&format!("{}: {} settings", args.output.join("sweep.json").display(), record.rows.len()));
    print(&text(&record))
}

/// The axes; where `all` values were asked for, without those that the device does not support.
fn within(axes: &[Axis], double: bool, console: &mut Console) -> Vec<Axis> {
    let mut axes = axes.to_vec();
    for axis in axes.iter_mut().filter(|a| a.all && !double) {
        let before = axis.values.len();
        axis.values.retain(|v| *v != Value::Precision(Precision::Double));
        if axis.values.len() < before {
            console.say("warning: this device has no f64; precision=f64 is left out");
        }
    }
    axes
}

struct Shown<'a>(&'a mut Console);

impl Watch for Shown<'_> {
    fn begin(&mut self, what: &str) -> Box<dyn Observer> {
        Box::new(Progress::new(Style::choose(self.0.is_quiet(), self.0.is_verbose()), what))
    }

    fn say(&mut self, line: &str) {
        self.0.say(line);
    }
}

/// The Pareto front, the fastest setting for each error, and the truth's own error.
fn text(record: &Record) -> String {
    use Align::{Left, Right};
    let error = |x: Option<f64>| x.map_or("-".into(), figure);
    let mut front =
        Table::new(&[("Pareto front (lowest error for the time)", Left), ("time", Right), ("RMSE", Right)]);
    for row in record.front.iter().filter_map(|name| record.rows.iter().find(|r| r.name == *name)) {
        front.row([row.name.clone(), seconds(row.seconds()), error(row.rmse())]);
    }
    let mut cheapest = Table::new(&[("RMSE at most", Right), ("fastest setting", Left), ("time", Right)]);
    for c in &record.cheapest {
        cheapest.row([
            figure(c.error),
            c.name.clone().unwrap_or("none".into()),
            c.seconds.map_or("-".into(), seconds),
        ]);
    }
    let truth = record.truth.as_ref().map_or(String::new(), |t| {
        let hidden = match t.truncation.as_ref().map(|h| h.rms) {
            None => "unknown".into(),
            Some(0.0) => "0".into(),
            Some(rms) => format!("at most {}", figure(rms)),
        };
        format!("truth: standard error {}, truncation {hidden} (RMSE)\n", figure(t.standard_error))
    });
    format!("{front}\n{cheapest}\n{truth}")
}

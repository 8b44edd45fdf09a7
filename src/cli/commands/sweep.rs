//! `whitted sweep`.

use super::command_line;
use crate::cli::args::{Size, SweepArgs};
use crate::cli::console::{Console, print};
use crate::cli::failure::Failure;
use crate::cli::progress::{self, Progress, Style};
use crate::lab::sweep::axes::{Axis, Value, grid};
use crate::lab::sweep::{Plan, Record, SweepError, Watch, run as sweep};
use crate::render::{Observer, Renderer};
use crate::report::table::{Align, Table};
use crate::scene::Scene;
use crate::settings::{Precision, Settings};
use crate::units::seconds;
use anyhow::Context;

/// Runs a sweep; what it found in short goes to standard output.
pub fn run(args: &SweepArgs, console: &mut Console) -> Result<(), Failure> {
    let scene = Scene::load(&args.scene)?;
    // The grid is checked before the device is opened: a mistake in it costs nothing.
    grid(&scene, &args.over).map_err(Failure::Usage)?;
    std::fs::create_dir_all(&args.output)
        .with_context(|| format!("cannot make the folder {}", args.output.display()))?;
    progress::catch_interrupts()?;
    let mut renderer = Renderer::new(&args.device.choice())?;
    let axes = within(&args.over, renderer.device().has_double(), console);
    let points = grid(&scene, &axes).map_err(Failure::Usage)?;
    let mut base = Settings::of(&scene);
    if let Some(Size { width, height }) = args.size {
        (base.width, base.height) = (width, height);
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
            "interrupted: what is finished is in {}; the same command goes on from there",
            args.output.display()
        )),
        other => Failure::Other(anyhow::Error::new(other)),
    })?;
    console.say(&format!("{}: {} points", args.output.join("sweep.json").display(), record.rows.len()));
    print(&text(&record))
}

/// The axes without what the device cannot do, where `all` was asked for.
fn within(axes: &[Axis], double: bool, console: &mut Console) -> Vec<Axis> {
    let mut axes = axes.to_vec();
    for axis in axes.iter_mut().filter(|a| a.all && !double) {
        let before = axis.values.len();
        axis.values.retain(|v| *v != Value::Precision(Precision::Double));
        if axis.values.len() < before {
            console.say("warning: this device has no double precision; precision f64 is left out");
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

/// The front, and the cheapest point for each error.
fn text(record: &Record) -> String {
    use Align::{Left, Right};
    let scientific = |x: Option<f64>| x.map_or("-".into(), |x| format!("{x:.2e}"));
    let mut front = Table::new(&[("no point is faster and better", Left), ("time", Right), ("RMSE", Right)]);
    for row in record.front.iter().filter_map(|name| record.rows.iter().find(|r| r.name == *name)) {
        front.row([row.name.clone(), seconds(row.seconds()), scientific(row.rmse())]);
    }
    let mut cheapest = Table::new(&[("RMSE at most", Right), ("cheapest point", Left), ("time", Right)]);
    for c in &record.cheapest {
        cheapest.row([
            c.error.to_string(),
            c.name.clone().unwrap_or("none".into()),
            c.seconds.map_or("-".into(), seconds),
        ]);
    }
    let truth = record.truth.as_ref().map_or(String::new(), |t| {
        let hidden = t.truncation.as_ref().map_or("unknown".into(), |h| format!("at most {:.1e}", h.rms));
        format!("truth: standard error {:.1e}, hidden beyond its depth {hidden} (RMSE)\n", t.standard_error)
    });
    format!("{front}\n{cheapest}\n{truth}")
}

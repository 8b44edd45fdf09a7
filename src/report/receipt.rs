//! The receipt of a render: its plan, its measured time and memory, and the cost of each feature
//! that the scene does not use. Serde data and its text; `lab::receipt` measures it.

use super::explain::{self, ExplainedPlan};
use super::table::{Align, Table};
use crate::stats::Quartiles;
use crate::units::{bytes, grouped, plural, seconds};
use serde::Serialize;

/// A render next to its plan.
#[derive(Debug, Clone, Serialize)]
pub struct Receipt {
    /// The plan with the predicted time.
    pub outline: ExplainedPlan,
    /// Cost of each kernel, summed over depths, in the order of dispatch.
    pub parts: Vec<Part>,
    /// Measured render time, seconds.
    pub render: f64,
    /// Measured render time / predicted; null without a prediction.
    pub over_predicted: Option<f64>,
    /// Rays traced / predicted; null without a prediction.
    pub rays_over_predicted: Option<f64>,
    /// Device bytes planned.
    pub bytes_planned: u64,
    /// Bytes allocated on device and host: planned bytes, alignment and staging buffer.
    pub bytes_taken: u64,
    /// Features that the scene does not use and the kernels leave out.
    pub absent: Vec<Absent>,
    /// Why `absent` is empty although some feature is left out.
    pub absent_unknown_why: Option<String>,
    /// Samples traced by each run that measured `absent`.
    pub samples: u64,
    /// Paired runs per feature: one with it, one without.
    pub pairs: usize,
}

/// Cost of one kernel in a render.
#[derive(Debug, Clone, Serialize)]
pub struct Part {
    /// The kernel.
    pub name: String,
    /// Number of dispatches.
    pub launches: u64,
    /// Device time, seconds.
    pub seconds: f64,
    /// Share of the device time of all kernels, 0 to 1.
    pub share: f64,
}

/// A feature left out of the kernels, with its cost if it were not.
#[derive(Debug, Clone, Serialize)]
pub struct Absent {
    /// Its name in `--general`.
    pub feature: &'static str,
    /// What switching it on adds.
    pub what: &'static str,
    /// Device time with it / without it, over the paired runs.
    pub ratio: Quartiles,
    /// Seconds to create its pipelines; short if the driver has them cached.
    pub prepare: f64,
    /// Device bytes with it - without it.
    pub bytes: i64,
    /// Pixels whose bits differ from those without it; anything but 0 is a bug.
    pub pixels_differ: u64,
}

impl Receipt {
    /// Features that change the image, which is a bug.
    pub fn wrong(&self) -> Vec<&'static str> {
        self.absent.iter().filter(|a| a.pixels_differ > 0).map(|a| a.feature).collect()
    }
}

/// The receipt for people: the plan, then the measurements.
pub fn text(r: &Receipt) -> String {
    use Align::{Left, Right};
    let mut table = Table::new(&[("kernel", Left), ("dispatches", Right), ("time", Right), ("share", Right)]);
    for p in &r.parts {
        table.row([
            p.name.clone(),
            grouped(p.launches),
            seconds(p.seconds),
            format!("{:.1} %", 100.0 * p.share),
        ]);
    }
    let mut text = format!("{}\n{table}\n", explain::text(&r.outline));
    text += &format!("render  {}", seconds(r.render));
    if let (Some(time), Some(over), Some(rays)) = (&r.outline.time, r.over_predicted, r.rays_over_predicted) {
        let within = if (time.low..=time.high).contains(&r.render) { "within" } else { "outside" };
        text += &format!(
            ": {over:.2} times the predicted {}, {within} the predicted range; rays {rays:.3} times the predicted",
            seconds(time.render)
        );
    }
    text += &format!(
        "\nmemory  {} planned, {} allocated with alignment and staging\n\n",
        bytes(r.bytes_planned),
        bytes(r.bytes_taken)
    );
    if let Some(why) = &r.absent_unknown_why {
        return text + &format!("the cost of unused features was not measured: {why}\n");
    }
    if r.absent.is_empty() {
        return text + "no feature is left out of the kernels\n";
    }
    let mut table = Table::new(&[
        ("left out", Left),
        ("time with it", Right),
        ("middle half", Left),
        ("memory", Right),
        ("compile", Right),
        ("image", Left),
        ("what it would add", Left),
    ]);
    for a in &r.absent {
        let sign = if a.bytes < 0 { "-" } else { "+" };
        table.row([
            a.feature.into(),
            format!("x {:.2}", a.ratio.median),
            format!("{:.2} to {:.2}", a.ratio.lower, a.ratio.upper),
            format!("{sign}{}", bytes(a.bytes.unsigned_abs())),
            seconds(a.prepare),
            if a.pixels_differ == 0 {
                "same bits".into()
            } else {
                plural(a.pixels_differ, "different pixel")
            },
            a.what.into(),
        ]);
    }
    text + &format!(
        "{table}\ntime with it: device time of {} samples with the feature switched on / without it, median and \
         interquartile range of {} paired runs\n",
        grouped(r.samples),
        r.pairs
    )
}

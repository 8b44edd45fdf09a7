//! The receipt of a render: its plan, its measured time and bytes, and the price of each feature that the
//! scene does not have. Serde data and its text; `lab::receipt` measures it.

use super::explain::{self, Outline};
use super::table::{Align, Table};
use crate::stats::Quartiles;
use crate::units::{bytes, grouped, plural, seconds};
use serde::Serialize;

/// What was planned, and what came of it.
#[derive(Debug, Clone, Serialize)]
pub struct Receipt {
    /// The plan, with the predicted time.
    pub outline: Outline,
    /// The passes, all depths together, in the frame's order.
    pub parts: Vec<Part>,
    /// Measured time of the render.
    pub render: f64,
    /// That over the predicted time; null where none was predicted.
    pub over_predicted: Option<f64>,
    /// Rays traced over those predicted.
    pub rays_over_predicted: Option<f64>,
    /// Device bytes planned.
    pub bytes_planned: u64,
    /// Bytes taken from device and host: alignment and the staging buffer come on top of those planned.
    pub bytes_taken: u64,
    /// What the image has not and did not pay for.
    pub absent: Vec<Absent>,
    /// Why `absent` is empty, where something is.
    pub absent_unknown_why: Option<String>,
    /// Samples of one run that measured them.
    pub samples: u64,
    /// Runs of each variant, in turn with the render's own.
    pub pairs: usize,
}

/// What one kernel took.
#[derive(Debug, Clone, Serialize)]
pub struct Part {
    /// Its name.
    pub name: String,
    /// Dispatches.
    pub launches: u64,
    /// Device time.
    pub seconds: f64,
    /// Of all passes.
    pub share: f64,
}

/// A feature that was not paid for.
#[derive(Debug, Clone, Serialize)]
pub struct Absent {
    /// Its name, as `--general` takes it.
    pub feature: &'static str,
    /// What was switched on.
    pub what: &'static str,
    /// Device time with it over that without, in paired runs.
    pub ratio: Quartiles,
    /// Time to prepare its kernels; from the driver's cache, if that has them.
    pub prepare: f64,
    /// Device bytes of its plan less those of the render's.
    pub bytes: i64,
    /// Pixels of the share whose bits differ: none, or something is wrong.
    pub pixels_differ: u64,
}

impl Receipt {
    /// Features whose kernels gave other bits than the render's.
    pub fn wrong(&self) -> Vec<&'static str> {
        self.absent.iter().filter(|a| a.pixels_differ > 0).map(|a| a.feature).collect()
    }
}

/// The receipt for people: the plan, then what came of it.
pub fn text(r: &Receipt) -> String {
    use Align::{Left, Right};
    let mut table = Table::new(&[("took", Left), ("dispatches", Right), ("time", Right), ("share", Right)]);
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
            ", {over:.2} of the predicted {}, {within} its range; {rays:.3} of the predicted rays",
            seconds(time.render)
        );
    }
    text += &format!(
        "\nbytes   {} planned, {} taken with alignment and staging\n\n",
        bytes(r.bytes_planned),
        bytes(r.bytes_taken)
    );
    if let Some(why) = &r.absent_unknown_why {
        return text + &format!("what is absent was not measured: {why}\n");
    }
    if r.absent.is_empty() {
        return text + "nothing is absent: the kernels are the general ones\n";
    }
    let mut table = Table::new(&[
        ("not paid for", Left),
        ("time", Right),
        ("quartiles", Left),
        ("bytes", Right),
        ("prepare", Right),
        ("image", Left),
        ("switched on", Left),
    ]);
    for a in &r.absent {
        let sign = if a.bytes < 0 { "-" } else { "+" };
        table.row([
            a.feature.into(),
            format!("x {:.2}", a.ratio.median),
            format!("{:.2} to {:.2}", a.ratio.lower, a.ratio.upper),
            format!("{sign}{}", bytes(a.bytes.unsigned_abs())),
            seconds(a.prepare),
            if a.pixels_differ == 0 { "same bits".into() } else { plural(a.pixels_differ, "other pixel") },
            a.what.into(),
        ]);
    }
    text + &format!(
        "{table}\ndevice time of {} samples with the feature over that without, medians of {} runs in turn\n",
        grouped(r.samples),
        r.pairs
    )
}

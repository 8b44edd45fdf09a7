//! Stated against true error, one plot per family.

use crate::lab::calibrate::{Calibration, SceneRecord};
use crate::lab::plot::{self, Axis, Chart, Legend, Look, Scale, Series};
use crate::scene::procedural::families::Family;

/// Pixels of a plot.
const SIZE: (u32, u32) = (380, 340);
/// Errors below are shown here: they are rounding.
const LEAST: f64 = 1e-5;

/// The plots of all families with records, as SVG.
pub(super) fn plots(calibration: &Calibration) -> Result<Vec<String>, String> {
    let of = |family: Family| -> Vec<&SceneRecord> {
        calibration.scenes.iter().filter(|s| s.family == family.name() && s.failure.is_none()).collect()
    };
    Family::ALL
        .into_iter()
        .map(|family| (family, of(family)))
        .filter(|(_, scenes)| !scenes.is_empty())
        .map(|(family, scenes)| plot::svg(&[chart(calibration, family, &scenes)], SIZE))
        .collect()
}

fn chart(calibration: &Calibration, family: Family, scenes: &[&SceneRecord]) -> Chart {
    let point = |error: f64, stated: Option<f64>| Some((error.max(LEAST), stated?.max(LEAST)));
    let trials = &calibration.header.trials;
    let mut series: Vec<Series> = Vec::new();
    let mut add = |name: String, points: Vec<(f64, f64)>| {
        series.push(Series { name, color: series.len(), points, look: Look::Dots });
    };
    for samples in &trials.samples {
        let of = scenes.iter().flat_map(|s| &s.budget).filter(|b| b.samples == *samples);
        let points = of.filter_map(|b| point(b.error.error(), b.stated.total)).collect();
        add(format!("{samples} samples"), points);
    }
    for target in &trials.errors {
        let of = scenes.iter().flat_map(|s| &s.error).filter(|e| e.target == *target);
        let met = of.flat_map(|e| &e.trials).filter(|t| t.met);
        let points = met.filter_map(|t| point(t.error.error(), t.stated.total)).collect();
        add(format!("--error {target}"), points);
    }
    let all = || series.iter().flat_map(|s| s.points.iter().copied());
    let x = Axis::around("true RMSE", Scale::Decades, all().map(|p| p.0));
    let y = Axis::around("stated RMSE", Scale::Decades, all().map(|p| p.1));
    let (low, high) = (x.range[0].max(y.range[0]), x.range[1].min(y.range[1]));
    if low < high {
        let points = vec![(low, low), (high, high)];
        series.push(Series { name: "stated = true".into(), color: 3, points, look: Look::Plain });
    }
    Chart { title: family.name(), x, y, series, mark: None, legend: Legend::UpperLeft }
}

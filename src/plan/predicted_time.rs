//! Predicts the time of a render from a timed one: a part of the same image, or the same scene with
//! other samples and depth.
//!
//! The model is linear: each dispatch costs a constant, and each ray of a depth a constant per
//! kernel. The number of rays at depths that were not timed is extrapolated geometrically from the
//! last two that were.

use crate::kernel::table::Kernel;
use crate::plan::Plan;
use crate::plan::dispatches::{FIRST_REACH, dispatches};
use crate::plan::passes;
use crate::report::prediction::{DepthForecast, Prediction};
use crate::report::{PassInfo, Report};
use std::collections::BTreeMap;

/// Least relative uncertainty: device times vary by this much from run to run
/// (docs/design/decisions/014-predicted-time.md).
const PACE: f64 = 0.1;

/// Costs and ray counts, estimated from a timed render.
#[derive(Debug, Clone, Default)]
pub struct Model {
    /// Seconds of a nearly empty dispatch.
    start: BTreeMap<Kernel, f64>,
    /// Seconds per ray of a kernel at a depth, without `start`.
    cost: BTreeMap<(Kernel, u32), f64>,
    /// Rays per sample, by depth.
    rays: Vec<f64>,
    /// Shadow rays per ray, by depth.
    shadow: Vec<f64>,
    /// Host seconds per pixel.
    host: f64,
    /// Relative uncertainty of the mean cost of a sample.
    spread: f64,
    /// The timed work, in words.
    basis: String,
}

/// The render to predict.
#[derive(Debug, Clone, Copy)]
pub struct Work<'a> {
    /// Its plan.
    pub plan: &'a Plan,
    /// Pixels.
    pub pixels: u64,
    /// Samples of all pixels.
    pub samples: u64,
    /// Batches over all tiles.
    pub batches: u64,
}

/// Why no time can be predicted.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Unpredictable(pub String);

impl Model {
    /// From the report of a render of the same scene on the same device.
    ///
    /// # Errors
    /// If the report has no times, or those of kernels that there are not.
    pub fn of_report(report: &Report) -> Result<Model, Unpredictable> {
        let pixels = report.settings.region();
        let pixels = u64::from(pixels[2] - pixels[0]) * u64::from(pixels[3] - pixels[1]);
        let basis = format!(
            "a render of {}x{} pixels, {} samples, depth {}",
            report.settings.width, report.settings.height, report.settings.samples, report.settings.depth
        );
        let mut model = Model::new(report, &BTreeMap::new())?;
        model.host = (report.time.render - report.time.device).max(0.0) / pixels.max(1) as f64;
        model.basis = basis;
        Ok(model)
    }

    /// From passes and rays; `start` are seconds of nearly empty dispatches, where they were timed.
    ///
    /// # Errors
    /// If the report has no times, or those of kernels that there are not.
    pub fn new(report: &Report, start: &BTreeMap<Kernel, f64>) -> Result<Model, Unpredictable> {
        let samples = report.rays.primary as f64;
        if report.passes.is_empty() || samples <= 0.0 || report.time.device <= 0.0 {
            return Err(Unpredictable("the report has no pass times".into()));
        }
        let traced = |depth: u32| match depth {
            0 => samples,
            d => report.rays.by_depth.get(d as usize - 1).map_or(0.0, |r| r.traced as f64),
        };
        let mut model = Model { start: start.clone(), ..Model::default() };
        // Passes without rays measure `start`.
        for kernel in passes::all().map(|p| p.kernel) {
            let empty: Vec<&PassInfo> = report
                .passes
                .iter()
                .filter(|p| p.name == kernel.name() && traced(p.depth) == 0.0 && p.launches > 0)
                .collect();
            let launches: u64 = empty.iter().map(|p| p.launches).sum();
            if launches > 0 && !model.start.contains_key(&kernel) {
                let seconds: f64 = empty.iter().map(|p| p.seconds).sum();
                model.start.insert(kernel, seconds / launches as f64);
            }
        }
        for pass in report.passes.iter().filter(|p| traced(p.depth) > 0.0) {
            let Some(kernel) = passes::all().map(|p| p.kernel).find(|k| k.name() == pass.name) else {
                return Err(Unpredictable(format!(
                    "the report is of another version of whitted: there is no kernel `{}`",
                    pass.name
                )));
            };
            let starts = pass.launches as f64 * model.start(kernel);
            model.cost.insert((kernel, pass.depth), (pass.seconds - starts).max(0.0) / traced(pass.depth));
        }
        model.rays = report.rays.by_depth.iter().map(|d| d.traced as f64 / samples).collect();
        // Depths that were traced without a ray have none.
        let timed = report.passes.iter().map(|p| p.depth).max().unwrap_or(0);
        model.rays.resize(model.rays.len().max(timed as usize), 0.0);
        model.shadow =
            report.rays.by_depth.iter().map(|d| d.shadow as f64 / d.traced.max(1) as f64).collect();
        Ok(model)
    }

    /// The same with the relative uncertainty of its mean and a description of the timed work.
    #[must_use]
    pub fn with(self, spread: f64, basis: String) -> Model {
        Model { spread, basis, ..self }
    }

    fn start(&self, kernel: Kernel) -> f64 {
        self.start.get(&kernel).copied().unwrap_or(0.0)
    }

    /// Rays per sample at a depth, and whether they were counted rather than extrapolated.
    fn rays(&self, depth: u32, plan: &Plan) -> (f64, bool) {
        let (known, most) = (self.rays.len(), if plan.specialisation.branching != 0 { 2.0 } else { 1.0 });
        match self.rays.get(depth as usize - 1) {
            Some(rays) => (*rays, true),
            None => {
                let last = self.rays[known - 1];
                let before = if known > 1 { self.rays[known - 2] } else { last };
                let decay: f64 = if before > 0.0 { (last / before).min(most) } else { 0.0 };
                (last * decay.powi((depth as usize - known) as i32), false)
            }
        }
    }

    /// Seconds per ray of a kernel at a depth, or at the deepest timed depth above it.
    fn cost(&self, kernel: Kernel, depth: u32) -> Option<f64> {
        self.cost.range((kernel, 0)..=(kernel, depth)).next_back().map(|(_, c)| *c)
    }

    /// The time of `work`.
    ///
    /// # Errors
    /// If `work` needs kernels or depths that were not timed.
    pub fn predict(&self, work: &Work<'_>) -> Result<Prediction, Unpredictable> {
        let Work { plan, pixels, samples, batches } = *work;
        let last = plan.last_depth;
        if last > 1 && self.rays.len() == 1 {
            return Err(Unpredictable(
                "the report is of a render of depth 1 and cannot predict deeper rays".into(),
            ));
        }
        let other = if plan.specialisation.fused != 0 { Kernel::Intersect } else { Kernel::FusedDepth };
        if self.cost.keys().any(|(kernel, _)| *kernel == other) {
            return Err(Unpredictable(format!(
                "the timed render ran the kernel `{}`, which this one does not",
                other.name()
            )));
        }
        let mut by_depth: Vec<DepthForecast> = Vec::new();
        let (mut device, mut unseen) = (0.0, 0.0);
        // Dispatches of each kernel at each depth, in one batch.
        let mut launches: BTreeMap<(Kernel, u32), u32> = BTreeMap::new();
        for step in dispatches(plan, last) {
            *launches.entry((step.pass.kernel, step.depth)).or_default() += 1;
        }
        for ((kernel, depth), launches) in launches {
            let (rays, seen) = if depth == 0 { (1.0, true) } else { self.rays(depth, plan) };
            // Nothing is dispatched there.
            if rays == 0.0 && depth > FIRST_REACH {
                continue;
            }
            let rays = rays * samples as f64;
            let cost = self.cost(kernel, depth).unwrap_or(0.0);
            let seconds = batches as f64 * f64::from(launches) * self.start(kernel) + rays * cost;
            device += seconds;
            unseen += if seen { 0.0 } else { seconds };
            if depth == 0 {
                continue;
            }
            let at = depth as usize - 1;
            if by_depth.len() <= at {
                by_depth.resize(at + 1, DepthForecast::default());
            }
            let shadow = self.shadow.get(at).or(self.shadow.last()).copied().unwrap_or(0.0);
            let row = &mut by_depth[at];
            row.seconds += seconds;
            (row.depth, row.extrapolated) = (depth, !seen);
            (row.traced, row.shadow) = (rays.round() as u64, (rays * shadow).round() as u64);
        }
        let host = self.host * pixels as f64;
        let (render, error) = (device + host, PACE.max(2.0 * self.spread));
        let seen = render - unseen;
        Ok(Prediction {
            basis: self.basis.clone(),
            device,
            render,
            low: seen * (1.0 - error).max(0.0),
            high: seen * (1.0 + error) + 2.0 * unseen,
            rays: by_depth.iter().map(|d| d.traced + d.shadow).sum(),
            by_depth,
            start: None,
        })
    }
}

#[cfg(test)]
mod tests;

//! How long a render will take, from one that was timed: a part of the same image, or the same scene with
//! other samples and depth.
//!
//! Device time is taken to be linear: each dispatch costs a start, and each ray of a depth its share of each
//! kernel. Rays of depths that were not timed follow the decay from the last depth to the one before it.

use crate::kernel::table::Kernel;
use crate::plan::Plan;
use crate::plan::passes::{self, When};
use crate::report::prediction::{DepthForecast, Prediction};
use crate::report::{PassInfo, Report};
use std::collections::BTreeMap;

/// By how much the pace of one device varies from run to run at least, as a share: the spread of repeated
/// renders (ARCHITECTURE.md, "Figures").
const PACE: f64 = 0.1;

/// What a timed part of the work says of the whole.
#[derive(Debug, Clone, Default)]
pub struct Model {
    /// Seconds of a dispatch that has next to nothing to do.
    start: BTreeMap<Kernel, f64>,
    /// Seconds of a kernel at a depth for each of its rays, without the starts.
    cost: BTreeMap<(Kernel, u32), f64>,
    /// Rays of each depth for one sample.
    rays: Vec<f64>,
    /// Shadow rays for each ray of a depth.
    shadow: Vec<f64>,
    /// Seconds that the host adds for each pixel.
    host: f64,
    /// Uncertainty of the mean cost of a sample, as a share.
    spread: f64,
    /// What was timed, in words.
    basis: String,
}

/// What is to be predicted.
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

/// Why nothing can be foretold.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Unpredictable(pub String);

impl Model {
    /// From the report of a render of the same scene on the same device.
    ///
    /// # Errors
    /// If the report has no times.
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
    /// If the report has no times.
    pub fn new(report: &Report, start: &BTreeMap<Kernel, f64>) -> Result<Model, Unpredictable> {
        let samples = report.rays.primary as f64;
        if report.passes.is_empty() || samples <= 0.0 || report.time.device <= 0.0 {
            return Err(Unpredictable("the report has no times of passes".into()));
        }
        let traced = |depth: u32| match depth {
            0 => samples,
            d => report.rays.by_depth.get(d as usize - 1).map_or(0.0, |r| r.traced as f64),
        };
        let mut model = Model { start: start.clone(), ..Model::default() };
        // Passes without rays tell what a start costs.
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
                continue;
            };
            let starts = pass.launches as f64 * model.start(kernel);
            model.cost.insert((kernel, pass.depth), (pass.seconds - starts).max(0.0) / traced(pass.depth));
        }
        model.rays = report.rays.by_depth.iter().map(|d| d.traced as f64 / samples).collect();
        // Where passes found no ray, there was none.
        let timed = report.passes.iter().map(|p| p.depth).max().unwrap_or(0);
        model.rays.resize(model.rays.len().max(timed as usize), 0.0);
        model.shadow =
            report.rays.by_depth.iter().map(|d| d.shadow as f64 / d.traced.max(1) as f64).collect();
        Ok(model)
    }

    /// The same with the uncertainty of its mean, as a share, and what was timed.
    #[must_use]
    pub fn with(self, spread: f64, basis: String) -> Model {
        Model { spread, basis, ..self }
    }

    fn start(&self, kernel: Kernel) -> f64 {
        self.start.get(&kernel).copied().unwrap_or(0.0)
    }

    /// Rays of a depth for one sample, and whether that was seen.
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

    /// Seconds for each ray of a kernel at a depth: as it was timed there, or at the deepest depth before.
    fn cost(&self, kernel: Kernel, depth: u32) -> Option<f64> {
        self.cost.range((kernel, 0)..=(kernel, depth)).next_back().map(|(_, c)| *c)
    }

    /// The time of `work`.
    ///
    /// # Errors
    /// If nothing is known of kernels that it needs.
    pub fn predict(&self, work: &Work<'_>) -> Result<Prediction, Unpredictable> {
        let Work { plan, pixels, samples, batches } = *work;
        let kernels = plan.kernels();
        let groups = plan.specialisation.light_count.max(1).div_ceil(plan.lights_per_pass.max(1));
        let last = plan.last_depth;
        if last > 1 && self.rays.len() == 1 {
            return Err(Unpredictable("a render of depth 1 says nothing of deeper rays".into()));
        }
        let other = if plan.specialisation.fused != 0 { Kernel::Intersect } else { Kernel::Trace };
        if self.cost.keys().any(|(kernel, _)| *kernel == other) {
            return Err(Unpredictable(format!(
                "what was timed ran `{}`, which this render would not; a trial tells of its kernels",
                other.name()
            )));
        }
        let mut by_depth: Vec<DepthForecast> = Vec::new();
        let (mut device, mut unseen) = (0.0, 0.0);
        for pass in passes::all().filter(|p| kernels.contains(&p.kernel)) {
            let deep = passes::PER_DEPTH.iter().any(|p| p.kernel == pass.kernel);
            let depths = match (deep, pass.when) {
                (false, _) => 0..=0,
                (true, When::NotLast) => 1..=last - 1,
                (true, When::Branching) => 2..=last,
                (true, _) => 1..=last,
            };
            let launches = if pass.when == When::PerLights { groups } else { 1 };
            for depth in depths {
                let (rays, seen) = if depth == 0 { (1.0, true) } else { self.rays(depth, plan) };
                let rays = rays * samples as f64;
                let cost = self.cost(pass.kernel, depth).unwrap_or(0.0);
                let seconds = batches as f64 * f64::from(launches) * self.start(pass.kernel) + rays * cost;
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

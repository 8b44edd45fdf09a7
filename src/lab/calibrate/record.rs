//! What was measured on one scene: one line of the file of records.

use super::judge::{Judgement, Measured};
use super::layer::LayerTrial;
use crate::report::ErrorInfo;
use crate::scene::procedural::families::Family;
use serde::{Deserialize, Serialize};

/// All trials of one scene.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct SceneRecord {
    /// Name of its family.
    pub family: String,
    /// Its number in the family.
    pub number: u32,
    /// Why it could not be measured.
    pub failure: Option<String>,
    /// Truth of complete paths.
    pub truth: TruthRecord,
    /// Truth of paths of the scene's own depth; missing if they are complete.
    pub truth_at_depth: Option<TruthRecord>,
    /// Trials of `--budget`: all seeds of the first sample count, and so on.
    pub budget: Vec<BudgetRecord>,
    /// Trials of `--error`, one entry per error asked for.
    pub error: Vec<ErrorRecord>,
    /// Trials of `--time`.
    pub time: Vec<TimeRecord>,
    /// Seconds that the scene took altogether.
    pub seconds: f64,
}

impl SceneRecord {
    /// `wires:3`; of a scene file, its name.
    pub fn name(&self) -> String {
        match self.family.parse::<Family>() {
            Ok(_) => format!("{}:{}", self.family, self.number),
            Err(_) => self.family.clone(),
        }
    }
}

/// Quality of a truth.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct TruthRecord {
    /// Depth of its paths.
    pub depth: u32,
    /// Throughput below which its paths end.
    pub cutoff: f32,
    /// Samples per pixel of each render.
    pub samples: u32,
    /// Renders, each with a seed of its own.
    pub seeds: u32,
    /// Pixels that may hold something smaller than a pixel, and got more samples.
    pub small_pixels: u64,
    /// Samples of each of these, of each render.
    pub small_samples: u32,
    /// Rays of all renders.
    pub rays: u64,
    /// Its own RMSE, from the spread between the renders.
    pub error: f64,
    /// RMSE sought: a tenth of the smallest error judged.
    pub sought: f64,
    /// RMSE that longer paths may cause.
    pub hidden: f64,
    /// Arithmetic.
    pub precision: String,
}

/// A bound that a render stated: total and parts, RMSE.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Stated {
    /// Sum of the parts; missing if the render stated no bound, or an infinite one.
    pub total: Option<f64>,
    /// Sampling part.
    pub sampling: Option<f64>,
    /// Truncation part.
    pub truncation: Option<f64>,
    /// Rounding part; missing if not compared.
    pub rounding: Option<f64>,
}

/// One render with `--budget`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct BudgetRecord {
    /// Samples per pixel.
    pub samples: u32,
    /// Sampler seed.
    pub seed: u32,
    /// What it stated.
    pub stated: Stated,
    /// True error against complete paths.
    pub error: Measured,
    /// True error against paths of its own depth.
    pub sampling_error: Measured,
    /// Rays traced.
    pub rays: u64,
    /// Seconds from the first submit to the last pixel.
    pub seconds: f64,
    /// True error, at its own depth, of a plain render with the same seed and as many rays.
    pub plain_error: Measured,
    /// Rays of the plain render.
    pub plain_rays: u64,
    /// The layer `sampling` against the errors of the pixels.
    pub layer: LayerTrial,
}

/// Renders with one value of `--error`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorRecord {
    /// RMSE asked for.
    pub target: f64,
    /// One per seed.
    pub trials: Vec<ErrorTrialRecord>,
    /// The cheapest plain render that keeps the error; missing if none was found.
    pub plain: Option<PlainRecord>,
}

/// One render with `--error`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorTrialRecord {
    /// Sampler seed.
    pub seed: u32,
    /// True if it reported success.
    pub met: bool,
    /// Reason that it gave for a failure.
    pub why: Option<String>,
    /// What it stated.
    pub stated: Stated,
    /// True error against complete paths.
    pub error: Measured,
    /// Rays traced.
    pub rays: u64,
    /// Seconds from the first submit to the last pixel, the choice of settings included.
    pub seconds: f64,
    /// Depth chosen.
    pub depth: u32,
}

/// The plain render with the fewest samples that keeps an error in nearly all seeds.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct PlainRecord {
    /// Samples per pixel.
    pub samples: u32,
    /// Rays of one render.
    pub rays: u64,
    /// Median seconds of one render.
    pub seconds: f64,
}

/// One render with `--time`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct TimeRecord {
    /// Seconds asked for.
    pub asked: f64,
    /// Sampler seed.
    pub seed: u32,
    /// Wall seconds.
    pub seconds: f64,
    /// What it stated.
    pub stated: Stated,
    /// True error against complete paths.
    pub error: Measured,
    /// The plain render to compare with; missing if none is that fast.
    pub plain: Option<PlainInTime>,
}

/// The plain render of the scene's own depth with the most samples that fit into a time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PlainInTime {
    /// Samples per pixel.
    pub samples: u32,
    /// Wall seconds.
    pub seconds: f64,
    /// True error against complete paths.
    pub error: Measured,
}

impl Stated {
    /// The finite numbers of a report.
    pub fn of(error: Option<&ErrorInfo>) -> Stated {
        let finite = |x: f64| x.is_finite().then_some(x);
        let Some(error) = error else { return Stated::default() };
        Stated {
            total: finite(error.total),
            sampling: finite(error.sampling),
            truncation: finite(error.truncation),
            rounding: error.rounding.and_then(finite),
        }
    }
}

impl BudgetRecord {
    /// Judges the total bound. A render that states none claims nothing, and is not judged.
    pub fn judge(&self) -> Option<Judgement> {
        Some(self.error.judge(self.stated.total?))
    }

    /// Judges the sampling part alone against the error at the render's own depth, rounding included.
    pub fn judge_sampling(&self) -> Option<Judgement> {
        Some(self.sampling_error.judge(self.stated.sampling?))
    }
}

impl ErrorTrialRecord {
    /// Judges a render that reported success.
    pub fn judge(&self, target: f64) -> Option<Judgement> {
        self.met.then(|| self.error.judge(target))
    }
}

impl ErrorRecord {
    /// Cost of the plain render / cost of `--error`, in rays and in seconds; above 1, `--error` is cheaper.
    pub fn gain(&self) -> Option<[f64; 2]> {
        let plain = self.plain?;
        let middle = |of: &dyn Fn(&ErrorTrialRecord) -> f64| {
            crate::stats::median(&self.trials.iter().filter(|t| t.met).map(of).collect::<Vec<_>>())
        };
        let (rays, seconds) = (middle(&|t| t.rays as f64)?, middle(&|t| t.seconds)?);
        Some([plain.rays as f64 / rays, plain.seconds / seconds])
    }
}

impl TimeRecord {
    /// True error / true error of the plain render.
    pub fn against_plain(&self) -> Option<f64> {
        let plain = self.plain?.error.error();
        (plain > 0.0).then(|| self.error.error() / plain)
    }

    /// Judges the total bound.
    pub fn judge(&self) -> Option<Judgement> {
        Some(self.error.judge(self.stated.total?))
    }
}

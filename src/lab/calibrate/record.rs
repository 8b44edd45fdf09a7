//! The plan of a calibration and its results, as written to JSON.

use super::{BudgetTrial, Coverage, ErrorTrial, TimeTrial, TruthInfo, Uniform};
use crate::report::DeviceInfo;
use crate::stats::median;
use serde::Serialize;

/// Relative lateness up to which a time counts as kept.
const LATE: f64 = 0.05;

/// What to measure.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Plan {
    /// Pixels of every image.
    pub width: u32,
    /// Pixels of every image.
    pub height: u32,
    /// Trials of `--budget` and `--error` per scene and setting; their seeds are 1, 2, ...
    pub seeds: u32,
    /// Timed runs per scene and setting.
    pub runs: u32,
    /// Samples per pixel for `--budget`.
    pub samples: Vec<u32>,
    /// Values of `--error`, RMSE.
    pub errors: Vec<f64>,
    /// Values of `--time`, seconds.
    pub times: Vec<f64>,
    /// Confidence of all error bounds, in (0, 1).
    pub confidence: f64,
}

/// Trials of `--budget` with one number of samples.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BudgetRow {
    /// Samples per pixel.
    pub samples: u32,
    /// One per seed.
    pub trials: Vec<BudgetTrial>,
    /// Edge pixels whose confidence interval contains the truth; empty unless
    /// 16 divides `samples`.
    pub pixels: Coverage,
}

/// Trials of `--error` with one target.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ErrorRow {
    /// RMSE asked for.
    pub target: f64,
    /// One per seed.
    pub trials: Vec<ErrorTrial>,
    /// The uniform render that reaches the same error.
    pub uniform: Uniform,
}

/// Trials of `--time` with one time.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TimeRow {
    /// Seconds asked for.
    pub asked: f64,
    /// One per run.
    pub trials: Vec<TimeTrial>,
}

/// All trials of one scene.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneCalibration {
    /// Name of its file, without folder and extension.
    pub name: String,
    /// Its own depth, used by `--budget`.
    pub depth: u32,
    /// Truth of complete paths; missing if cancelled before.
    pub truth: Option<TruthInfo>,
    /// Truth of paths of the scene's own depth; missing if not needed, or cancelled before.
    pub truth_at_depth: Option<TruthInfo>,
    /// Trials of `--budget`.
    pub budget: Vec<BudgetRow>,
    /// Trials of `--error`.
    pub error: Vec<ErrorRow>,
    /// Trials of `--time`.
    pub time: Vec<TimeRow>,
}

/// All results of a calibration.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Calibration {
    /// Device used.
    pub device: DeviceInfo,
    /// The plan.
    pub plan: Plan,
    /// One per scene.
    pub scenes: Vec<SceneCalibration>,
    /// False if cancelled, with fewer trials than planned.
    pub complete: bool,
}

impl BudgetRow {
    /// Trials whose true error is within the total bound.
    pub fn kept(&self) -> Coverage {
        Coverage::of(self.trials.iter().map(|t| t.kept()))
    }

    /// Trials whose sampling error is within the sampling bound.
    pub fn sampling_kept(&self) -> Coverage {
        Coverage::of(self.trials.iter().map(|t| t.sampling_kept()))
    }
}

impl ErrorRow {
    /// Of the trials that report success, those whose true error is within the target.
    pub fn kept(&self) -> Coverage {
        let promised = self.trials.iter().filter(|t| t.met);
        Coverage::of(promised.map(|t| t.kept(self.target)))
    }

    /// Speed-up of `--error` over the uniform render, in seconds and in rays; above 1, `--error` is
    /// cheaper.
    pub fn speed_up(&self) -> Option<(f64, f64)> {
        let seconds = median(&self.uniform.seconds)? / median(&self.uniform.adaptive_seconds)?;
        let rays = self.uniform.rays as f64
            / median(&self.trials.iter().map(|t| t.rays as f64).collect::<Vec<_>>())?;
        Some((seconds, rays))
    }
}

impl TimeRow {
    /// Trials that were at most 5 % late.
    pub fn on_time(&self) -> Coverage {
        Coverage::of(self.trials.iter().map(|t| t.seconds <= (1.0 + LATE) * self.asked))
    }

    /// Trials whose true error is within the stated bound.
    pub fn kept(&self) -> Coverage {
        Coverage::of(self.trials.iter().map(|t| t.error <= t.total))
    }
}

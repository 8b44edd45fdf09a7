//! What the records of a family say together.

use super::Calibration;
use super::coverage::Coverage;
use super::judge::{Judgement, Measured};
use super::record::{BudgetRecord, ErrorRecord, SceneRecord, TimeRecord};
use crate::stats::{geometric_mean, median};

/// Relative lateness up to which a time counts as kept.
const LATE: f64 = 0.05;

/// Judgements by kind.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Tally {
    /// Bounds that held, out of those that could be decided.
    pub decided: Coverage,
    /// Trials that the truth could not decide.
    pub undecided: u64,
}

impl Tally {
    /// Counts `judgements`.
    pub fn of(judgements: impl IntoIterator<Item = Judgement>) -> Tally {
        judgements.into_iter().fold(Tally::default(), |tally, judgement| match judgement {
            Judgement::Undecided => Tally { undecided: tally.undecided + 1, ..tally },
            decided => {
                Tally { decided: tally.decided.plus(Coverage::of([decided == Judgement::Kept])), ..tally }
            }
        })
    }
}

/// Renders with `--budget` and one number of samples.
#[derive(Debug, Clone, PartialEq)]
pub struct BudgetSummary {
    /// Samples per pixel.
    pub samples: u32,
    /// True error against the total bound.
    pub total: Tally,
    /// Error at the render's own depth against the sampling part.
    pub sampling: Tally,
    /// Median of total bound / true error.
    pub total_ratio: Option<f64>,
    /// Median of sampling part / error at the render's own depth.
    pub sampling_ratio: Option<f64>,
    /// RMSE / RMSE of a plain render of as many rays, geometric mean over the scenes.
    pub against_plain: Option<f64>,
    /// Edge pixels whose interval holds the truth.
    pub edges: Coverage,
    /// Pixels whose interval holds the truth.
    pub pixels: Coverage,
    /// Median rank correlation of interval and error.
    pub correlation: Option<f64>,
}

/// Renders with one value of `--error`.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorSummary {
    /// RMSE asked for.
    pub target: f64,
    /// Renders that reported success.
    pub met: Coverage,
    /// Of these, the ones that kept the error.
    pub kept: Tally,
    /// Median of true error / error asked for.
    pub ratio: Option<f64>,
    /// Rays of the plain render / rays, geometric mean over the scenes.
    pub gain_rays: Option<f64>,
    /// The same in seconds.
    pub gain_seconds: Option<f64>,
    /// Least and greatest gain in rays of a scene.
    pub gain_range: Option<[f64; 2]>,
}

/// Renders with one value of `--time`.
#[derive(Debug, Clone, PartialEq)]
pub struct TimeSummary {
    /// Seconds asked for.
    pub asked: f64,
    /// Renders at most 5 % late.
    pub on_time: Coverage,
    /// RMSE / RMSE of the plain render that fits into the same time, geometric mean.
    pub against_plain: Option<f64>,
    /// Renders at least as good as that, of those that can be decided.
    pub no_worse: Tally,
    /// True error against the total bound.
    pub total: Tally,
}

/// One family, or all.
#[derive(Debug, Clone, PartialEq)]
pub struct FamilySummary {
    /// Name of the family; `all` for all together.
    pub name: String,
    /// Scenes measured.
    pub scenes: usize,
    /// Per number of samples.
    pub budget: Vec<BudgetSummary>,
    /// Per error asked for.
    pub error: Vec<ErrorSummary>,
    /// Per time asked for.
    pub time: Vec<TimeSummary>,
}

impl Calibration {
    /// One summary per family with records, and one of all.
    pub fn summaries(&self) -> Vec<FamilySummary> {
        let all: Vec<&SceneRecord> = self.scenes.iter().filter(|s| s.failure.is_none()).collect();
        let families = all.chunk_by(|a, b| a.family == b.family);
        let mut summaries: Vec<FamilySummary> =
            families.map(|scenes| self.summary(&scenes[0].family, scenes)).collect();
        if summaries.len() > 1 {
            summaries.push(self.summary("all", &all));
        }
        summaries
    }

    fn summary(&self, name: &str, scenes: &[&SceneRecord]) -> FamilySummary {
        let trials = &self.header.trials;
        FamilySummary {
            name: name.to_owned(),
            scenes: scenes.len(),
            budget: trials.samples.iter().map(|samples| budget(*samples, scenes)).collect(),
            error: trials.errors.iter().map(|target| error(*target, scenes)).collect(),
            time: trials.times.iter().map(|asked| time(*asked, scenes)).collect(),
        }
    }
}

fn budget(samples: u32, scenes: &[&SceneRecord]) -> BudgetSummary {
    let of = |scene: &SceneRecord| -> Vec<BudgetRecord> {
        scene.budget.iter().filter(|b| b.samples == samples).cloned().collect()
    };
    let all: Vec<BudgetRecord> = scenes.iter().flat_map(|s| of(s)).collect();
    let against_plain = |scene: &&SceneRecord| {
        let of = of(scene);
        let sum = |f: &dyn Fn(&BudgetRecord) -> f64| of.iter().map(f).sum::<f64>();
        let (own, plain) = (sum(&|b| b.sampling_error.square), sum(&|b| b.plain_error.square));
        (own > 0.0 && plain > 0.0).then(|| (own / plain).sqrt())
    };
    BudgetSummary {
        samples,
        total: Tally::of(all.iter().filter_map(BudgetRecord::judge)),
        sampling: Tally::of(all.iter().filter_map(BudgetRecord::judge_sampling)),
        total_ratio: middle(all.iter().filter_map(|b| ratio(b.stated.total, &b.error))),
        sampling_ratio: middle(all.iter().filter_map(|b| ratio(b.stated.sampling, &b.sampling_error))),
        against_plain: geometric_mean(&scenes.iter().filter_map(against_plain).collect::<Vec<_>>()),
        edges: all.iter().map(|b| b.layer.edges).sum(),
        pixels: all.iter().map(|b| b.layer.all).sum(),
        correlation: middle(all.iter().filter_map(|b| b.layer.correlation)),
    }
}

fn error(target: f64, scenes: &[&SceneRecord]) -> ErrorSummary {
    let of: Vec<&ErrorRecord> = scenes.iter().flat_map(|s| &s.error).filter(|e| e.target == target).collect();
    let all = || of.iter().flat_map(|e| &e.trials);
    let gains: Vec<[f64; 2]> = of.iter().filter_map(|e| e.gain()).collect();
    let gain = |i: usize| geometric_mean(&gains.iter().map(|g| g[i]).collect::<Vec<_>>());
    let rays = || gains.iter().map(|g| g[0]);
    ErrorSummary {
        target,
        met: Coverage::of(all().map(|t| t.met)),
        kept: Tally::of(all().filter_map(|t| t.judge(target))),
        ratio: middle(all().filter(|t| t.met).map(|t| t.error.error() / target)),
        gain_rays: gain(0),
        gain_seconds: gain(1),
        gain_range: (!gains.is_empty())
            .then(|| [rays().fold(f64::INFINITY, f64::min), rays().fold(0.0, f64::max)]),
    }
}

fn time(asked: f64, scenes: &[&SceneRecord]) -> TimeSummary {
    let of: Vec<&TimeRecord> = scenes.iter().flat_map(|s| &s.time).filter(|t| t.asked == asked).collect();
    TimeSummary {
        asked,
        on_time: Coverage::of(of.iter().map(|t| t.seconds <= (1.0 + LATE) * asked)),
        against_plain: geometric_mean(&of.iter().filter_map(|t| t.against_plain()).collect::<Vec<_>>()),
        no_worse: Tally::of(of.iter().filter_map(|t| t.plain.map(|p| t.error.judge(p.error.range()[1])))),
        total: Tally::of(of.iter().filter_map(|t| t.judge())),
    }
}

/// A bound / the error that it bounds; `None` if there is no bound, or no error that the truth could measure.
pub(super) fn ratio(bound: Option<f64>, error: &Measured) -> Option<f64> {
    (error.square > 2.0 * error.deviation && error.square > 0.0).then(|| error.error())?;
    Some(bound? / error.error())
}

fn middle(values: impl Iterator<Item = f64>) -> Option<f64> {
    median(&values.collect::<Vec<f64>>())
}

/// A bound that did not hold.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Failure {
    /// `wires:3`.
    pub(super) scene: String,
    /// The options of the render: `--budget --samples 4 --seed 2`.
    pub(super) options: String,
    /// The bound.
    pub(super) bound: f64,
    /// What it bounds: `total`, `sampling` or `asked`.
    pub(super) part: &'static str,
    pub(super) error: Measured,
}

impl Calibration {
    /// All bounds that did not hold.
    pub(super) fn failures(&self) -> Vec<Failure> {
        let mut failures = Vec::new();
        for scene in &self.scenes {
            let name = scene.name();
            let mut add =
                |judgement: Option<Judgement>, part, options, bound: Option<f64>, error: Measured| {
                    if judgement == Some(Judgement::Broken) {
                        let bound = bound.unwrap_or(f64::NAN);
                        failures.push(Failure { scene: name.clone(), options, bound, part, error });
                    }
                };
            for b in &scene.budget {
                let options = || format!("--budget --samples {} --seed {}", b.samples, b.seed);
                add(b.judge(), "total", options(), b.stated.total, b.error);
                add(b.judge_sampling(), "sampling", options(), b.stated.sampling, b.sampling_error);
            }
            for e in &scene.error {
                for t in &e.trials {
                    let options = format!("--error {} --seed {}", e.target, t.seed);
                    add(t.judge(e.target), "asked", options, Some(e.target), t.error);
                }
            }
            for t in &scene.time {
                let options = format!("--time {} --seed {}", t.asked, t.seed);
                add(t.judge(), "total", options, t.stated.total, t.error);
            }
        }
        failures
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn undecided_trials_are_in_no_share() {
        let tally = Tally::of([Judgement::Kept, Judgement::Undecided, Judgement::Broken, Judgement::Kept]);
        assert_eq!(tally, Tally { decided: Coverage { kept: 2, of: 3 }, undecided: 1 });
    }

    #[test]
    fn a_ratio_needs_an_error_that_was_measured() {
        let measured = |square, deviation| Measured { square, deviation, hidden: 0.0 };
        assert_eq!(ratio(Some(0.02), &measured(1e-4, 1e-6)), Some(2.0));
        assert_eq!(ratio(Some(0.02), &measured(1e-4, 1e-4)), None);
        assert_eq!(ratio(None, &measured(1e-4, 0.0)), None);
    }
}

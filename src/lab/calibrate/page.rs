//! A calibration as a page of Markdown.

use super::{Aim, BudgetRow, Calibration, ErrorRow, SceneCalibration, Share, TimeRow, TruthInfo};
use crate::lab::markdown::{number, table};
use crate::report::table::Align::{Left, Right};
use crate::stats::{geometric_mean, median};
use crate::units;

/// Part of a time that a render may be late by.
const LATE: f64 = 0.05;

impl BudgetRow {
    /// Trials whose true error lies within the budget.
    pub fn kept(&self) -> Share {
        Share::of(self.trials.iter().map(|t| t.kept()))
    }

    /// Trials whose sampling error lies within its part.
    pub fn sampling_kept(&self) -> Share {
        Share::of(self.trials.iter().map(|t| t.sampling_kept()))
    }
}

impl ErrorRow {
    /// Trials that promised, and kept it.
    pub fn kept(&self) -> Share {
        let promised = self.trials.iter().filter(|t| t.met);
        Share::of(promised.map(|t| t.kept(self.target)))
    }

    /// Seconds and rays of the plain render by those of the run to the error; above 1 where the latter is cheaper.
    pub fn gain(&self) -> Option<(f64, f64)> {
        let seconds = median(&self.uniform.seconds)? / median(&self.uniform.adaptive_seconds)?;
        let rays = self.uniform.rays as f64 / middle(self.trials.iter().map(|t| t.rays as f64))?;
        Some((seconds, rays))
    }
}

impl TimeRow {
    /// Trials that were no more than 5 % late.
    pub fn on_time(&self) -> Share {
        Share::of(self.trials.iter().map(|t| t.seconds <= (1.0 + LATE) * self.asked))
    }

    /// Trials whose true error lies within the one stated.
    pub fn kept(&self) -> Share {
        Share::of(self.trials.iter().map(|t| t.error <= t.total))
    }
}

fn middle(values: impl Iterator<Item = f64>) -> Option<f64> {
    median(&values.collect::<Vec<f64>>())
}

fn figure(x: Option<f64>) -> String {
    x.map_or("-".into(), |x| if x.is_infinite() { "no error".into() } else { number(x) })
}

/// A bound by the error that it bounds.
fn ratio(bound: f64, error: f64) -> f64 {
    if error > 0.0 { bound / error } else { f64::INFINITY }
}

impl Calibration {
    /// The page; `command` is what made it.
    pub fn page(&self, command: &str) -> String {
        let sections =
            [self.head(command), self.budget(), self.pixels(), self.error(), self.time(), self.truths()];
        sections.into_iter().filter(|s| !s.is_empty()).collect::<Vec<_>>().join("\n")
    }

    fn head(&self, command: &str) -> String {
        let (d, p) = (&self.device, &self.plan);
        let percent = units::number(100.0 * p.confidence);
        let software = match d.kind.as_str() {
            "cpu" => {
                "\nThe device is a CPU driver: its times, and what is gained in time, are its own and say nothing of a GPU.\n"
            }
            _ => "",
        };
        let part = match self.complete {
            true => "",
            false => "\n**Interrupted**: fewer trials than planned; the tables say how many there are.\n",
        };
        format!(
            "# How often the promises are kept\n\n\
Written by\n\n    {command}\n\n\
on {} ({}), {}, Vulkan {}.\n{software}{part}\n\
Images of {} x {} pixels, {percent} % confidence, up to {} seeds for each scene and setting. Errors are RMSE in linear light from 0 to 1, \
against a truth in f64 (last table). A share is that of all trials in a row; its verdict stands beside it, with a question mark where \
so few trials cannot tell it from one within the aim. BELOW: the promise is not kept as often as it says. Above: the bound is wider \
than it need be.\n",
            d.name, d.kind, d.driver, d.api, p.width, p.height, p.seeds
        )
    }

    fn rows<'a, R: 'a>(
        &'a self,
        of: impl Fn(&'a SceneCalibration) -> &'a [R] + 'a,
    ) -> impl Iterator<Item = (&'a str, &'a R)> {
        self.scenes.iter().flat_map(move |s| of(s).iter().map(move |r| (s.name.as_str(), r)))
    }

    fn budget(&self) -> String {
        let (aim, whole) = (Aim::of(self.plan.confidence), Aim::at_least(self.plan.confidence));
        let columns = [
            ("scene", Left),
            ("samples", Right),
            ("error", Right),
            ("error within total", Right),
            ("verdict", Left),
            ("sampling error within its part", Right),
            ("verdict", Left),
            ("part / error", Right),
        ];
        let row = |name: &str, rows: &[&BudgetRow]| {
            let trials = || rows.iter().flat_map(|r| &r.trials);
            let kept: Share = rows.iter().map(|r| r.kept()).sum();
            let sampling: Share = rows.iter().map(|r| r.sampling_kept()).sum();
            [
                name.to_owned(),
                rows[0].samples.to_string(),
                figure(middle(trials().map(|t| t.error))),
                kept.to_string(),
                whole.say(kept),
                sampling.to_string(),
                aim.say(sampling),
                figure(middle(trials().map(|t| ratio(t.sampling, t.sampling_error)))),
            ]
        };
        let mut lines = Vec::new();
        for samples in &self.plan.samples {
            let all: Vec<_> = self.rows(|s| &s.budget).filter(|(_, r)| r.samples == *samples).collect();
            all.iter().for_each(|(name, r)| lines.push(row(name, &[r])));
            // Where nothing errs the bound holds always, and says nothing of it.
            let erring: Vec<&BudgetRow> = all.iter().map(|(_, r)| *r).filter(|r| errs(r)).collect();
            if !erring.is_empty() {
                lines.push(row("**all that err**", &erring));
            }
        }
        if lines.is_empty() {
            return String::new();
        }
        format!(
            "## An image and its budget: `--budget`\n\n\
Total: sampling, truncation and rounding parts, against paths followed to their ends. Truncation is a certificate, so the total may \
hold always. Sampling: against paths of the scene's own depth in f64. Errors and ratios are medians.\n\n{}",
            table(&columns, &lines)
        )
    }

    fn pixels(&self) -> String {
        let aim = Aim::of(self.plan.confidence);
        let columns = [("samples", Right), ("edge pixels within their intervals", Right), ("verdict", Left)];
        let mut lines = Vec::new();
        for samples in &self.plan.samples {
            let all = self.rows(|s| &s.budget).filter(|(_, r)| r.samples == *samples);
            let share: Share = all.map(|(_, r)| r.pixels).sum();
            if share.of > 0 {
                lines.push([samples.to_string(), share.to_string(), aim.say(share)]);
            }
        }
        if lines.is_empty() {
            return String::new();
        }
        format!(
            "## A pixel's interval: `--aov sampling`\n\n\
Pixels whose samples took different ways, with 16 replicates; the widest channel's interval against the truth at the scene's own \
depth.\n\n{}",
            table(&columns, &lines)
        )
    }

    fn error(&self) -> String {
        let aim = Aim::of(self.plan.confidence);
        let columns = [
            ("scene", Left),
            ("asked for", Right),
            ("promised", Right),
            ("kept", Right),
            ("verdict", Left),
            ("error / asked for", Right),
            ("stated / asked for", Right),
            ("depth", Right),
            ("samples", Right),
            ("plain samples", Right),
            ("gain in time", Right),
            ("in rays", Right),
        ];
        let mut lines = Vec::new();
        let mut gains = (Vec::new(), Vec::new());
        for target in &self.plan.errors {
            let all: Vec<_> = self.rows(|s| &s.error).filter(|(_, r)| r.target == *target).collect();
            for (name, r) in &all {
                let promised = Share::of(r.trials.iter().map(|t| t.met));
                let factor = |x: f64| format!("x{x:.2}");
                let gain = r.gain();
                if let Some((seconds, rays)) = gain {
                    gains.0.push(seconds);
                    gains.1.push(rays);
                }
                lines.push([
                    (*name).to_owned(),
                    units::number(*target),
                    promised.to_string(),
                    r.kept().to_string(),
                    aim.say(r.kept()),
                    figure(middle(r.trials.iter().map(|t| t.error / target))),
                    figure(middle(r.trials.iter().map(|t| t.total / target))),
                    figure(middle(r.trials.iter().map(|t| f64::from(t.depth)))),
                    figure(middle(r.trials.iter().map(|t| t.samples))),
                    r.uniform.samples.map_or("-".into(), |n| n.to_string()),
                    gain.map_or("-".into(), |g| factor(g.0)),
                    gain.map_or("-".into(), |g| factor(g.1)),
                ]);
            }
            let kept: Share = all.iter().map(|(_, r)| r.kept()).sum();
            if kept.of > 0 {
                let mut line: [String; 12] = std::array::from_fn(|_| String::new());
                line[0] = "**all**".into();
                line[1] = units::number(*target);
                line[3] = kept.to_string();
                line[4] = aim.say(kept);
                let all = all.iter().flat_map(|(_, r)| &r.trials);
                line[5] = figure(middle(all.map(|t| t.error / target)));
                lines.push(line);
            }
        }
        if lines.is_empty() {
            return String::new();
        }
        let gain = match (geometric_mean(&gains.0), geometric_mean(&gains.1)) {
            (Some(seconds), Some(rays)) => {
                format!("\nGain over all rows, geometric mean: x{seconds:.2} in time, x{rays:.2} in rays.\n")
            }
            _ => String::new(),
        };
        format!(
            "## An image to an error: `--error`\n\n\
Kept: of the runs that say they reached the error, those that did. The plain render has as many samples everywhere, one Owen-scrambled \
sequence a pixel, and the depth, cut and precision that the other chose: the fewest samples (1, 2, 3, 4, 6, 8, 12 ...) whose true error is \
below the one asked for in 95 % of up to 20 seeds. It knows nothing of its error, nor which depth to take: it is told. Gain: its cost by \
that of the run to the error, above 1 where the latter is cheaper. Time is that from the first submit to the last pixel, \
measured in turn, the choice of depth and the comparison with f64 included; the rays are without that comparison. Other figures \
are medians.\n\n{}{gain}",
            table(&columns, &lines)
        )
    }

    fn time(&self) -> String {
        let aim = Aim::at_least(self.plan.confidence);
        let columns = [
            ("scene", Left),
            ("seconds", Right),
            ("at most 5 % late", Right),
            ("verdict", Left),
            ("latest", Right),
            ("used", Right),
            ("error reached", Right),
            ("error within total", Right),
            ("verdict", Left),
        ];
        let mut lines = Vec::new();
        for (name, r) in self.rows(|s| &s.time) {
            let on_time = r.on_time();
            let latest = r.trials.iter().map(|t| t.seconds / r.asked - 1.0).fold(f64::NEG_INFINITY, f64::max);
            let verdict = match on_time.of {
                0 => "not tried",
                n if on_time.kept == n => "never late: kept",
                _ => "never late: NOT KEPT",
            };
            lines.push([
                name.to_owned(),
                units::number(r.asked),
                on_time.to_string(),
                verdict.into(),
                if latest.is_finite() { format!("{:+.1} %", 100.0 * latest) } else { "-".into() },
                middle(r.trials.iter().map(|t| t.seconds / r.asked))
                    .map_or("-".into(), |x| format!("{:.0} %", 100.0 * x)),
                figure(middle(r.trials.iter().map(|t| t.error))),
                r.kept().to_string(),
                aim.say(r.kept()),
            ]);
        }
        if lines.is_empty() {
            return String::new();
        }
        format!(
            "## An image in a time: `--time`\n\n\
From the call to the image and its budget, in one process, with kernels warm. Figures are medians but the latest.\n\n{}",
            table(&columns, &lines)
        )
    }

    fn truths(&self) -> String {
        let columns = [
            ("scene", Left),
            ("paths", Left),
            ("depth", Right),
            ("cut below", Right),
            ("samples", Right),
            ("standard error", Right),
            ("not traced, at most", Right),
            ("smallest error judged", Right),
            ("in", Left),
        ];
        let mut lines = Vec::new();
        for s in &self.scenes {
            let line = |truth: &TruthInfo, what: &str, least: f64| {
                [
                    s.name.clone(),
                    what.to_owned(),
                    truth.depth.to_string(),
                    number(f64::from(truth.cutoff)),
                    number(truth.samples.round()),
                    number(truth.standard_error),
                    number(truth.hidden),
                    if least.is_finite() { number(least) } else { "-".into() },
                    truth.precision.to_owned(),
                ]
            };
            let least = |all: &mut dyn Iterator<Item = f64>| all.fold(f64::INFINITY, f64::min);
            let budgets = || s.budget.iter().flat_map(|r| &r.trials);
            if let Some(truth) = &s.truth {
                let errors = s.error.iter().flat_map(|r| &r.trials).map(|t| t.error);
                let times = s.time.iter().flat_map(|r| &r.trials).map(|t| t.error);
                let judged = least(&mut errors.chain(times).chain(budgets().map(|t| t.error)));
                lines.push(line(truth, "to their ends", judged));
            }
            if let Some(truth) = &s.truth_at_depth {
                let judged = least(&mut budgets().map(|t| t.sampling_error));
                lines.push(line(truth, "of the scene's depth", judged));
            }
        }
        if lines.is_empty() {
            return String::new();
        }
        format!("## The truths\n\n{}", table(&columns, &lines))
    }
}

/// Some trial is wrong by more than rounding.
fn errs(row: &BudgetRow) -> bool {
    row.trials.iter().any(|t| t.sampling_error > 1e-5)
}

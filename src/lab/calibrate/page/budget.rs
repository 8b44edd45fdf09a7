//! Tables of `--budget`: whole images, and single pixels.

use super::{figure, middle};
use crate::lab::calibrate::{Aim, BudgetRow, Calibration, Coverage};
use crate::lab::markdown::table;
use crate::report::table::Align::{Left, Right};

impl Calibration {
    pub(super) fn budget(&self) -> String {
        let (aim, whole) = (Aim::of(self.plan.confidence), Aim::at_least(self.plan.confidence));
        let columns = [
            ("scene", Left),
            ("samples", Right),
            ("RMSE", Right),
            ("RMSE within total bound", Right),
            ("verdict", Left),
            ("sampling error within its bound", Right),
            ("verdict", Left),
            ("bound / sampling error", Right),
        ];
        let row = |name: &str, rows: &[&BudgetRow]| {
            let trials = || rows.iter().flat_map(|r| &r.trials);
            let kept: Coverage = rows.iter().map(|r| r.kept()).sum();
            let sampling: Coverage = rows.iter().map(|r| r.sampling_kept()).sum();
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
            // Scenes without error say nothing about the bound.
            let wrong: Vec<&BudgetRow> = all.iter().map(|(_, r)| *r).filter(|r| has_error(r)).collect();
            if !wrong.is_empty() {
                lines.push(row("**all with errors**", &wrong));
            }
        }
        if lines.is_empty() {
            return String::new();
        }
        format!(
            "## Error of a given render: `--budget`\n\n\
The total bound (sampling + truncation + rounding) is compared with the error against complete paths. The truncation bound is not \
statistical, so the total may hold always. The sampling bound is compared with the error against f64 paths of the scene's own depth. \
RMSE and ratios are medians.\n\n{}",
            table(&columns, &lines)
        )
    }

    pub(super) fn pixels(&self) -> String {
        let aim = Aim::of(self.plan.confidence);
        let columns =
            [("samples", Right), ("edge pixels whose interval holds the truth", Right), ("verdict", Left)];
        let mut lines = Vec::new();
        for samples in &self.plan.samples {
            let all = self.rows(|s| &s.budget).filter(|(_, r)| r.samples == *samples);
            let share: Coverage = all.map(|(_, r)| r.pixels).sum();
            if share.of > 0 {
                lines.push([samples.to_string(), share.to_string(), aim.say(share)]);
            }
        }
        if lines.is_empty() {
            return String::new();
        }
        format!(
            "## Confidence interval of a pixel: `--aov sampling`\n\n\
Edge pixels are those whose samples took different paths. The interval is that of the widest channel; the truth \
has the scene's own depth.\n\n{}",
            table(&columns, &lines)
        )
    }
}

/// A bound / the error that it bounds.
fn ratio(bound: f64, error: f64) -> f64 {
    if error > 0.0 { bound / error } else { f64::INFINITY }
}

/// True if some trial has an error larger than rounding.
fn has_error(row: &BudgetRow) -> bool {
    row.trials.iter().any(|t| t.sampling_error > 1e-5)
}

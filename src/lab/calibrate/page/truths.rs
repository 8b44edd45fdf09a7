//! Table of the truths that errors are measured against.

use crate::lab::calibrate::{Calibration, TruthInfo};
use crate::lab::markdown::{number, table};
use crate::report::table::Align::{Left, Right};

impl Calibration {
    pub(super) fn truths(&self) -> String {
        let columns = [
            ("scene", Left),
            ("paths", Left),
            ("depth", Right),
            ("cutoff", Right),
            ("samples per pixel", Right),
            ("standard error", Right),
            ("truncation, at most", Right),
            ("smallest error compared", Right),
            ("precision", Left),
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
                let smallest = least(&mut errors.chain(times).chain(budgets().map(|t| t.error)));
                lines.push(line(truth, "complete", smallest));
            }
            if let Some(truth) = &s.truth_at_depth {
                let smallest = least(&mut budgets().map(|t| t.sampling_error));
                lines.push(line(truth, "scene's depth", smallest));
            }
        }
        if lines.is_empty() {
            return String::new();
        }
        format!("## The truths\n\n{}", table(&columns, &lines))
    }
}

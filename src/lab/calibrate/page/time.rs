//! Table of `--time`.

use super::{figure, middle};
use crate::lab::calibrate::{Aim, Calibration};
use crate::lab::markdown::table;
use crate::report::table::Align::{Left, Right};
use crate::units;

impl Calibration {
    pub(super) fn time(&self) -> String {
        let aim = Aim::at_least(self.plan.confidence);
        let columns = [
            ("scene", Left),
            ("seconds asked for", Right),
            ("at most 5 % late", Right),
            ("verdict", Left),
            ("latest", Right),
            ("time used", Right),
            ("RMSE", Right),
            ("RMSE within bound", Right),
            ("verdict", Left),
        ];
        let mut lines = Vec::new();
        for (name, r) in self.rows(|s| &s.time) {
            let on_time = r.on_time();
            let latest = r.trials.iter().map(|t| t.seconds / r.asked - 1.0).fold(f64::NEG_INFINITY, f64::max);
            let verdict = match on_time.of {
                0 => "not tried",
                n if on_time.kept == n => "kept",
                _ => "NOT KEPT",
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
            "## Render in a time: `--time`\n\n\
Wall time from the call to the image and its error bound, in one process with compiled kernels. Figures are medians, except for the \
latest.\n\n{}",
            table(&columns, &lines)
        )
    }
}

//! Table of `--error`.

use super::{figure, middle};
use crate::lab::calibrate::{Aim, Calibration, Coverage};
use crate::lab::markdown::table;
use crate::report::table::Align::{Left, Right};
use crate::stats::geometric_mean;
use crate::units;

impl Calibration {
    pub(super) fn error(&self) -> String {
        let aim = Aim::of(self.plan.confidence);
        let columns = [
            ("scene", Left),
            ("error asked for", Right),
            ("reported success", Right),
            ("of these, kept", Right),
            ("verdict", Left),
            ("true error / asked for", Right),
            ("bound / asked for", Right),
            ("depth", Right),
            ("samples", Right),
            ("uniform samples", Right),
            ("speed-up, time", Right),
            ("speed-up, rays", Right),
        ];
        let mut lines = Vec::new();
        let mut gains = (Vec::new(), Vec::new());
        for target in &self.plan.errors {
            let all: Vec<_> = self.rows(|s| &s.error).filter(|(_, r)| r.target == *target).collect();
            for (name, r) in &all {
                let reported = Coverage::of(r.trials.iter().map(|t| t.met));
                let factor = |x: f64| format!("x{x:.2}");
                let gain = r.speed_up();
                if let Some((seconds, rays)) = gain {
                    gains.0.push(seconds);
                    gains.1.push(rays);
                }
                lines.push([
                    (*name).to_owned(),
                    units::number(*target),
                    reported.to_string(),
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
            let kept: Coverage = all.iter().map(|(_, r)| r.kept()).sum();
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
                format!(
                    "\nSpeed-up over all rows, geometric mean: x{seconds:.2} in time, x{rays:.2} in rays.\n"
                )
            }
            _ => String::new(),
        };
        format!(
            "## Render to an error: `--error`\n\n\
Kept: runs whose true error is within the error asked for, out of those that report success. The comparison is a uniform render: the \
same number of samples in every pixel, one Owen-scrambled sequence per pixel, and the depth, cutoff and precision that `--error` \
chose. Its sample count is the smallest (of 1, 2, 3, 4, 6, 8, 12 ...) whose true error is within the target for 95 % of up to 20 seeds; \
a user would not know that count, nor the depth, in advance. Speed-up: cost of the uniform render / cost of `--error`; above 1, \
`--error` is cheaper. Time runs from the first submit to the last pixel, measured in turn, and includes the choice of depth and the \
comparison with f64; rays exclude that comparison. Other figures are medians.\n\n{}{gain}",
            table(&columns, &lines)
        )
    }
}

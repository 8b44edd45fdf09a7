//! How often a bound held, compared with how often its confidence says it should.

use crate::accuracy::interval::{self, Interval};
use serde::{Deserialize, Serialize};

/// A bound that held in `kept` out of `of` trials.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Coverage {
    /// Trials in which it held.
    pub kept: u64,
    /// All trials.
    pub of: u64,
}

/// A share compared with its [`Aim`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// No trial.
    Untried,
    /// Held less often than claimed.
    Below,
    /// Held as often as claimed.
    Within,
    /// Held more often: the bound is wider than necessary.
    Above,
}

/// The range in which a share should lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aim {
    /// Least share.
    pub low: f64,
    /// Greatest share; 1 if the bound may always hold.
    pub high: f64,
}

impl Aim {
    /// For a bound that should hold with `confidence`, neither less often nor nearly always: at 95
    /// %, from 93.5 % (3 binomial standard errors of 2000 trials below) to 99 % (a fifth of the
    /// allowed failures).
    pub fn of(confidence: f64) -> Aim {
        let risk = 1.0 - confidence;
        Aim { low: 1.0 - 1.3 * risk, high: 1.0 - 0.2 * risk }
    }

    /// For a bound that is partly not statistical and may always hold.
    pub fn at_least(confidence: f64) -> Aim {
        Aim { high: 1.0, ..Aim::of(confidence) }
    }

    /// Compares the share itself, whatever the number of trials.
    pub fn judge(&self, share: Coverage) -> Verdict {
        match share.value() {
            x if x.is_nan() => Verdict::Untried,
            x if x < self.low => Verdict::Below,
            x if x > self.high => Verdict::Above,
            _ => Verdict::Within,
        }
    }

    /// True if the confidence interval of the share overlaps the aim.
    pub fn may_be_chance(&self, share: Coverage) -> bool {
        let Interval { low, high, .. } = share.interval();
        low <= self.high && high >= self.low
    }

    /// True if the share is significantly below the aim.
    pub fn missed(&self, share: Coverage) -> bool {
        self.judge(share) == Verdict::Below && !self.may_be_chance(share)
    }

    /// For people: `aim 93.5-99 %: above?`, with a question mark if it may be chance.
    pub fn say(&self, share: Coverage) -> String {
        let percent = |x: f64| crate::units::number((x * 1e4).round() / 100.0);
        let aim = match self.high < 1.0 {
            true => format!("aim {}-{} %", percent(self.low), percent(self.high)),
            false => format!("aim {} % or more", percent(self.low)),
        };
        let word = match self.judge(share) {
            Verdict::Untried => return format!("{aim}: no trial"),
            Verdict::Within => return format!("{aim}: within"),
            Verdict::Below => "BELOW",
            Verdict::Above => "above",
        };
        let chance = if self.may_be_chance(share) { "?" } else { "" };
        format!("{aim}: {word}{chance}")
    }
}

impl Coverage {
    /// Counts `trials` by whether each held.
    pub fn of(trials: impl IntoIterator<Item = bool>) -> Coverage {
        trials
            .into_iter()
            .fold(Coverage::default(), |s, held| Coverage { kept: s.kept + u64::from(held), of: s.of + 1 })
    }

    /// The trials of both together.
    pub fn plus(self, other: Coverage) -> Coverage {
        Coverage { kept: self.kept + other.kept, of: self.of + other.of }
    }

    /// From 0 to 1; NaN without trials.
    pub fn value(&self) -> f64 {
        self.kept as f64 / self.of as f64
    }

    /// 95 % confidence interval of the true share (Wilson).
    pub fn interval(&self) -> Interval {
        interval::wilson(self.value(), u32::try_from(self.of).unwrap_or(u32::MAX), 0.95)
    }
}

impl std::iter::Sum for Coverage {
    fn sum<I: Iterator<Item = Coverage>>(all: I) -> Coverage {
        all.fold(Coverage::default(), Coverage::plus)
    }
}

impl std::fmt::Display for Coverage {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.of {
            0 => write!(out, "-"),
            n => write!(out, "{}/{n} = {:.1} %", self.kept, 100.0 * self.value()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn aims_are_those_of_the_confidence() {
        let aim = Aim::of(0.95);
        assert!((aim.low - 0.935).abs() < 1e-12 && (aim.high - 0.99).abs() < 1e-12);
        let said = |kept, of| aim.say(Coverage { kept, of });
        assert_eq!(said(960, 1000), "aim 93.5-99 %: within");
        assert_eq!(said(1000, 1000), "aim 93.5-99 %: above");
        assert_eq!(said(20, 20), "aim 93.5-99 %: above?");
        assert_eq!(said(18, 20), "aim 93.5-99 %: BELOW?");
        assert_eq!(said(900, 1000), "aim 93.5-99 %: BELOW");
        assert_eq!(said(0, 0), "aim 93.5-99 %: no trial");
        assert!(aim.missed(Coverage { kept: 900, of: 1000 }) && !aim.missed(Coverage { kept: 18, of: 20 }));
        assert_eq!(Aim::at_least(0.95).say(Coverage { kept: 20, of: 20 }), "aim 93.5 % or more: within");
    }

    #[test]
    fn shares_add_up() {
        let a = Coverage::of([true, false, true]);
        assert_eq!(a.plus(Coverage::of([true])), Coverage { kept: 3, of: 4 });
        assert_eq!(a.to_string(), "2/3 = 66.7 %");
    }
}

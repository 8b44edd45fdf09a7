//! `--error`: the cheapest samples, depth and precision whose three parts come to the error asked for.

use super::cut::{self, Cut};
use super::known::Known;
use super::rounded::Rounded;
use super::traced::{Part, Region, Tracing};
use super::{DEEPEST, MOST_SAMPLES, REPLICATES, Task};
use crate::measure::allocate::{Allocation, Goal, Outcome};
use crate::measure::samples::Source;
use crate::render::{RenderError, Survey};
use crate::settings::{Precision, Settings};
use std::time::Instant;

/// Share of the risk that the rounding part may be underestimated; the rest is the sampling part's.
const ROUNDING_RISK: f64 = 0.1;
/// Share of the error that a precision may take, if a better one is there.
const ROUNDING_SHARE: f64 = 0.25;
/// The rounding part is looked for in so many samples that what none of them shows is about a tenth of the
/// error: `-ln(risk) / (0.1^2 * 16 samples)` over its square.
const ROUNDING_SAMPLES: f64 = 40.0;
/// Share of the error that the rounding part may take without being looked for in more samples.
const ROUNDING_SMALL: f64 = 0.12;
/// Least share of the error that is left to sampling; where more is lost to a cut, a deeper one is taken.
const LEAST_SAMPLING: f64 = 0.3;

impl Task<'_> {
    /// Renders until the error is at most `target`, or says why it cannot be.
    pub(super) fn until_error(mut self, target: f64) -> Result<Known, RenderError> {
        let depth = if self.request.keep_depth { self.settings.depth } else { DEEPEST };
        self.settings = Settings { replicates: REPLICATES, depth, ..self.settings };
        let mut survey = Survey::new(self.renderer, self.scene, &self.settings)?;
        let start = Instant::now();
        let mut rounded = self.precision_for(&mut survey, target)?;
        // Cuts are chosen from few pixels: if the image loses more than they did, choose again for less.
        let mut tried = 0;
        let mut last = false;
        let (allocation, why) = loop {
            let cut = self.cut_for(&mut survey, target, tried)?;
            survey.cut_at(cut.depth, cut.cutoff);
            let (allocation, retry) = self.sample(&mut survey, target, rounded.as_ref(), !last)?;
            if !retry {
                break (allocation, self.why_not(&cut, target, rounded.as_ref()));
            }
            tried = cut.depth;
            last = tried >= DEEPEST;
        };
        let confidence = self.request.confidence;
        let image = allocation.gathered().clone();
        let rounding = rounded.take().map(|r| (r.part(&image), r.pixels));
        let capped = allocation.outcome() == Outcome::Capped;
        let prepared = survey.prepared;
        let mut known = self.known_with(image, survey, None, rounding, prepared, start.elapsed())?;
        let met = known.done == 1.0
            && known.report.error.as_ref().is_some_and(|e| e.rounding.is_some() && e.total <= target);
        known.report.asked.error = Some(target);
        known.report.asked.met = Some(met);
        known.report.asked.unmet_why = (!met).then(|| {
            if known.cancelled {
                "it was interrupted".to_owned()
            } else if let Some(why) = why {
                why
            } else if capped {
                format!("some pixels need more than {MOST_SAMPLES} samples")
            } else if known.report.error.as_ref().is_some_and(|e| e.rounding.is_none()) {
                "the rounding part is not known: this device has no f64 to compare with".to_owned()
            } else {
                format!("what it takes at {:.0} % confidence was not reached", 100.0 * confidence)
            }
        });
        Ok(known)
    }

    /// The rounding part; in f64 where single precision takes too much of the error.
    fn precision_for(&mut self, survey: &mut Survey, target: f64) -> Result<Option<Rounded>, RenderError> {
        let whole = u64::from(Region::of(&self.settings).pixels()) * u64::from(REPLICATES);
        // Edges of less than full contrast need less looking. Each look has its part of the risk.
        let looks = [16, 4, 1];
        let risk = (1.0 - self.request.confidence) * ROUNDING_RISK / looks.len() as f64;
        let most = (ROUNDING_SAMPLES * -risk.ln() / 6.4 / (target * target)).min(whole as f64) as u64;
        // Looked at where paths are not yet cut late: a deep path is a rare one, and as rarely rounded.
        survey.cut_at(self.settings.depth.min(8), self.settings.cutoff);
        let mut rounded = None;
        for share in looks {
            rounded = self.rounded(survey, most / share, risk)?;
            if rounded.is_none_or(|r| r.part_at(16.0) < ROUNDING_SMALL * target) || self.observer.cancelled()
            {
                break;
            }
        }
        let too_much = rounded.is_some_and(|r| r.part_at(16.0) > ROUNDING_SHARE * target);
        if too_much && !self.request.keep_precision && survey.precision() != Precision::Double {
            self.settings.precision = Precision::Double;
            *survey = Survey::new(self.renderer, self.scene, &self.settings)?;
            return Ok(Some(Rounded::default()));
        }
        Ok(rounded)
    }

    fn cut_for(&mut self, survey: &mut Survey, target: f64, after: u32) -> Result<Cut, RenderError> {
        let region = Region::of(&self.settings);
        let mut tracing = Tracing { survey, region, observer: self.observer };
        if self.request.keep_depth {
            return cut::look(
                &mut tracing,
                &self.limit,
                self.settings.depth,
                self.settings.cutoff,
                cut::PIXELS,
            );
        }
        cut::for_error(&mut tracing, &self.limit, target, after)
    }

    /// Samples until the sum of the parts is the target; true if the cut loses so much that another should
    /// be taken.
    fn sample(
        &mut self,
        survey: &mut Survey,
        target: f64,
        rounded: Option<&Rounded>,
        may_retry: bool,
    ) -> Result<(Allocation, bool), RenderError> {
        let region = Region::of(&self.settings);
        let confidence = self.sampling_confidence();
        let goal =
            Goal::for_target(target, confidence, region.pixels() as usize, REPLICATES as usize, MOST_SAMPLES);
        let mut allocation = Allocation::new(region.width, region.height, REPLICATES as usize, goal);
        allocation.aim_at(0.0);
        while let Some(step) = allocation.next_step(f64::INFINITY) {
            let done = allocation.samples();
            let step_samples = step.pixels.len() as u64 * u64::from(step.samples.end - step.samples.start);
            let ahead = ahead(&allocation, step_samples);
            let mut observer = Part::of(self.observer, done, ahead);
            let mut tracing = Tracing { survey, region, observer: &mut observer };
            let traced = tracing.trace(&step.pixels, step.samples.clone())?;
            if traced.marks.len() < step.pixels.len() {
                // Cut short: of a pilot, what there is; else the image before it is the better one.
                if allocation.bound().is_none() {
                    allocation.record_part(&step, &traced);
                }
                break;
            }
            allocation.record(&step, &traced);
            let image = allocation.gathered();
            let hidden = image.truncation(&self.limit).rms;
            let rounding = rounded.map_or(0.0, |r| r.part(image));
            let left = target - hidden - rounding;
            if may_retry
                && !self.request.keep_depth
                && left < LEAST_SAMPLING * target
                && hidden > 0.1 * target
            {
                return Ok((allocation, true));
            }
            // Where the rest is too much already, sample as if it were half.
            allocation.aim_at(if left > 0.0 { left } else { 0.5 * target });
            if self.observer.cancelled() {
                break;
            }
        }
        Ok((allocation, false))
    }

    /// What of the confidence is the sampling part's.
    pub(super) fn sampling_confidence(&self) -> f64 {
        1.0 - (1.0 - self.request.confidence) * (1.0 - ROUNDING_RISK)
    }

    fn why_not(&self, cut: &Cut, target: f64, rounded: Option<&Rounded>) -> Option<String> {
        let rounding = rounded.map_or(0.0, |r| r.part_at(f64::from(MOST_SAMPLES)));
        if cut.hidden >= target {
            let why = match &self.limit.unbounded {
                Some(why) => format!("light of rays that are not traced has no bound: {why}"),
                None => format!("at depth {} they may hide {:.2e}", cut.depth, cut.hidden),
            };
            return Some(format!("rays that are not traced may hide more than was asked for: {why}"));
        }
        (rounding >= target)
            .then(|| format!("rounding alone comes to {rounding:.2e}; try --precision f64 or a larger error"))
    }
}

/// Samples to expect in all, for the progress: they go with the -4/3 power of the error.
fn ahead(allocation: &Allocation, step: u64) -> u64 {
    let done = allocation.samples() + step;
    match (allocation.bound(), allocation.goal().target) {
        (Some(now), Some(target)) if target > 0.0 && now.bound > target => {
            let factor = (now.bound / target).powf(4.0 / 3.0).min(1e6);
            ((allocation.samples() as f64 * factor) as u64).max(done)
        }
        _ => done,
    }
}

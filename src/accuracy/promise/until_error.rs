//! `--error`: the cheapest samples, depth and precision whose parts come to the error asked for.

use super::bounded_image::{BoundedImage, Image};
use super::longer_paths::Measured;
use super::resume_state::{Begun, Bounded, Chosen, Stage, options};
use super::rounding::RoundingEstimate;
use super::traced::{Region, Tracing};
use super::truncation_choice::{self, CUT_SAMPLES, TruncationChoice};
use super::{DEEPEST, LOOK_SAMPLES, MOST_SAMPLES, Task};
use crate::accuracy::allocate::{Allocation, Goal, Outcome, Refusal};
use crate::accuracy::pixel_sums::PixelSums;
use crate::accuracy::radiance_bound::RadianceLimit;
use crate::image::{Bits, View};
use crate::render::{Observer, RenderError, ResumeState, Survey};
use crate::report::{ErrorInfo, TimeInfo};
use crate::scene::Material;
use crate::settings::{Precision, Settings};
use std::time::Instant;

/// Share of the error that a precision may take, if a better one is there.
const ROUNDING_SHARE: f64 = 0.25;
/// Share of the error that a file of 8 bits may take, if one of 16 can be written.
const ENCODING_SHARE: f64 = 0.1;
/// Least share of the error that is left to sampling; where more is lost to a cut, a deeper one is taken.
const LEAST_SAMPLING: f64 = 0.3;

/// Share of the progress that the choice of precision and of cuts stands for.
const CHOICE: f64 = 0.08;

impl Task<'_> {
    /// Renders until the error is at most `target`, or says why it cannot be.
    pub(super) fn until_error(
        mut self,
        target: f64,
        earlier: Option<ResumeState<Bounded>>,
    ) -> Result<BoundedImage, RenderError> {
        let depth = if self.request.keep_depth { self.settings.depth } else { DEEPEST };
        self.settings = Settings { replicates: 1, depth, ..self.settings };
        let asked = self.settings.clone();
        let mut survey = self.survey(&asked)?;
        let identity = survey.identity(&asked, options(&self.request));
        self.took.start = Instant::now();
        let (mut chosen, before) = match earlier {
            Some(state) => {
                let (samples, before) = survey.take_up(state, &identity)?;
                (samples.into_chosen(self.caps.clone())?, before)
            }
            None => (self.begin(&mut survey, target)?, TimeInfo::default()),
        };
        self.go_to(&mut survey, &chosen)?;
        loop {
            let begun = Begun { identity: &identity, before: &before };
            match self.sample(&mut survey, target, &mut chosen, &begun)? {
                Sampled::All => break,
                Sampled::LosesTooMuch => (),
                Sampled::RoundsTooMuch => {
                    let rounded = Some(RoundingEstimate::default());
                    chosen = Chosen { double: true, rounded, allocation: self.allocation(target), ..chosen };
                    self.go_to(&mut survey, &chosen)?;
                    continue;
                }
            }
            // Cuts are chosen from few pixels: if the image loses more than they did, choose again for less.
            let cut = self.cut_for(&mut survey, target, chosen.cut.depth)?;
            if self.observer.cancelled() {
                survey.cut_at(chosen.cut.depth, chosen.cut.cutoff);
                break;
            }
            survey.cut_at(cut.depth, cut.cutoff);
            // No deeper cut is left, or none hides less.
            let last = cut.depth >= DEEPEST || cut.hidden >= chosen.cut.hidden;
            chosen = Chosen { cut, last, allocation: self.allocation(target), ..chosen };
        }
        let capped = chosen.allocation.outcome() == Outcome::Capped;
        let refused = chosen.allocation.refused();
        let measured = self.measured_if_needed(&survey, &chosen, target)?;
        let cancelled = self.observer.cancelled();
        let samples =
            if cancelled { chosen.allocation.gathered().clone() } else { chosen.allocation.take_gathered() };
        let rounding = chosen.rounded.map(|r| (r.part(&samples), r.pixels));
        let kept = (cancelled && samples.done() > 0.0).then(|| {
            let images = vec![chosen.allocation.take_gathered()];
            survey.resume_state(identity, Bounded::new(Stage::Error(Box::new(chosen)), images))
        });
        let took = self.took.so_far();
        let (depth, limit) = (survey.settings().depth, self.limit.clone());
        let image = Image { samples, rounding, measured, took, before, coarse: true };
        let mut known = self.known(image, &survey);
        let error = known.report.error.as_ref();
        let met = error.is_some_and(|e| e.rounding.is_some() && e.void.is_none() && e.total <= target);
        let why = error.map(|e| unmet(e, target, depth, &limit, (capped, refused)));
        known.cancelled &= !met;
        known.unfinished = kept.filter(|_| !met);
        known.report.asked.error = Some(target);
        known.report.asked.met = Some(met);
        known.report.asked.unmet_why = (!met).then(|| match why {
            _ if known.cancelled => "the render was interrupted".to_owned(),
            Some(why) => why,
            None => "some pixels have no samples".to_owned(),
        });
        Ok(known)
    }

    /// The truncation part from longer paths, where what is certain is more than `target` leaves for it. Elsewhere deeper
    /// paths everywhere are the cheaper way: what is certain falls with every depth.
    fn measured_if_needed(
        &mut self,
        survey: &Survey,
        chosen: &Chosen,
        target: f64,
    ) -> Result<Option<Measured>, RenderError> {
        let image = chosen.allocation.gathered();
        let certain = image.truncation(&self.limit).rms;
        let needed = chosen.allocation.bound().is_some_and(|sampling| sampling.bound + certain > target);
        if !needed || self.observer.cancelled() {
            return Ok(None);
        }
        self.measured(survey, image)
    }

    /// The cut; of no meaning if it was cancelled meanwhile. The precision is seen to in the samples of a short pilot; before
    /// a long one, which would be lost if f64 were needed, and of whose many samples few paths are told apart.
    fn begin(&mut self, survey: &mut Survey, target: f64) -> Result<Chosen, RenderError> {
        if self.allocation(target).goal().pilot > LOOK_SAMPLES {
            return self.choose(survey, target);
        }
        self.observer.span(0.0, CHOICE);
        let cut = self.cut_for(survey, target, 0)?;
        let exact = survey.precision() == Precision::Double;
        let rounded = exact.then(RoundingEstimate::default);
        Ok(Chosen { cut, last: false, double: false, rounded, allocation: self.allocation(target) })
    }

    /// Precision and cut, before any sample of the image; of no meaning if it was cancelled meanwhile.
    pub(super) fn choose(&mut self, survey: &mut Survey, target: f64) -> Result<Chosen, RenderError> {
        self.observer.span(0.0, 0.5 * CHOICE);
        let asked = survey.precision();
        let rounded = self.precision_for(survey, target)?;
        let double = survey.precision() != asked;
        self.observer.span(0.5 * CHOICE, CHOICE);
        let cut = self.cut_for(survey, target, 0)?;
        Ok(Chosen { cut, last: false, double, rounded, allocation: self.allocation(target) })
    }

    /// Lets `survey` be as it was chosen.
    pub(super) fn go_to(&mut self, survey: &mut Survey, chosen: &Chosen) -> Result<(), RenderError> {
        if chosen.double && survey.precision() != Precision::Double {
            self.settings.precision = Precision::Double;
            let mut exact = self.survey(&self.settings.clone())?;
            exact.count(survey);
            *survey = exact;
        }
        survey.cut_at(chosen.cut.depth, chosen.cut.cutoff);
        Ok(())
    }

    /// The encoding part of the image as it is; 16 bits are chosen here where 8 take too much of the error.
    fn encoding(&mut self, image: &PixelSums, target: f64) -> f64 {
        let Some(format) = self.request.file else { return 0.0 };
        let linear = image.linear();
        let view = View { width: image.width, height: image.height(), linear: &linear };
        let error = format.encoding_error(view);
        let finer =
            format.with_bits(Bits::Sixteen).filter(|finer| *finer != format && !self.request.keep_bits);
        if let Some(finer) = finer.filter(|_| error > ENCODING_SHARE * target) {
            self.request.file = Some(finer);
            return finer.encoding_error(view);
        }
        error
    }

    /// Nothing sampled yet.
    fn allocation(&self, target: f64) -> Allocation {
        let region = Region::of(&self.settings);
        let confidence = self.request.confidence;
        let pixels = region.pixels() as usize;
        let goal = Goal::for_target(target, confidence, pixels, &self.caps, MOST_SAMPLES);
        Allocation::new(region.width, region.height, 1, goal, self.caps.clone())
    }

    /// The rounding part; in f64 where single precision takes too much of the error.
    fn precision_for(
        &mut self,
        survey: &mut Survey,
        target: f64,
    ) -> Result<Option<RoundingEstimate>, RenderError> {
        // Looked at where paths are not yet cut late: a deep path is a rare one, and as rarely rounded.
        survey.cut_at(self.settings.depth.min(8), self.settings.cutoff);
        let rounded = self.rounded(survey, None)?;
        if self.rounds_too_much(survey, rounded, target) {
            self.settings.precision = Precision::Double;
            let mut exact = self.survey(&self.settings.clone())?;
            exact.count(survey);
            *survey = exact;
            return Ok(Some(RoundingEstimate::default()));
        }
        Ok(rounded)
    }

    /// True if single precision takes too much of the error, and a better one may be taken.
    fn rounds_too_much(&self, survey: &Survey, rounded: Option<RoundingEstimate>, target: f64) -> bool {
        let single = survey.precision() != Precision::Double && !self.request.keep_precision;
        single && rounded.is_some_and(|r| r.part_at(16.0) > ROUNDING_SHARE * target)
    }

    fn cut_for(
        &mut self,
        survey: &mut Survey,
        target: f64,
        after: u32,
    ) -> Result<TruncationChoice, RenderError> {
        if !self.scene.materials.iter().any(Material::has_secondary) {
            let depth = if self.request.keep_depth { self.settings.depth } else { 1 };
            return Ok(TruncationChoice::unseen(depth, 0.0));
        }
        let region = Region::of(&self.settings);
        let mut tracing = Tracing { survey, region, observer: &mut self.observer };
        if self.request.keep_depth {
            let (depth, cutoff) = (self.settings.depth, self.settings.cutoff);
            let cut = truncation_choice::look(
                &mut tracing,
                &self.limit,
                depth,
                cutoff,
                truncation_choice::for_cuts(region.pixels(), None),
            )?;
            return Ok(cut.unwrap_or(TruncationChoice::unseen(depth, cutoff)));
        }
        truncation_choice::for_error(&mut tracing, &self.limit, target, after)
    }

    /// Samples until the sum of the parts is the target, or it is cancelled.
    fn sample(
        &mut self,
        survey: &mut Survey,
        target: f64,
        chosen: &mut Chosen,
        begun: &Begun<'_>,
    ) -> Result<Sampled, RenderError> {
        let region = Region::of(&self.settings);
        loop {
            // Everything is decided by what was sampled: one that goes on decides the same.
            chosen.allocation.decide();
            let piloted = chosen.allocation.bound().is_some();
            if piloted && chosen.rounded.is_none() && !self.observer.cancelled() {
                chosen.rounded = self.rounded_image(survey, chosen.allocation.gathered())?;
                if self.rounds_too_much(survey, chosen.rounded, target) {
                    return Ok(Sampled::RoundsTooMuch);
                }
            }
            if piloted && !chosen.allocation.is_open() {
                let image = chosen.allocation.gathered();
                let hidden = image.truncation(&self.limit).rms;
                let encoded = self.encoding(image, target);
                let left = target - hidden - chosen.rounded.map_or(0.0, |r| r.part(image)) - encoded;
                let too_much = left < LEAST_SAMPLING * target && hidden > 0.1 * target;
                // A picture whose promise is refused is not sampled twice.
                let refused = chosen.allocation.refused().is_some();
                if too_much && !chosen.last && !refused && !self.request.keep_depth {
                    return Ok(Sampled::LosesTooMuch);
                }
                // Where the rest is too much already, sample as if it were half.
                chosen.allocation.aim_at(if left > 0.0 { left } else { 0.5 * target });
            }
            let Some(step) = chosen.allocation.next_step(f64::INFINITY) else { break };
            if self.observer.cancelled() {
                break;
            }
            let done = chosen.allocation.samples() as f64;
            let more = step.pixels.len() as f64 * f64::from(step.samples.end - step.samples.start);
            let all = ahead(chosen, target, region.pixels()).max(done + more) / (1.0 - CHOICE);
            self.observer.span(CHOICE + done / all, CHOICE + (done + more) / all);
            let mut tracing = Tracing { survey, region, observer: &mut self.observer };
            let traced = tracing.trace_some(&step.pixels, step.samples.clone())?;
            chosen.allocation.record(&step, &traced);
            self.show(survey, chosen.allocation.gathered());
            if self.observer.wants_state() && !self.observer.cancelled() {
                self.keep_chosen(survey, chosen, begun);
            }
        }
        Ok(Sampled::All)
    }
}

impl Task<'_> {
    /// Keeps the state of a render that goes on.
    fn keep_chosen(&mut self, survey: &Survey, chosen: &mut Chosen, begun: &Begun<'_>) {
        let images = vec![chosen.allocation.take_gathered()];
        let kept = Bounded::new(Stage::Error(Box::new(chosen.clone())), images);
        for image in self.keep(survey, kept, begun) {
            // It is the image that was taken out.
            chosen.allocation.put_gathered(image, self.caps.clone());
        }
    }
}

/// The part of the error that keeps it from the target, and a remedy.
fn unmet(
    e: &ErrorInfo,
    target: f64,
    depth: u32,
    limit: &RadianceLimit,
    (capped, refused): (bool, Option<Refusal>),
) -> String {
    let figure = crate::units::figure;
    if let Some(why) = &e.void {
        return why.clone();
    }
    let Some(rounding) = e.rounding else {
        return "the rounding error is unknown: this device has no f64 to compare with".to_owned();
    };
    let parts = [e.sampling, e.truncation, rounding, e.encoding.unwrap_or(0.0)];
    let most = parts.iter().fold(0.0, |m: f64, p| m.max(*p));
    if e.truncation == most {
        let remedy = match depth < DEEPEST {
            true => format!("; ask for a --depth above {depth}"),
            false => format!("; {DEEPEST} is the greatest depth there is"),
        };
        let why = match &limit.unbounded {
            Some(why) => format!("their light has no bound: {why}"),
            None => {
                format!("at depth {depth} they can contribute up to {} (RMSE){remedy}", figure(e.truncation))
            }
        };
        return format!("rays that are not traced can contribute more than this error: {why}");
    }
    if rounding == most {
        return format!("rounding alone causes {}; try --precision f64", figure(rounding));
    }
    if e.encoding == Some(most) {
        return format!("the file's own steps cause {}; try --bits 16, or .exr", figure(most));
    }
    if refused == Some(Refusal::OutOfReach) {
        return format!(
            "even {MOST_SAMPLES} samples in every pixel would leave a sampling error above {}; an error above {} would do",
            figure(target),
            figure(e.total)
        );
    }
    if refused.is_some() || e.unseen > 0.7 * e.sampling {
        let brightest = limit.rgb.iter().fold(0.0, |m: f64, c| m.max(*c));
        return format!(
            "parts of pixels that no sample met may hold radiance up to {}, and could cause {}: lamps close to surfaces, \
             or bright things smaller than a pixel, seen directly or in mirrors and glass{}; a larger --size, a weaker or \
             more distant light, or an error above {} would do",
            figure(brightest),
            figure(e.unseen),
            if refused.is_some() {
                ", and to exclude them takes more samples than the whole image is worth"
            } else {
                ""
            },
            figure(e.total)
        );
    }
    let stop =
        if capped { format!(" although pixels have up to {MOST_SAMPLES} samples") } else { String::new() };
    format!(
        "the sampling error is only known to be below {} at {:.0} % confidence{stop}; the target was {}",
        figure(e.sampling),
        100.0 * e.confidence,
        figure(target)
    )
}

/// How sampling ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Sampled {
    /// At the goal, or as near as it comes, or cancelled.
    All,
    /// Another cut is needed.
    LosesTooMuch,
    /// A better precision is needed.
    RoundsTooMuch,
}

/// Samples to expect in all, for the progress: they go with the -4/3 power of the error (edges; Mitchell,
/// SIGGRAPH 1996). Before there is a bound, by the pixels that were looked at.
fn ahead(chosen: &Chosen, target: f64, pixels: u32) -> f64 {
    let (now, error, goal) = match (chosen.allocation.bound(), chosen.allocation.goal().target) {
        (Some(now), Some(goal)) => (chosen.allocation.samples() as f64, now.bound, goal),
        _ => (f64::from(pixels * CUT_SAMPLES), chosen.cut.noise, target - chosen.cut.hidden),
    };
    if goal > 0.0 { now * (error / goal).max(1.0).powf(4.0 / 3.0).min(1e6) } else { now }
}

//! `--time`: the least error that fits in a time.
//!
//! The deadline is that of the process, less what it takes to make, paint and write the image and to end. Every trace
//! ends by it (`Survey::finish_by`), and nothing that was traced by then is lost: pixels come from coarse to
//! fine, and steps may be cut anywhere.

use super::bounded_image::{BoundedImage, Image};
use super::resume_state::{Begun, Bounded, Stage, Timed, options};
use super::traced::{Region, Tracing};
use super::truncation_choice::{self, TruncationChoice};
use super::{DEEPEST, LOOK_SAMPLES, MOST_SAMPLES, Task};
use crate::accuracy::allocate::{Allocation, Goal};
use crate::accuracy::budget;
use crate::accuracy::pixel_order;
use crate::accuracy::pixel_sums::PixelSums;
use crate::image::{Bits, Format, Metadata, View};
use crate::render::samples::Source;
use crate::render::{Observer, RenderError, ResumeState, Survey};
use crate::report::TimeInfo;
use crate::settings::{Precision, Settings};
use std::io;
use std::time::{Duration, Instant};

/// A time counts as kept up to this share beyond it.
pub const LATE: f64 = 0.05;
/// Share of the time that is kept for what cannot be foretold.
const SLACK: f64 = 0.01;
/// What it takes to close a device, as a share of what it took to open it and to prepare the kernels: lavapipe
/// took 2 to 5 %.
const CLOSING: f64 = 0.06;
/// Share of the time left that one step may take: what is sampled next is decided after each.
const STEP_SHARE: f64 = 0.3;
/// A step that would be shorter is not worth its overhead; seconds.
const STEP_LEAST: f64 = 0.02;
/// Share of the time that may go to the choice of a depth.
const PILOT_SHARE: f64 = 0.08;
/// The same for the rounding part.
const ROUNDING_SHARE: f64 = 0.06;
/// Pixels that are traced even where there is no time for any.
const LEAST_PIXELS: usize = 256;
/// Greatest depth of those.
const LEAST_DEPTH: u32 = 4;
/// Pixels by which the writing of the image is timed: the first of all.
const STRIP_PIXELS: usize = 1 << 14;
/// Share of the time left that these may take.
const STRIP_SHARE: f64 = 0.5;
/// Time per pixel of a large image / of a strip, which fits the caches: 1.1 to 2.5 at 1200x1000.
const CACHES: f64 = 2.0;
/// Seconds that the smallest file takes.
const WRITING: f64 = 0.01;
/// Time to write an image to a file / to memory.
const FILE_SYSTEM: f64 = 1.25;

/// When what has to be done.
pub(super) struct Clock {
    from: Instant,
    pub(super) seconds: f64,
    /// Seconds that making and writing the image and ending takes.
    pub(super) reserve: f64,
    /// Seconds that it takes to sort the pixels into classes, or to measure them again after a step.
    deciding: f64,
    /// Seconds that it took to open the device and to prepare kernels before those of the image with a bound.
    pub(super) opened: f64,
}

impl Clock {
    pub(super) fn end(&self) -> Instant {
        let seconds = self.seconds * (1.0 - SLACK) - self.reserve;
        self.from
            + Duration::try_from_secs_f64(seconds.max(0.0)).unwrap_or(Duration::from_secs(u32::MAX.into()))
    }

    /// Seconds to the end.
    pub(super) fn left(&self) -> f64 {
        self.end().saturating_duration_since(Instant::now()).as_secs_f64()
    }

    /// When that share of the time that is left now will have passed.
    fn share(&self, share: f64) -> Instant {
        Instant::now() + self.end().saturating_duration_since(Instant::now()).mul_f64(share)
    }
}

impl Task<'_> {
    /// Renders until `seconds` after `from`, as well as that goes; then `layers` of it are painted.
    pub(super) fn until_time(
        mut self,
        seconds: f64,
        from: Instant,
        layers: u32,
        earlier: Option<ResumeState<Bounded>>,
    ) -> Result<BoundedImage, RenderError> {
        let mut clock = Clock { from, seconds, reserve: 0.0, deciding: 0.0, opened: 0.0 };
        if earlier.is_none() && layers == 0 {
            self.observer.by_clock(from, seconds);
            if let Some(image) = self.plain_in_time(&mut clock)? {
                return Ok(image);
            }
        }
        let own = self.settings.clone();
        let depth = if self.request.keep_depth { own.depth } else { DEEPEST };
        self.settings = Settings { replicates: 1, depth, ..self.settings };
        let mut survey = self.survey(&self.settings.clone())?;
        let identity = survey.identity(&self.settings, options(&self.request));
        let (timed, before) = match earlier {
            Some(state) => {
                let (samples, before) = survey.take_up(state, &identity)?;
                (Some(samples.into_timed(self.caps.clone())?), before)
            }
            None => (None, TimeInfo::default()),
        };
        // What earlier parts took is gone.
        let (all, seconds) = (seconds, (seconds - before.wall).max(0.0));
        self.observer.by_clock(from, seconds);
        self.took.start = Instant::now();
        let begun = Begun { identity: &identity, before: &before };
        let region = Region::of(&self.settings);
        let closing = CLOSING * survey.prepared().as_secs_f64();
        (clock.seconds, clock.reserve) = (seconds, closing);

        // Every pixel once, at the scene's own depth: from then on there is an image.
        survey.cut_at(own.depth, own.cutoff);
        let goal = self.goal_in_time();
        let mut timed = timed.unwrap_or_else(|| {
            let allocation = Allocation::new(region.width, region.height, 1, goal, self.caps.clone());
            Timed { cut: None, rounded: None, pace: 0.0, allocation }
        });
        self.cover_in_time(&mut survey, clock.share(STRIP_SHARE), STRIP_PIXELS, &mut timed, &begun)?;
        let output = self.output(timed.allocation.gathered(), layers);
        clock.reserve = closing + output.image;
        self.cover_in_time(&mut survey, clock.end(), usize::MAX, &mut timed, &begun)?;
        let begin = Instant::now();
        self.show(&survey, timed.allocation.gathered());
        clock.reserve += begin.elapsed().as_secs_f64() + output.statement;
        clock.deciding = output.deciding;
        if timed.allocation.is_covered() && (clock.left() > 0.0 || timed.cut.is_some()) {
            if timed.cut.is_none() {
                let (mut cut, fast) = self.cut_in_time(&mut survey, &clock)?;
                if cut.depth < own.depth {
                    // No worse than what the scene asks for.
                    (cut.depth, cut.cutoff) = (own.depth, own.cutoff);
                }
                survey.cut_at(cut.depth, cut.cutoff);
                timed.pace = f64::max(timed.pace, fast);
                timed.rounded = self.rounded_in_time(&mut survey, &clock, timed.pace / cut.rays)?;
                timed.cut = Some(cut);
            }
            if let Some(cut) = &timed.cut {
                survey.cut_at(cut.depth, cut.cutoff);
            }
            self.sample_in_time(&mut survey, &clock, &mut timed, &begun)?;
        } else if timed.allocation.gathered().done() == 0.0 && !self.observer.cancelled() {
            self.trace_little(&mut survey, &mut timed.allocation)?;
            self.show(&survey, timed.allocation.gathered());
        }

        let short = !timed.allocation.is_covered();
        let took = self.took.so_far();
        let (begun, render) = (self.took.start, took.render);
        let cancelled = self.observer.cancelled();
        // A copy only for a state.
        let samples = match cancelled {
            true => timed.allocation.gathered().clone(),
            false => timed.allocation.take_gathered(),
        };
        let rounding = timed.rounded.map(|r| (r.part(&samples), r.pixels));
        let pilot = samples.done();
        let kept = (cancelled && pilot > 0.0).then(|| {
            let images = vec![timed.allocation.take_gathered()];
            survey.resume_state(identity, Bounded::new(Stage::Time(Box::new(timed)), images))
        });
        let seconds = all;
        let mut known =
            self.known(Image { samples, rounding, measured: None, took, before, coarse: true }, &survey);
        known.unfinished = kept;
        known.report.time.first_dispatch += clock.opened;
        known.report.asked.time = Some(seconds);
        known.report.asked.met = Some(!short && !known.cancelled);
        known.report.asked.unmet_why = if known.cancelled {
            Some("the render was interrupted".into())
        } else if short {
            // Looks and kernels were paid for; the rest goes with the pixels.
            let fixed = (begun - from).as_secs_f64() + clock.reserve;
            // Few pixels tell little of the pace.
            let needed = match pilot >= 0.05 {
                true => format!("about {:.1} s", fixed + render / pilot),
                false => "longer".to_owned(),
            };
            Some(format!(
                "{seconds} s is too short: start-up and writing files take {fixed:.1} s, with one sample of every pixel \
                 {needed}; only {:.1} % of the pixels were traced, the rest repeat their neighbours, and the error is \
                 unknown; reduce --size",
                100.0 * pilot
            ))
        } else {
            None
        };
        Ok(known)
    }

    fn goal_in_time(&self) -> Goal {
        let confidence = self.request.confidence;
        Goal { target: None, confidence, first: 1, pilot: LOOK_SAMPLES, most: MOST_SAMPLES }
    }

    /// Where to cut, from a few pixels, and the pace of the device in rays a second.
    fn cut_in_time(
        &mut self,
        survey: &mut Survey,
        clock: &Clock,
    ) -> Result<(TruncationChoice, f64), RenderError> {
        let region = Region::of(&self.settings);
        let by = clock.share(PILOT_SHARE);
        let start = Instant::now();
        let mut tracing = Tracing { survey, region, observer: &mut self.observer };
        if !self.request.keep_depth {
            let found = truncation_choice::for_time(&mut tracing, &self.limit, || clock.left(), by)?;
            return Ok(found.unwrap_or((TruncationChoice::unseen(LEAST_DEPTH, 0.0), 0.0)));
        }
        let (depth, cutoff) = (self.settings.depth, self.settings.cutoff);
        tracing.survey.finish_by(Some(by));
        let found = truncation_choice::look(
            &mut tracing,
            &self.limit,
            depth,
            cutoff,
            (truncation_choice::PIXELS, LOOK_SAMPLES),
        )?;
        let Some(cut) = found else { return Ok((TruncationChoice::unseen(depth, cutoff), 0.0)) };
        let rays = cut.rays * f64::from(region.spread(truncation_choice::PIXELS).len() as u32 * LOOK_SAMPLES);
        Ok((cut, rays / start.elapsed().as_secs_f64()))
    }

    /// The rounding part, if there is time for it: its kernels may have to be compiled.
    fn rounded_in_time(
        &mut self,
        survey: &mut Survey,
        clock: &Clock,
        samples_per_second: f64,
    ) -> Result<Option<super::rounding::RoundingEstimate>, RenderError> {
        let share = ROUNDING_SHARE * clock.left();
        let single = survey.precision() != Precision::Double;
        // In f64 samples take several times as long.
        let samples = f64::from(Region::of(&self.settings).pixels().min(4096) * LOOK_SAMPLES);
        if single && 2.0 * survey.prepared().as_secs_f64() + 4.0 * samples / samples_per_second > share {
            return Ok(None);
        }
        self.rounded(survey, Some(clock.share(2.0 * ROUNDING_SHARE)))
    }

    /// One sample of every pixel, or of `most` of them, as far as there is time.
    fn cover_in_time(
        &mut self,
        survey: &mut Survey,
        by: Instant,
        mut most: usize,
        timed: &mut Timed,
        begun: &Begun<'_>,
    ) -> Result<(), RenderError> {
        let region = Region::of(&self.settings);
        let (start, before) = (Instant::now(), survey.rays());
        survey.finish_by(Some(by));
        while most > 0
            && !timed.allocation.is_covered()
            && let Some(step) = timed.allocation.next_step(f64::INFINITY)
        {
            let pixels = &step.pixels[..step.pixels.len().min(survey.part_pixels_at_most()).min(most)];
            let mut tracing = Tracing { survey, region, observer: &mut self.observer };
            let traced = tracing.trace_some(pixels, step.samples.clone())?;
            timed.allocation.record(&step, &traced);
            timed.pace = (survey.rays() - before) as f64 / start.elapsed().as_secs_f64();
            most -= traced.marks.len();
            if traced.marks.len() < pixels.len() && !self.kept_in_time(survey, timed, begun) {
                break;
            }
        }
        survey.finish_by(None);
        Ok(())
    }

    /// Keeps the state if it is wanted: true if it was, and the render goes on.
    fn kept_in_time(&mut self, survey: &Survey, timed: &mut Timed, begun: &Begun<'_>) -> bool {
        if !self.observer.wants_state() || self.observer.cancelled() {
            return false;
        }
        let images = vec![timed.allocation.take_gathered()];
        let kept = Bounded::new(Stage::Time(Box::new(timed.clone())), images);
        for image in self.keep(survey, kept, begun) {
            // It is the image that was taken out.
            timed.allocation.put_gathered(image, self.caps.clone());
        }
        true
    }

    /// Too late for anything: as little as shows something.
    fn trace_little(&mut self, survey: &mut Survey, allocation: &mut Allocation) -> Result<(), RenderError> {
        let region = Region::of(&self.settings);
        survey.cut_at(survey.settings().depth.min(LEAST_DEPTH), survey.settings().cutoff);
        if let Some(step) = allocation.next_step(f64::INFINITY) {
            let few = &step.pixels[..step.pixels.len().min(LEAST_PIXELS)];
            let mut tracing = Tracing { survey, region, observer: &mut self.observer };
            let traced = tracing.trace(few, step.samples.clone())?;
            allocation.record(&step, &traced);
        }
        Ok(())
    }

    /// All samples for which there is time.
    fn sample_in_time(
        &mut self,
        survey: &mut Survey,
        clock: &Clock,
        timed: &mut Timed,
        begun: &Begun<'_>,
    ) -> Result<(), RenderError> {
        let region = Region::of(&self.settings);
        let mut deciding = clock.deciding;
        while !self.observer.cancelled() && clock.left() > deciding {
            let begin = Instant::now();
            let budget = match timed.allocation.bound() {
                None => f64::INFINITY,
                Some(_) => (STEP_SHARE * clock.left()).max(STEP_LEAST) * timed.pace,
            };
            let Some(step) = timed.allocation.next_step(budget) else { break };
            let decided = begin.elapsed();
            let (before, start) = (survey.rays(), Instant::now());
            survey.finish_by(Some(clock.end()));
            let mut tracing = Tracing { survey, region, observer: &mut self.observer };
            let traced = tracing.trace_some(&step.pixels, step.samples.clone())?;
            let cut_short = traced.marks.len() < step.pixels.len();
            let begin = Instant::now();
            timed.allocation.record(&step, &traced);
            if timed.allocation.bound().is_some() {
                deciding = (decided + begin.elapsed()).as_secs_f64();
            }
            let seconds = start.elapsed().as_secs_f64();
            self.show(survey, timed.allocation.gathered());
            let kept = self.kept_in_time(survey, timed, begun);
            if cut_short && !kept {
                break;
            }
            let now = (survey.rays() - before) as f64 / seconds;
            // Short steps are slow steps: the next one is planned at a pace between.
            timed.pace = if timed.pace > 0.0 { 0.5 * (timed.pace + now) } else { now };
        }
        survey.finish_by(None);
        Ok(())
    }
}

/// How many of `pixels` are measured.
pub(super) fn strip(pixels: usize) -> usize {
    STRIP_PIXELS.min(pixels)
}

/// Seconds that the image takes once it is sampled.
struct Output {
    /// To make, paint and write it.
    image: f64,
    /// To state its error.
    statement: f64,
    /// To sort its pixels into classes.
    deciding: f64,
}

impl Task<'_> {
    /// What the output will take: measured on the first pixels of the image, since all of it is proportional to them. They are
    /// further apart than those of the image, so no easier to pack.
    fn output(&self, image: &PixelSums, layers: u32) -> Output {
        let first = pixel_order::order(image.width, image.height(), 0..strip(image.samples.len()));
        let there: Vec<u32> = first.into_iter().take_while(|p| image.samples[*p as usize] > 0).collect();
        let width = (there.len() as f64).sqrt().floor() as u32;
        let strip = image.of_some(&there, width);
        let pixels = strip.samples.len();
        if pixels == 0 {
            return Output { image: 0.0, statement: 0.0, deciding: 0.0 };
        }
        let whole = image.samples.len() as f64 / pixels as f64;
        let linear = strip.linear();
        let written = self.write_seconds(&linear, image.samples.len());
        let clock = Instant::now();
        if let Some(format) = self.request.file {
            let _ = format.encoding_error(View { width, height: strip.height(), linear: &linear });
        }
        let _ = budget::budget(&strip, &self.limit, &self.caps, (None, None), self.request.confidence);
        let known = clock.elapsed().as_secs_f64();
        let mut painted = 0.0;
        if layers > 0 {
            let clock = Instant::now();
            let _ = strip.half_widths(self.request.confidence);
            painted = whole * clock.elapsed().as_secs_f64() + 3.0 * f64::from(layers) * written;
        }
        let clock = Instant::now();
        Allocation::piloted(strip, self.goal_in_time(), self.caps.clone()).decide();
        let deciding = clock.elapsed().as_secs_f64();
        let whole = CACHES * whole;
        Output { image: written + painted, statement: whole * known, deciding: whole * deciding }
    }

    /// Seconds that it takes to make and write an image of `pixels` pixels, measured on some of them.
    pub(super) fn write_seconds(&self, some: &[[f32; 3]], pixels: usize) -> f64 {
        let clock = Instant::now();
        let width = (some.len() as f64).sqrt().floor() as u32;
        let height = some.len() as u32 / width.max(1);
        let linear = &some[..(width * height) as usize];
        let format = self.request.file.unwrap_or(Format::Png(Bits::Eight));
        // Errors cannot be: nothing is written anywhere.
        let _ = format.encode(View { width, height, linear }, &Metadata::default(), &mut io::sink());
        let _ = crate::image::linear_sha256(linear);
        // A file system is slower than memory.
        let whole = pixels as f64 / linear.len().max(1) as f64;
        whole * FILE_SYSTEM * clock.elapsed().as_secs_f64() + WRITING
    }
}

//! `--time`: the least error that fits in a time.

use super::cut;
use super::known::Known;
use super::traced::{Part, Region, Tracing};
use super::{DEEPEST, MOST_SAMPLES, REPLICATES, Task};
use crate::image::{Bits, Format, Metadata, View};
use crate::measure::allocate::{Allocation, Goal};
use crate::measure::gathered::Gathered;
use crate::measure::samples::Source;
use crate::render::{RenderError, Survey};
use crate::settings::{Precision, Settings};
use std::io;
use std::time::{Duration, Instant};

/// Share of the time that is kept for what cannot be foretold.
const SLACK: f64 = 0.01;
/// Share of the time left that one step may take: the pace may change under it.
const STEP_SHARE: f64 = 0.4;
/// A step that would be shorter is not worth its overhead; seconds.
const STEP_LEAST: f64 = 0.004;
/// Share of the time that may go to the choice of a depth, and again to the rounding part.
const PILOT_SHARE: f64 = 0.12;

impl Task<'_> {
    /// Renders until `seconds` after `from`, as well as that goes.
    pub(super) fn until_time(mut self, seconds: f64, from: Instant) -> Result<Known, RenderError> {
        let left = |reserve: f64| seconds * (1.0 - SLACK) - reserve - from.elapsed().as_secs_f64();
        let depth = if self.request.keep_depth { self.settings.depth } else { DEEPEST };
        self.settings = Settings { replicates: REPLICATES, depth, ..self.settings };
        let mut survey = Survey::new(self.renderer, self.scene, &self.settings)?;
        let start = Instant::now();
        let region = Region::of(&self.settings);
        let mut reserve = output_seconds(region);

        // Depth, from a few pixels.
        let mut cut = {
            let clock = Instant::now();
            let share = PILOT_SHARE * left(reserve);
            let mut tracing = Tracing { survey: &mut survey, region, observer: self.observer };
            if self.request.keep_depth {
                cut::look(&mut tracing, &self.limit, self.settings.depth, self.settings.cutoff)?
            } else {
                let rays = |pace: f64| pace * left(reserve);
                // The pace is not known before the first look: lavapipe's is a few million rays a second.
                cut::for_rays(
                    &mut tracing,
                    &self.limit,
                    || rays(4e6),
                    || clock.elapsed().as_secs_f64() < share,
                )?
            }
        };
        survey.cut_at(cut.depth, cut.cutoff);
        let mut pace = {
            let clock = Instant::now();
            let mut tracing = Tracing { survey: &mut survey, region, observer: self.observer };
            cut = cut::look(&mut tracing, &self.limit, cut.depth, cut.cutoff)?;
            let rays = cut.rays * f64::from(region.spread(cut::PIXELS).len() as u32 * REPLICATES);
            rays / clock.elapsed().as_secs_f64()
        };

        // Rounding, if it is cheap: its kernels may have to be compiled.
        let mut rounded = None;
        let single = survey.precision() != Precision::Double;
        let dear = 2.0 * survey.prepared.as_secs_f64() > PILOT_SHARE * left(reserve);
        if !single || !dear {
            let risk = 0.1 * (1.0 - self.request.confidence);
            let samples = (0.5 * PILOT_SHARE * left(reserve) * pace / cut.rays) as u64;
            rounded = self.rounded(&mut survey, samples, risk)?;
        }

        // Samples.
        let confidence = self.sampling_confidence();
        let replicates = REPLICATES as usize;
        let goal = Goal { target: None, confidence, pilot: REPLICATES, most: MOST_SAMPLES };
        let mut allocation = Allocation::new(region.width, region.height, replicates, goal);
        let pilot = cut.rays * f64::from(REPLICATES) * f64::from(region.pixels());
        let mut coarse = None;
        if pilot / pace > left(reserve) {
            coarse = Some(self.coarse(&mut survey, left(reserve) * pace / pilot)?);
        } else {
            let total = (1e3 * left(reserve)) as u64;
            while !self.observer.cancelled() {
                let time = left(reserve);
                let piloting = allocation.bound().is_none();
                let share = if piloting { 1.0 } else { STEP_SHARE };
                if time * share < STEP_LEAST {
                    break;
                }
                let budget = if piloting { (0.1 * time).max(0.05).min(time) } else { share * time };
                let Some(step) = allocation.next_step(budget * pace) else { break };
                let done = total.saturating_sub((1e3 * time.max(0.0)) as u64);
                let mut observer = Part::still(self.observer, done, total);
                let before = allocation.rays();
                let clock = Instant::now();
                let mut tracing = Tracing { survey: &mut survey, region, observer: &mut observer };
                let traced = tracing.trace(&step.pixels, step.samples.clone())?;
                if traced.marks.len() < step.pixels.len() {
                    if piloting {
                        allocation.record_part(&step, &traced);
                    }
                    break;
                }
                allocation.record(&step, &traced);
                let rays = (allocation.rays() - before) as f64;
                let now = rays / clock.elapsed().as_secs_f64();
                // Short steps are slow steps: the next one is planned at a pace between.
                pace = 0.5 * (pace + now);
                reserve = reserve.max(output_seconds_of(allocation.gathered(), region));
            }
        }
        let short = coarse.is_some() || (allocation.bound().is_none() && !self.observer.cancelled());
        let image = coarse.unwrap_or_else(|| allocation.gathered().clone());
        let rounding = rounded.map(|r| (r.part(&image), r.pixels));
        let prepared = survey.prepared;
        let mut known = self.known_with(image, survey, None, rounding, prepared, start.elapsed())?;
        known.report.asked.time = Some(seconds);
        let late = from.elapsed() > Duration::from_secs_f64(seconds);
        known.report.asked.met = Some(!short && !late && !known.cancelled);
        known.report.asked.unmet_why = if known.cancelled {
            Some("it was interrupted".into())
        } else if short {
            let needed = from.elapsed().as_secs_f64() + pilot / pace;
            Some(format!(
                "{seconds} s is too short for {REPLICATES} samples of every pixel, which take about {needed:.1} s: \
                 the image was sampled coarsely; a smaller --size helps"
            ))
        } else {
            late.then(|| format!("it took {:.2} s", from.elapsed().as_secs_f64()))
        };
        Ok(known)
    }

    /// Some pixels stand for their neighbours: the share `share` of all.
    fn coarse(&mut self, survey: &mut Survey, share: f64) -> Result<Gathered, RenderError> {
        let region = Region::of(&self.settings);
        let side = (1.0 / share.max(1e-6)).sqrt().ceil().clamp(2.0, 64.0) as u32;
        let centre = |at: u32, end: u32| (at / side * side + side / 2).min(end - 1);
        let stands = |p: u32| {
            centre(p / region.width, region.height) * region.width + centre(p % region.width, region.width)
        };
        let mut places: Vec<u32> = (0..region.pixels()).map(stands).collect();
        places.sort_unstable();
        places.dedup();
        let mut image = Gathered::new(region.width, region.height, REPLICATES as usize);
        let mut tracing = Tracing { survey, region, observer: self.observer };
        tracing.gather(&mut image, &places, 0..REPLICATES)?;
        for p in 0..region.pixels() {
            image.copy(stands(p) as usize, p as usize);
        }
        Ok(image)
    }
}

/// Seconds that it takes to make and write the image, from encoding one of its size now.
fn output_seconds(region: Region) -> f64 {
    let black = Gathered::new(region.width, region.height, 1);
    output_seconds_of(&black, region)
}

fn output_seconds_of(image: &Gathered, region: Region) -> f64 {
    let clock = Instant::now();
    let linear = image.linear();
    let view = View { width: region.width, height: region.height, linear: &linear };
    // Errors cannot be: nothing is written anywhere.
    let _ = Format::Png(Bits::Eight).encode(view, &Metadata::default(), &mut io::sink());
    let _ = crate::image::linear_sha256(&linear);
    // Bounds and layers besides, and a file system that is slower than memory.
    2.5 * clock.elapsed().as_secs_f64() + 0.01
}

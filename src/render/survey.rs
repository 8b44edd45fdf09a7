//! Samples of listed pixels, told apart: the sums of each replicate, and what the paths did. What is
//! rendered to an error, or with one, is traced through here.

use super::batches::{End, Part, sum};
use super::identity::Identity;
use super::tally::Tally;
use super::{Mismatch, Observer, Payload, Prepared, RenderError, Renderer, ResumeState};
use crate::kernel::abi;
use crate::plan::Purpose;
use crate::render::samples::{Mark, Traced, sets};
use crate::report::{Report, TimeInfo};
use crate::scene::Scene;
use crate::settings::{Precision, Settings};
use rayon::prelude::*;
use std::ops::Range;
use std::time::{Duration, Instant};

/// Seconds of one part: a survey that is cancelled ends within about that time.
const PART_SECONDS: f64 = 0.25;
/// Sums that one core converts at a time.
const PIECE: usize = 1 << 14;
/// Samples of the first part, while the pace is not known; and where no time is kept.
const FIRST_SAMPLES: f64 = 2048.0;
const FIRST_AT_LEISURE: f64 = 8192.0;
/// Share of the time left to a deadline that one part may take: so that it is kept where the next pixels take
/// nearly twice as long as the last.
const PART_SHARE: f64 = 0.5;

/// A scene on a device under fixed settings, whose pixels are traced on demand. Memory is taken once.
pub struct Survey {
    prepared: Prepared,
    /// With the cuts in force ([`Survey::cut_at`]).
    settings: Settings,
    /// Depth that memory was planned for.
    deepest: u32,
    tally: Tally,
    /// Rays that fit a batch; halved when a queue overflows.
    batch: u32,
    /// When traces end, finished or not.
    deadline: Option<Instant>,
    /// Seconds that a sample of the last part took, and those of the shortest part, both with everything.
    pace: Option<(f64, f64)>,
}

impl Survey {
    /// Prepares the kernels for `scene`. `settings.samples` and `settings.crop` mean nothing here.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn new(renderer: &mut Renderer, scene: &Scene, settings: &Settings) -> Result<Survey, RenderError> {
        // No sample lies at its pixel's centre by rule: one of many is all that a survey knows.
        let settings = Settings { samples: u32::MAX, crop: None, ..settings.clone() };
        let built = renderer.build(scene, &settings, Purpose::Survey)?;
        let prepared = renderer.prepare_built(scene, built)?;
        let plan = prepared.plan();
        let batch = plan.tile_pixels.saturating_mul(plan.batch_samples);
        let settings = prepared.settings().clone();
        Ok(Survey {
            deepest: settings.depth,
            settings,
            prepared,
            tally: Tally::default(),
            batch,
            deadline: None,
            pace: None,
        })
    }

    /// Rays, times and counts so far. Its image, device and warnings are the caller's to fill.
    pub fn report(&self) -> Report {
        self.tally.report(&self.settings, self.prepared.packed(), self.prepared.plan())
    }

    /// Rays of all kinds so far.
    pub fn rays(&self) -> u64 {
        self.tally.rays()
    }

    /// Replicates of every pixel.
    pub fn replicates(&self) -> usize {
        self.settings.replicates.max(1) as usize
    }

    /// Arithmetic of its kernels.
    pub fn precision(&self) -> Precision {
        self.settings.precision
    }

    /// Pixels that are traced at a time at most.
    pub fn part_pixels_at_most(&self) -> usize {
        self.prepared.batches.plan.tile_pixels as usize
    }

    /// The settings in force.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Cuts paths at other places from now on. `depth` is at most that of the settings it began with.
    pub fn cut_at(&mut self, depth: u32, cutoff: f32) {
        self.settings.depth = depth.min(self.deepest);
        self.settings.cutoff = cutoff;
        self.pace = None;
        self.prepared.batches.cut_at(self.settings.depth, cutoff);
    }

    /// Ends every trace by `deadline`, with what is there then; no part is begun that would not be done
    /// by it. `None` lets them run.
    pub fn finish_by(&mut self, deadline: Option<Instant>) {
        self.deadline = deadline;
    }

    /// What the user should know of the image to come.
    pub fn warnings(&self) -> &[String] {
        self.prepared.warnings()
    }

    /// Time that went into packing and planning.
    pub fn built(&self) -> Duration {
        self.prepared.built
    }

    /// Time that went into opening the device, kernels and buffers.
    pub fn prepared(&self) -> Duration {
        self.prepared.prepared
    }

    /// What the bits of its samples depend on; `settings` and `request` are those asked for.
    pub(crate) fn identity(&self, settings: &Settings, request: String) -> Identity {
        let Prepared { device, camera, .. } = &self.prepared;
        Identity::new(device, self.prepared.packed(), *camera, settings, request)
    }

    /// The state of a render that is interrupted now.
    pub(crate) fn resume_state<P: Payload>(&self, identity: Identity, payload: P) -> ResumeState<P> {
        ResumeState::new(identity, TimeInfo::default(), self.tally.clone(), payload)
    }

    /// Gives `observer` the state of a render that goes on and has taken `time`. Gives the payload back.
    pub(crate) fn keep<P: Payload>(
        &self,
        observer: &mut dyn Observer,
        time: TimeInfo,
        identity: &Identity,
        payload: P,
    ) -> P {
        let state = ResumeState::new(identity.clone(), time, self.tally.clone(), payload);
        observer.keep(&state);
        state.payload
    }

    /// Payload and times of an earlier state of the render `now`; its rays are counted here from now on.
    pub(crate) fn take_up<P: Payload>(
        &mut self,
        earlier: ResumeState<P>,
        now: &Identity,
    ) -> Result<(P, TimeInfo), Mismatch> {
        let (payload, tally, time) = earlier.into_parts(now)?;
        self.tally.add(&tally);
        Ok((payload, time))
    }

    /// Adds the rays and times of another survey.
    pub(crate) fn count(&mut self, other: &Survey) {
        self.tally.add(&other.tally);
    }

    /// Traces samples `samples` of each of `pixels` (row * width + column). If it is cancelled or out of time,
    /// only the first of them are there: as many as there are marks.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn trace(
        &mut self,
        pixels: &[u32],
        samples: Range<u32>,
        observer: &mut dyn Observer,
    ) -> Result<Traced, RenderError> {
        self.trace_while(pixels, samples, observer, |_| true)
    }

    /// As [`Survey::trace`], until a state is wanted, too.
    pub(crate) fn trace_some(
        &mut self,
        pixels: &[u32],
        samples: Range<u32>,
        observer: &mut dyn Observer,
    ) -> Result<Traced, RenderError> {
        self.trace_while(pixels, samples, observer, |observer| !observer.wants_state())
    }

    /// Traces parts as long as `go_on` is true.
    fn trace_while(
        &mut self,
        pixels: &[u32],
        samples: Range<u32>,
        observer: &mut dyn Observer,
        go_on: fn(&dyn Observer) -> bool,
    ) -> Result<Traced, RenderError> {
        let replicates = self.replicates();
        let mut traced = Traced {
            replicates,
            sums: Vec::with_capacity(pixels.len() * sets(replicates)),
            marks: Vec::with_capacity(pixels.len()),
        };
        let each = u64::from(samples.end - samples.start);
        let total = pixels.len() as u64 * each;
        let mut observer = InTime { observer, deadline: self.deadline };
        let mut parts = vec![pixels];
        while let Some(list) = parts.pop() {
            if list.is_empty() {
                continue;
            }
            let most = self.part_pixels(each);
            if most == 0 {
                break;
            }
            let (list, rest) = list.split_at(list.len().min(most));
            parts.push(rest);
            let start = Instant::now();
            let count = list.len() as u32;
            self.prepared.batches.list(list)?;
            self.prepared.batches.batch_samples = (self.batch / count).clamp(1, abi::LOOP_CAP / 2);
            let part = Part::listed(self.settings.width, count);
            let done = traced.marks.len() as u64 * each;
            match self.prepared.batches.samples(&part, samples.clone(), &mut observer, done, total)? {
                End::Done(n, _) if u64::from(n) < each => break,
                End::Done(_, more) => {
                    let (film, marks) = self.prepared.batches.film(count)?;
                    traced.sums.par_extend(film.par_iter().with_min_len(PIECE).map(sum));
                    traced.marks.par_extend(marks.par_iter().with_min_len(PIECE).map(mark));
                    self.tally.add(&more);
                    let seconds = start.elapsed().as_secs_f64();
                    let shortest = self.pace.map_or(f64::INFINITY, |(_, shortest)| shortest);
                    self.pace = Some((seconds / (count as f64 * each as f64), seconds.min(shortest)));
                }
                End::Overflow if self.prepared.batches.batch_samples > 1 => {
                    self.batch = (self.prepared.batches.batch_samples / 2).max(1).saturating_mul(count);
                    parts.push(list);
                }
                End::Overflow => {
                    if let [pixel] = list {
                        let width = self.settings.width;
                        return Err(self.prepared.batches.pixel_too_deep(pixel % width, pixel / width));
                    }
                    let (first, second) = list.split_at(list.len() / 2);
                    parts.extend([second, first]);
                }
            }
            if observer.cancelled() || !go_on(&observer) {
                break;
            }
        }
        Ok(traced)
    }

    /// Pixels of the next part, `each` samples of each; none if there is no time for any.
    fn part_pixels(&self, each: u64) -> usize {
        let most = self.prepared.batches.plan.tile_pixels as usize;
        let left = self.deadline.map(|d| d.saturating_duration_since(Instant::now()).as_secs_f64());
        let samples = match (self.pace, left) {
            (None, Some(left)) if left <= 0.0 => return 0,
            (None, left) => {
                let samples = if left.is_some() { FIRST_SAMPLES } else { FIRST_AT_LEISURE };
                return ((samples / each as f64) as usize).clamp(1, most);
            }
            (Some((sample, _)), None) => PART_SECONDS / sample,
            // Even few samples take as long as the shortest part.
            (Some((_, shortest)), Some(left)) if left < 1.5 * shortest => return 0,
            (Some((sample, _)), Some(left)) => {
                let samples = (PART_SHARE * left).min(PART_SECONDS) / sample;
                if samples < each as f64 && left < each as f64 * sample {
                    return 0;
                }
                samples
            }
        };
        ((samples / each as f64) as usize).clamp(1, most)
    }
}

/// An observer that cancels at a time, too.
struct InTime<'a> {
    observer: &'a mut dyn Observer,
    deadline: Option<Instant>,
}

impl Observer for InTime<'_> {
    fn progress(&mut self, done: u64, total: u64) {
        self.observer.progress(done, total);
    }

    fn cancelled(&self) -> bool {
        self.observer.cancelled() || self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
    }

    fn wants_state(&self) -> bool {
        self.observer.wants_state()
    }
}

/// A mark as the host reads it.
fn mark(m: &abi::Mark) -> Mark {
    let cut = u64::from(m.cut_high) << 32 | u64::from(m.cut_low);
    Mark {
        hash_least: !m.hash_least_inverted,
        hash_most: m.hash_most,
        rays: m.rays,
        depth: m.depth,
        cut: cut as f64 / f64::from(abi::CUT_ONE),
    }
}

//! One render in progress: tiles, batches, submits.

use super::parts::{Again, Parts};
use super::tally::Tally;
use super::upload::uploads;
use super::{Observer, RenderError};
use crate::kernel::abi::{self, Buf, DepthCount, Film, Mark};
use crate::plan::Plan;
use crate::plan::dispatches::{Batch, FIRST_REACH, Step, dispatches_to};
use crate::plan::passes::Size;
use crate::plan::tiles::Tile;
use crate::prepare::Packed;
use crate::report::test_counts::tests_of;
use crate::report::timeline::Submit;
use crate::settings::Settings;
use crate::vk::{Buffers, DISPATCHES_MAX, Device, Dispatch, Pipelines, Recorder, Timed, VkError};
use std::ops::Range;
use std::rc::Rc;

/// Device time of one submit to aim at: well under the two seconds after which some systems take a
/// device for hung, and often enough for a progress bar.
const SUBMIT_SECONDS: f64 = 0.25;

/// By how much the depths that are dispatched grow when a ray gets beyond them: from 16 to the greatest, 1,024, in three
/// submits in vain, which together hold a third of the greatest's dispatches.
const REACH_FACTOR: u32 = 4;

/// What poisoned buffers hold.
const QUIET_NAN: u32 = 0x7fc0_0000;
/// Buffers whose contents do not outlive a submit.
const TRANSIENT: &[Buf] = &[
    Buf::Rays,
    Buf::NextRays,
    Buf::Media,
    Buf::NextMedia,
    Buf::Queue,
    Buf::NextQueue,
    Buf::Hits,
    Buf::Surfaces,
    Buf::ChildCounts,
    Buf::ChildMasks,
    Buf::Offsets,
    Buf::RayIndices,
    Buf::Contributions,
    Buf::SampleRadiance,
    Buf::Paths,
    Buf::Walks,
];

/// Pixels that are traced together: a tile, or a list.
#[derive(Debug, Clone, Copy)]
pub(super) struct Part {
    /// Image coordinates of a tile's first pixel; 0 for a list.
    x: u32,
    y: u32,
    /// Pixels per row of a tile; of the image for a list.
    width: u32,
    pub(super) pixels: u32,
}

impl From<&Tile> for Part {
    fn from(tile: &Tile) -> Part {
        Part { x: tile.x, y: tile.y, width: tile.width, pixels: tile.pixels() }
    }
}

impl Part {
    /// A list of pixels, row * `width` + column.
    pub(super) fn listed(width: u32, pixels: u32) -> Part {
        Part { x: 0, y: 0, width, pixels }
    }
}

/// The batches of a plan: its buffers and recorder, and the batch size that fits the scene.
pub(crate) struct Batches {
    pub(super) device: Rc<Device>,
    pub(crate) pipelines: Rc<Pipelines>,
    /// For batches whose walks do not end in one dispatch, from the first of them on.
    pub(crate) parts: Option<Box<Parts>>,
    pub(crate) buffers: Buffers,
    pub(crate) recorder: Recorder,
    pub(super) settings: Settings,
    pub(super) plan: Plan,
    lights: u32,
    pub(super) batch_samples: u32,
    /// Passes of greater depths are not dispatched, until a ray gets there.
    reach: u32,
    /// The greatest depth that a ray got to.
    deepest: u32,
    /// Device seconds per sample so far, to size the next submit.
    rate: f64,
    /// Fill what the kernels write with NaN before each submit.
    pub(super) poisoned: bool,
    /// Submits so far, where they are to be kept; each then holds one batch.
    pub(super) trace: Option<Vec<Submit>>,
}

impl Batches {
    pub(crate) fn new(
        device: &Rc<Device>,
        pipelines: Rc<Pipelines>,
        packed: &Packed,
        camera: abi::double::Camera,
        settings: &Settings,
        plan: &Plan,
    ) -> Result<Batches, VkError> {
        let film = plan.buffer_bytes[Buf::Film as usize] + plan.buffer_bytes[Buf::Marks as usize];
        let counts = plan.buffer_bytes[Buf::DepthCounts as usize] + plan.buffer_bytes[Buf::Counters as usize];
        let mut buffers = Buffers::new(device, &plan.buffer_bytes, film.max(counts))?;
        let mut recorder = Recorder::new(device, &pipelines, &buffers, plan.specialisation.workgroup)?;
        let camera = [camera];
        // A scene may be packed for either walk; the plan has room for the nodes of one.
        let unused = if plan.walks_in_packets() { Buf::Nodes } else { Buf::CompressedNodes };
        for upload in uploads(packed, &camera, settings.precision) {
            if upload.buffer == unused {
                continue;
            }
            recorder.upload_made(&mut buffers, upload.buffer, upload.shape, &|from, out| {
                upload.fill(from, out)
            })?;
        }
        Ok(Batches {
            device: Rc::clone(device),
            parts: None,
            pipelines,
            buffers,
            recorder,
            settings: settings.clone(),
            plan: plan.clone(),
            lights: plan.specialisation.light_count,
            batch_samples: plan.batch_samples,
            reach: FIRST_REACH,
            deepest: 1,
            rate: 0.0,
            poisoned: false,
            trace: None,
        })
    }

    /// Runs every kernel once on one pixel: a software device compiles at the first dispatch.
    pub(super) fn warm_up(&mut self) -> Result<(), RenderError> {
        let [x, y, ..] = self.settings.region();
        let tile = Tile { x, y, width: 1, height: 1 };
        self.recorder.begin()?;
        for buffer in [Buf::Film, Buf::Pixels, Buf::Marks, Buf::DepthCounts, Buf::Counters] {
            self.recorder.fill(&self.buffers, buffer, 0);
        }
        self.batch(&Part::from(&tile), 0..1, 0..1, self.settings.depth.min(2))?;
        self.recorder.submit(&self.buffers)?;
        Ok(())
    }

    /// Starts over: batches as planned, no pace known.
    pub(super) fn begin(&mut self) {
        (self.batch_samples, self.rate) = (self.plan.batch_samples, 0.0);
    }

    /// Puts a tile whose queue overflowed, and the samples that it has, back to `work`, for smaller batches or in
    /// halves.
    pub(super) fn retry(
        &mut self,
        (tile, samples): (Tile, u32),
        work: &mut Vec<(Tile, u32)>,
    ) -> Result<(), RenderError> {
        if self.batch_samples > 1 {
            self.batch_samples /= 2;
            work.push((tile, samples));
            return Ok(());
        }
        let halves = tile.halves().ok_or_else(|| self.pixel_too_deep(tile.x, tile.y))?;
        work.extend(halves.into_iter().rev().map(|half| (half, samples)));
        Ok(())
    }

    pub(super) fn pixel_too_deep(&self, x: u32, y: u32) -> RenderError {
        RenderError::TooManyRays { pixel: Some([x, y]), capacity: self.plan.capacity }
    }

    /// Samples of all pixels of a part, from scratch. `done` of `total` samples were there before.
    pub(super) fn samples(
        &mut self,
        part: &Part,
        samples: Range<u32>,
        observer: &mut dyn Observer,
        done: u64,
        total: u64,
    ) -> Result<End, RenderError> {
        self.samples_onto(None, part, samples, observer, done, total)
    }

    /// As [`Batches::samples`], added to `film`, the sums of the samples before them.
    pub(super) fn samples_onto(
        &mut self,
        film: Option<&[Film]>,
        part: &Part,
        samples: Range<u32>,
        observer: &mut dyn Observer,
        done: u64,
        total: u64,
    ) -> Result<End, RenderError> {
        if let Some(film) = film {
            self.recorder.upload(&mut self.buffers, Buf::Film, bytemuck::cast_slice(film))?;
        }
        let pixels = u64::from(part.pixels);
        let mut tally = Tally { tiles: 1, pixels, ..Tally::default() };
        let last_depth = self.plan.max_depth.last_depth(self.settings.depth, self.settings.cutoff);
        let mut first = samples.start;
        while first < samples.end {
            // A submit with a walk that does not end, or with rays beyond its passes, is void, but it has changed the film.
            let may_be_void = self.parts.is_some() || self.reach < last_depth;
            let held = match first > samples.start && may_be_void {
                true => Some(self.film(part.pixels)?),
                false => None,
            };
            self.recorder.begin()?;
            self.poison();
            if first == samples.start {
                if film.is_none() {
                    self.recorder.fill(&self.buffers, Buf::Film, 0);
                }
                self.recorder.fill(&self.buffers, Buf::Marks, 0);
            }
            self.recorder.fill(&self.buffers, Buf::DepthCounts, 0);
            self.recorder.fill(&self.buffers, Buf::Counters, 0);
            let begin = first;
            let most = self.samples_per_submit(part);
            let (mut per_batch, mut batches) = (0, 0);
            while first < samples.end
                && (first == begin || first - begin < most)
                && self.recorder.dispatches() + per_batch <= DISPATCHES_MAX
            {
                let batch = self.batch_samples.min(samples.end - first);
                let before = self.recorder.dispatches();
                self.batch(part, first..first + batch, samples.clone(), self.settings.depth)?;
                per_batch = self.recorder.dispatches() - before;
                first += batch;
                batches += 1;
            }
            self.download_counts();
            let timed = match self.recorder.submit(&self.buffers) {
                // Nothing of this part can be read any more.
                Err(VkError::Interrupted { .. }) => return Ok(End::Done(0, tally)),
                timed => timed?,
            };
            self.note(u64::from(first - begin) * pixels, pixels, &timed);
            if self.reach < last_depth && self.goes_beyond_reach() {
                self.reach = self.reach.saturating_mul(REACH_FACTOR);
                tally.add_timings(&timed);
                match &held {
                    Some((film, marks)) => self.restore(Some(film), marks)?,
                    None => self.restore(film, &[])?,
                }
                first = begin;
                continue;
            }
            if self.read_counter(abi::COUNTER_UNFINISHED) != 0 {
                let (from, film, marks) = match held {
                    Some((film, marks)) => (begin, Some(film), Some(marks)),
                    None => (samples.start, film.map(<[Film]>::to_vec), None),
                };
                if from < begin {
                    tally = Tally { tiles: 1, pixels, ..Tally::default() };
                }
                let again = Again { part, samples: from..first, range: samples.clone(), film, marks };
                let done = done + u64::from(from - samples.start) * pixels;
                match self.samples_again(again, &mut tally, observer, done, total)? {
                    None => return Ok(End::Overflow),
                    Some(end) if end < first => return Ok(End::Done(end - samples.start, tally)),
                    Some(_) => {}
                }
            } else if self.read_overflow() {
                return Ok(End::Overflow);
            } else {
                self.add_counts(&mut tally);
                if last_depth > FIRST_REACH {
                    self.look_ahead(&tally);
                }
                tally.batches += batches;
                self.add_traced(&mut tally, u64::from(first - begin) * pixels, &timed);
            }
            observer.progress(done + u64::from(first - samples.start) * pixels, total);
            if observer.cancelled() {
                break;
            }
        }
        Ok(End::Done(first - samples.start, tally))
    }

    /// True if rays were left for a depth whose passes were not dispatched, by the counts that were downloaded.
    fn goes_beyond_reach(&mut self) -> bool {
        let bytes = self.buffers.bytes(Buf::DepthCounts) as usize;
        let depths = &self.buffers.staging_bytes()[..bytes];
        // Depth d stands at d - 1.
        let beyond = depths.chunks_exact(size_of::<DepthCount>()).nth(self.reach as usize);
        beyond.is_some_and(|d| bytemuck::pod_read_unaligned::<DepthCount>(d).traced != 0)
    }

    /// Dispatches half as many depths again as rays have got to, and at least two more.
    fn look_ahead(&mut self, tally: &Tally) {
        let deepest = tally.depths.iter().rposition(|d| d[0] != 0).map_or(1, |at| at as u32 + 1);
        self.deepest = self.deepest.max(deepest);
        self.reach = self.deepest + (self.deepest / 2).max(2);
    }

    /// Puts the sums of pixels and their marks in place; what is not given is nothing.
    pub(super) fn restore(&mut self, film: Option<&[Film]>, marks: &[Mark]) -> Result<(), VkError> {
        self.recorder.begin()?;
        for buffer in [Buf::Film, Buf::Marks] {
            self.recorder.fill(&self.buffers, buffer, 0);
        }
        self.recorder.submit(&self.buffers)?;
        if let Some(film) = film {
            self.recorder.upload(&mut self.buffers, Buf::Film, bytemuck::cast_slice(film))?;
        }
        if !marks.is_empty() {
            self.recorder.upload(&mut self.buffers, Buf::Marks, bytemuck::cast_slice(marks))?;
        }
        Ok(())
    }

    /// Samples of a pixel in the next submit: one batch until the pace is known, then as many as
    /// fill the aimed time, within what the 32-bit counts of a submit can hold.
    fn samples_per_submit(&self, part: &Part) -> u32 {
        if self.rate <= 0.0 || self.trace.is_some() {
            return 1;
        }
        let per_sample = self.rate * f64::from(part.pixels);
        let rays = f64::from(self.plan.capacity) / f64::from(self.batch_samples);
        let counted = f64::from(u32::MAX) / (rays * f64::from(self.lights.max(1)));
        (SUBMIT_SECONDS / per_sample).min(counted).max(1.0) as u32
    }

    /// Fills what the kernels write with NaN, if it is to be.
    pub(super) fn poison(&mut self) {
        if self.poisoned {
            for buffer in TRANSIENT {
                self.recorder.fill(&self.buffers, *buffer, QUIET_NAN);
            }
        }
    }

    /// Records that the counts go to the staging buffer.
    pub(super) fn download_counts(&mut self) {
        let counts = self.buffers.bytes(Buf::DepthCounts);
        self.recorder.download(&self.buffers, Buf::DepthCounts, counts, 0);
        self.recorder.download(&self.buffers, Buf::Counters, self.buffers.bytes(Buf::Counters), counts);
    }

    /// One of the counters that were downloaded.
    fn read_counter(&mut self, counter: u32) -> u32 {
        let at = self.buffers.bytes(Buf::DepthCounts) as usize + 4 * counter as usize;
        bytemuck::pod_read_unaligned(&self.buffers.staging_bytes()[at..at + 4])
    }

    /// True if a queue was too small, by the counts that were downloaded.
    pub(super) fn read_overflow(&mut self) -> bool {
        self.read_counter(abi::COUNTER_QUEUE_OVERFLOW) != 0
    }

    /// Adds samples and their times, from which the next submit is sized.
    pub(super) fn add_traced(&mut self, tally: &mut Tally, traced: u64, timed: &[Timed]) {
        tally.depths[0][0] += traced;
        tally.samples += traced;
        tally.add_timings(timed);
        let seconds: f64 = timed.iter().map(|t| t.seconds).sum();
        self.rate = seconds / traced as f64;
    }

    /// Adds the counts that were downloaded.
    pub(super) fn add_counts(&mut self, tally: &mut Tally) {
        let bytes = self.buffers.bytes(Buf::DepthCounts) as usize;
        let end = bytes + self.buffers.bytes(Buf::Counters) as usize;
        let staging = self.buffers.staging_bytes();
        let depths: Vec<DepthCount> = bytemuck::pod_collect_to_vec(&staging[..bytes]);
        let counters: Vec<u32> = bytemuck::pod_collect_to_vec(&staging[bytes..end]);
        let counted = Tally {
            depths: depths
                .iter()
                .map(|d| [d.traced, d.reflections, d.refractions, d.shadow].map(u64::from))
                .collect(),
            // Walks that went on have ended.
            counters: std::array::from_fn(|i| match i as u32 {
                abi::COUNTER_UNFINISHED => 0,
                _ => u64::from(counters[i]),
            }),
            tests: tests_of(&counters),
            ..Tally::default()
        };
        tally.add(&counted);
    }

    /// `samples` of every pixel of `part`, some of the `range` that the film sums.
    pub(super) fn batch_of(&self, part: &Part, samples: Range<u32>, range: Range<u32>, depth: u32) -> Batch {
        let Part { x, y, width, pixels } = *part;
        let (first_sample, samples) = (samples.start, samples.end - samples.start);
        let range = (range.start, range.end - range.start);
        let last_depth = self.plan.max_depth.last_depth(depth, self.settings.cutoff);
        Batch { x, y, width, pixels, first_sample, samples, range, last_depth }
    }

    /// Records the dispatches of [`Batches::batch_of`].
    fn batch(
        &mut self,
        part: &Part,
        samples: Range<u32>,
        range: Range<u32>,
        depth: u32,
    ) -> Result<(), VkError> {
        let batch = self.batch_of(part, samples, range, depth);
        let pixels = part.pixels;
        let (push, queue) = (batch.push(&self.plan, &self.settings), batch.first_queue(&self.plan));
        self.recorder.update(&self.buffers, Buf::Queue, bytemuck::cast_slice(&[queue]))?;
        for step in dispatches_to(&self.plan, batch.last_depth, self.reach) {
            let items = match step.pass.size {
                Size::Samples => batch.rays(),
                Size::Pixels => pixels,
                Size::Rays | Size::Walks | Size::One => 0,
            };
            let Step { pass, depth, .. } = step;
            let dispatch = Dispatch { pass, depth, push: step.push(push), items };
            self.recorder.dispatch(&self.pipelines, &self.buffers, &dispatch);
        }
        Ok(())
    }

    /// Running sums of the first `pixels` pixels, each with all its sets of samples, and, of a survey, their
    /// marks.
    pub(super) fn film(&mut self, pixels: u32) -> Result<(Vec<Film>, Vec<Mark>), RenderError> {
        let spec = &self.plan.specialisation;
        let sums = u64::from(pixels) * u64::from(spec.film_sums()) * size_of::<Film>() as u64;
        let marks = u64::from(pixels) * u64::from(spec.survey) * size_of::<Mark>() as u64;
        self.recorder.begin()?;
        self.recorder.download(&self.buffers, Buf::Film, sums, 0);
        if marks > 0 {
            self.recorder.download(&self.buffers, Buf::Marks, marks, sums);
        }
        self.recorder.submit(&self.buffers)?;
        self.note(0, 0, &[]);
        let (sums, end) = (sums as usize, (sums + marks) as usize);
        let staging = self.buffers.staging_bytes();
        Ok((
            bytemuck::pod_collect_to_vec(&staging[..sums]),
            bytemuck::pod_collect_to_vec(&staging[sums..end]),
        ))
    }

    /// Cuts paths at other places; never deeper than planned.
    pub(super) fn cut_at(&mut self, depth: u32, cutoff: f32) {
        (self.settings.depth, self.settings.cutoff) = (depth, cutoff);
    }

    /// Puts the pixels of a list in place.
    pub(super) fn list(&mut self, pixels: &[u32]) -> Result<(), RenderError> {
        Ok(self.recorder.upload(&mut self.buffers, Buf::Pixels, bytemuck::cast_slice(pixels))?)
    }
}

pub(super) enum End {
    /// So many samples of every pixel are in the film; what they counted.
    Done(u32, Tally),
    /// A queue was too small; nothing of the part counts.
    Overflow,
}

/// The sum of one set of samples in f64.
pub(super) fn sum(film: &Film) -> [f64; 3] {
    std::array::from_fn(|c| f64::from(film.sum[c]) + f64::from(film.compensation[c]))
}

/// Mean of a pixel's `samples` samples over all its sets; added in f64, rounded once.
pub(crate) fn mean(sets: &[Film], samples: u32) -> [f32; 3] {
    let total = sets.iter().map(sum).reduce(|a, b| std::array::from_fn(|c| a[c] + b[c])).unwrap_or_default();
    total.map(|channel| (channel / f64::from(samples.max(1))) as f32)
}

//! Batches in which a walk takes more steps than one dispatch may: done again, with walks that go on from dispatch to
//! dispatch until none is left. Everything for it is made when the first such batch comes; a scene without one pays
//! nothing.

use super::batches::{Batches, Part};
use super::tally::Tally;
use super::{Observer, RenderError};
use crate::kernel::abi::{self, Buf, Film, Mark, Push};
use crate::kernel::table::Kernel;
use crate::plan::dispatches::{Step, dispatches};
use crate::plan::passes::{Size, at_depth};
use crate::plan::{Plan, WALKS};
use crate::vk::{Dispatch, Pipelines, Recorder, Timed, VkError};
use std::ops::Range;

/// Kernels that go on, and their commands.
pub(crate) struct Parts {
    plan: Plan,
    pipelines: Pipelines,
    recorder: Recorder,
}

/// The samples to do again, and what the film held before them.
pub(super) struct Again<'a> {
    pub(super) part: &'a Part,
    pub(super) samples: Range<u32>,
    /// The samples that the film sums.
    pub(super) range: Range<u32>,
    /// `None`: nothing.
    pub(super) film: Option<Vec<Film>>,
    /// `None`: nothing.
    pub(super) marks: Option<Vec<Mark>>,
}

/// How a batch in parts ended.
enum BatchEnd {
    Done,
    Overflow,
    Cancelled,
}

/// What one step's walks did.
struct Walked {
    rays: u32,
    /// Walks that were given up.
    lost: u64,
}

/// What is asked between two submits.
type Stop<'a> = &'a mut dyn FnMut() -> bool;

impl Batches {
    /// Makes kernels and room for walks that go on, if they are not there.
    ///
    /// # Errors
    /// If there is too little memory, or the device fails.
    pub(crate) fn prepare_parts(&mut self) -> Result<(), VkError> {
        if self.parts.is_some() {
            return Ok(());
        }
        let plan = self.plan.in_parts();
        let (set, double) = (*self.pipelines.set(), self.pipelines.double());
        let kernels = plan.kernels().into_iter();
        let pipelines = Pipelines::new(&self.device, set, kernels, &plan.specialisation, double)?;
        self.buffers.lengthen(&plan.buffer_bytes)?;
        self.recorder = self.recorder.renewed(&self.pipelines, &self.buffers)?;
        let recorder = self.recorder.renewed(&pipelines, &self.buffers)?;
        self.parts = Some(Box::new(Parts { plan, pipelines, recorder }));
        Ok(())
    }

    /// Does samples again, batch by batch. Gives how far it came, the end unless it was cancelled; `None` if a queue
    /// was too small: nothing of the part counts then. `done` of `total` samples were there before.
    pub(super) fn samples_again(
        &mut self,
        again: Again<'_>,
        tally: &mut Tally,
        observer: &mut dyn Observer,
        done: u64,
        total: u64,
    ) -> Result<Option<u32>, RenderError> {
        let Again { part, samples, range, film, marks } = again;
        self.prepare_parts()?;
        self.restore(film.as_deref(), marks.as_deref().unwrap_or_default())?;
        let mut first = samples.start;
        while first < samples.end {
            let batch = self.batch_samples.min(samples.end - first);
            let done = done + u64::from(first - samples.start) * u64::from(part.pixels);
            let mut stop = || {
                observer.progress(done, total);
                observer.cancelled()
            };
            match self.batch_in_parts(part, first..first + batch, range.clone(), tally, &mut stop)? {
                BatchEnd::Done => first += batch,
                BatchEnd::Overflow => return Ok(None),
                BatchEnd::Cancelled => break,
            }
            if observer.cancelled() {
                break;
            }
        }
        Ok(Some(first))
    }

    fn batch_in_parts(
        &mut self,
        part: &Part,
        samples: Range<u32>,
        range: Range<u32>,
        tally: &mut Tally,
        stop: Stop<'_>,
    ) -> Result<BatchEnd, RenderError> {
        let traced = u64::from(samples.end - samples.start) * u64::from(part.pixels);
        let batch = self.batch_of(part, samples, range, self.settings.depth);
        let (push, queue) = (batch.push(&self.plan, &self.settings), batch.first_queue(&self.plan));
        self.recorder.begin()?;
        self.poison();
        for buffer in [Buf::DepthCounts, Buf::Counters] {
            self.recorder.fill(&self.buffers, buffer, 0);
        }
        self.recorder.update(&self.buffers, Buf::Queue, bytemuck::cast_slice(&[queue]))?;
        self.recorder.submit(&self.buffers)?;
        let Some(parts) = &self.parts else { return Ok(BatchEnd::Cancelled) };
        let steps: Vec<Step> = dispatches(&parts.plan, batch.last_depth).collect();
        let items = |size| if size == Size::Samples { batch.rays() } else { part.pixels };
        let mut timed = Vec::new();
        let Some(lost) = self.run_in_parts(&steps, push, items, &mut timed, stop)? else {
            return Ok(BatchEnd::Cancelled);
        };
        self.recorder.begin()?;
        self.download_counts();
        self.recorder.submit(&self.buffers)?;
        if self.read_overflow() {
            return Ok(BatchEnd::Overflow);
        }
        self.add_counts(tally);
        tally.counters[abi::COUNTER_LOOP_CAP as usize] += lost;
        tally.batches += 1;
        self.add_traced(tally, traced, &timed);
        Ok(BatchEnd::Done)
    }

    /// Runs `steps` of a plan in parts, walks until none is left. Gives the number of those that were given up, 0 unless
    /// the device errs; `None` if it was stopped. `items`: of the passes that the host sizes.
    pub(crate) fn run_in_parts(
        &mut self,
        steps: &[Step],
        push: Push,
        items: impl Fn(Size) -> u32,
        timed: &mut Vec<Timed>,
        stop: Stop<'_>,
    ) -> Result<Option<u64>, VkError> {
        let (mut lost, mut empty) = (0, false);
        for steps in steps.chunk_by(|a, b| a.pass.kernel != Kernel::Walk && b.pass.kernel != Kernel::Walk) {
            if let [step] = steps
                && step.pass.kernel == Kernel::Walk
            {
                if !empty {
                    match self.walk(step, push, timed, stop)? {
                        Some(walked) => (lost, empty) = (lost + walked.lost, walked.rays == 0),
                        None => return Ok(None),
                    }
                }
                continue;
            }
            // Where no ray is, there is none at greater depths either.
            let steps: Vec<&Step> = steps.iter().filter(|step| step.depth == 0 || !empty).collect();
            if steps.is_empty() {
                continue;
            }
            let Some(Parts { pipelines, recorder, .. }) = self.parts.as_deref_mut() else { return Ok(None) };
            recorder.begin()?;
            for step in steps {
                let (pass, depth) = (step.pass, step.depth);
                let d = Dispatch { pass, depth, push: step.push(push), items: items(pass.size) };
                recorder.dispatch(pipelines, &self.buffers, &d);
            }
            timed.extend(recorder.submit(&self.buffers)?);
            if stop() {
                return Ok(None);
            }
        }
        Ok(Some(lost))
    }

    /// All walks of one step, some rays at a time, as [`Batches::run_in_parts`].
    fn walk(
        &mut self,
        step: &Step,
        push: Push,
        timed: &mut Vec<Timed>,
        stop: Stop<'_>,
    ) -> Result<Option<Walked>, VkError> {
        let rounds = self.rounds_most();
        let Some(Parts { pipelines, recorder, .. }) = self.parts.as_deref_mut() else { return Ok(None) };
        let buffers = &mut self.buffers;
        let queue = at_depth(Buf::Queue, step.depth);
        recorder.begin()?;
        recorder.download(buffers, queue, QUEUE_BYTES, 0);
        recorder.download(buffers, Buf::Counters, COUNTER_BYTES, QUEUE_BYTES);
        recorder.submit(buffers)?;
        let staging = buffers.staging_bytes();
        let count = bytemuck::pod_read_unaligned::<abi::Queue>(&staging[..QUEUE_BYTES as usize]).count;
        let mut unfinished = unfinished_in(&staging[QUEUE_BYTES as usize..]);
        let mut lost = 0;
        for walk_first in (0..count).step_by(WALKS as usize) {
            let items = WALKS.min(count - walk_first);
            for walk_round in 0.. {
                let push = Push { walk_first, walk_round, items, ..step.push(push) };
                recorder.begin()?;
                let d = Dispatch { pass: step.pass, depth: step.depth, push, items };
                recorder.dispatch(pipelines, buffers, &d);
                recorder.download(buffers, Buf::Counters, COUNTER_BYTES, 0);
                timed.extend(recorder.submit(buffers)?);
                let now = unfinished_in(buffers.staging_bytes());
                let left = now.wrapping_sub(unfinished);
                unfinished = now;
                if stop() {
                    return Ok(None);
                }
                if left == 0 {
                    break;
                }
                if walk_round >= rounds {
                    lost += u64::from(left);
                    break;
                }
            }
        }
        Ok(Some(Walked { rays: count, lost }))
    }

    /// Dispatches that end every walk on a device that computes what it should: a walk meets each node and each
    /// primitive once, there are no more nodes than primitives, and a primitive costs 12 steps at most: one for its node,
    /// one for the filter, 3 and 3 for the loop around them, which its leaf and it may leave, 4 for the outermost.
    fn rounds_most(&self) -> u32 {
        let spec = &self.plan.specialisation;
        let primitives = u64::from(spec.triangle_count) + u64::from(spec.sphere_count);
        u32::try_from(12 * (primitives + 1) / u64::from(spec.loop_cap.max(1)) + 2).unwrap_or(u32::MAX)
    }
}

const QUEUE_BYTES: u64 = size_of::<abi::Queue>() as u64;
const COUNTER_BYTES: u64 = 4 * abi::COUNTERS as u64;

/// Walks that did not end, of the counters' bytes.
fn unfinished_in(counters: &[u8]) -> u32 {
    counters.chunks_exact(4).nth(abi::COUNTER_UNFINISHED as usize).map_or(0, bytemuck::pod_read_unaligned)
}

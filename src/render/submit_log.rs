//! Submits as they happened, for a timeline.

use super::Batches;
use crate::kernel::abi::{Buf, COUNTER_QUEUE_OVERFLOW, DepthCount};
use crate::plan::passes::{self, Size};
use crate::report::timeline::{Dispatched, Submit};
use crate::vk::Timed;

impl Batches {
    /// Keeps the submit that has just ended, if submits are kept; it traced `samples` samples of `pixels`
    /// pixels in one batch, or only copied.
    pub(super) fn note(&mut self, samples: u64, pixels: u64, timed: &[Timed]) {
        let (Some(_), Some([begin, end])) = (&self.trace, self.recorder.submitted()) else { return };
        let counts = self.counts(timed);
        let passes = timed
            .iter()
            .map(|t| {
                let size = passes::all().find(|p| p.kernel == t.kernel).map(|p| p.size);
                let at = |depth: u32| {
                    if depth == 1 {
                        return Some(samples);
                    }
                    let traced =
                        |c: &Vec<DepthCount>| c.get(depth as usize - 1).map_or(0, |d| d.traced.into());
                    counts.as_ref().map(traced)
                };
                let (items, children) = match size {
                    Some(Size::Samples) => (Some(samples), Some(0)),
                    Some(Size::Pixels) => (Some(pixels), Some(0)),
                    Some(Size::Rays) => (at(t.depth), at(t.depth + 1)),
                    Some(Size::Walks) => (at(t.depth), Some(0)),
                    Some(Size::One) => (Some(1), Some(0)),
                    None => (None, None),
                };
                let Timed { kernel, depth, begin, seconds } = *t;
                Dispatched { kernel, depth, begin, seconds, items, children, samples }
            })
            .collect();
        if let Some(trace) = &mut self.trace {
            trace.push(Submit { begin, end, passes });
        }
    }

    /// Rays of each depth that the submit counted; None if a queue was too small: they are retraced.
    fn counts(&mut self, timed: &[Timed]) -> Option<Vec<DepthCount>> {
        if timed.is_empty() {
            return None;
        }
        let bytes = self.buffers.bytes(Buf::DepthCounts) as usize;
        let (depths, counters) = self.buffers.staging_bytes().split_at(bytes);
        let overflow = counters.chunks(4).nth(COUNTER_QUEUE_OVERFLOW as usize)?;
        (overflow == [0; 4]).then(|| bytemuck::pod_collect_to_vec(depths))
    }
}

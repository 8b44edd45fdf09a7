//! Samples for all pixels of an image, tile by tile: all of them at once, or, where the image is watched, in rounds of
//! 1, 1, 2, 4, ... samples. A tile goes on from its sums on the host, so that the bits do not tell how often it was
//! left and taken up.

use super::batches::{Batches, End, Part};
use super::film::Drawn;
use super::{ImageSoFar, Observer, RenderError};
use std::time::Instant;

/// What becomes of a state that an observer wants.
pub(super) type Keep<'a> = dyn FnMut(&mut Drawn, &mut dyn Observer) + 'a;

impl Batches {
    /// Every sample that `drawn` lacks, until done or cancelled. Gives the share of samples that are there.
    pub(super) fn draw(
        &mut self,
        drawn: &mut Drawn,
        observer: &mut dyn Observer,
        keep: &mut Keep<'_>,
    ) -> Result<f64, RenderError> {
        let samples = self.settings.samples;
        let start = Instant::now();
        let mut end = if observer.watches() { 1 } else { samples };
        loop {
            if !self.draw_to(end, drawn, observer, keep)? {
                break;
            }
            if observer.watches() {
                observer.image(&ImageSoFar {
                    linear: &drawn.sums.linear(),
                    samples: f64::from(end),
                    rays: drawn.tally.rays(),
                    seconds: start.elapsed().as_secs_f64(),
                });
            }
            if end == samples {
                return Ok(1.0);
            }
            end = end.saturating_mul(2).min(samples);
        }
        let total = drawn.sums.pixels() * u64::from(samples);
        Ok(drawn.sums.done() as f64 / total as f64)
    }

    /// Brings every pixel to `end` samples; false if it was cancelled before.
    fn draw_to(
        &mut self,
        end: u32,
        drawn: &mut Drawn,
        observer: &mut dyn Observer,
        keep: &mut Keep<'_>,
    ) -> Result<bool, RenderError> {
        let total = drawn.sums.pixels() * u64::from(self.settings.samples);
        let mut done = drawn.sums.done();
        let mut work = drawn.sums.left(end, self.plan.tile_pixels);
        while let Some((tile, first)) = work.pop() {
            let before = (first > 0).then(|| drawn.sums.of(&tile));
            let mut pausing = Pausing { observer: &mut *observer, last: done, fresh: false };
            match self.samples_onto(
                before.as_deref(),
                &Part::from(&tile),
                first..end,
                &mut pausing,
                done,
                total,
            )? {
                // Nothing of it counts, and the film may hold anything.
                End::Done(0, _) => work.push((tile, first)),
                End::Done(traced, mut tally) => {
                    let (films, _) = self.film(tile.pixels())?;
                    drawn.sums.set(&tile, first + traced, &films);
                    done += u64::from(tile.pixels()) * u64::from(traced);
                    if first > 0 {
                        // Every tile and pixel counts once.
                        (tally.tiles, tally.pixels) = (0, 0);
                    }
                    drawn.tally.add(&tally);
                    if first + traced < end {
                        work.push((tile, first + traced));
                    }
                }
                End::Overflow => self.retry((tile, first), &mut work)?,
            }
            if observer.cancelled() {
                return Ok(work.is_empty());
            }
            if observer.wants_state() && !work.is_empty() {
                keep(drawn, observer);
            }
        }
        Ok(true)
    }
}

/// An observer that cancels where a state is wanted, too: the samples so far are then fetched from the device. It does so
/// once after samples were added: samples that come in many parts ([`Batches::samples_again`]) are not given up halfway,
/// however long they take.
struct Pausing<'a> {
    observer: &'a mut dyn Observer,
    /// Samples that were there when it was last told.
    last: u64,
    /// True if there are more of them than the time before.
    fresh: bool,
}

impl Observer for Pausing<'_> {
    fn progress(&mut self, done: u64, total: u64) {
        (self.fresh, self.last) = (done > self.last, done);
        self.observer.progress(done, total);
    }

    fn cancelled(&self) -> bool {
        self.observer.cancelled() || self.fresh && self.observer.wants_state()
    }
}

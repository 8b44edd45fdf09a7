//! Progress of a whole whose length is learnt on the way: it only goes forward.

use crate::render::{ImageSoFar, Observer, State};
use std::time::Instant;

/// Steps of the whole.
const STEPS: f64 = 10_000.0;

/// An observer of parts, each of which stands for a span of the whole.
pub(super) struct MonotoneProgress<'a> {
    observer: &'a mut dyn Observer,
    /// Where the part that runs begins and ends, as shares of the whole.
    span: [f64; 2],
    furthest: f64,
    /// The whole is this time, in seconds: spans mean nothing.
    clock: Option<(Instant, f64)>,
}

impl<'a> MonotoneProgress<'a> {
    pub(super) fn new(observer: &'a mut dyn Observer) -> MonotoneProgress<'a> {
        MonotoneProgress { observer, span: [0.0, 1.0], furthest: 0.0, clock: None }
    }

    /// What follows is this span of the whole. Shares that were passed are not gone back to.
    pub(super) fn span(&mut self, from: f64, to: f64) {
        self.span = [from.clamp(0.0, 1.0), to.clamp(from.clamp(0.0, 1.0), 1.0)];
    }

    /// The whole is `seconds` from `start` on.
    pub(super) fn by_clock(&mut self, start: Instant, seconds: f64) {
        self.clock = Some((start, seconds));
    }
}

impl Observer for MonotoneProgress<'_> {
    fn progress(&mut self, done: u64, total: u64) {
        let share = match self.clock {
            Some((start, seconds)) => start.elapsed().as_secs_f64() / seconds,
            None => {
                let [from, to] = self.span;
                from + (to - from) * (done as f64 / total.max(1) as f64)
            }
        };
        self.furthest = self.furthest.max(share.min(1.0));
        self.observer.progress((STEPS * self.furthest) as u64, STEPS as u64);
    }

    fn cancelled(&self) -> bool {
        self.observer.cancelled()
    }

    fn watches(&self) -> bool {
        self.observer.watches()
    }

    fn image(&mut self, so_far: &ImageSoFar<'_>) {
        self.observer.image(so_far);
    }

    fn wants_state(&self) -> bool {
        self.observer.wants_state()
    }

    fn keep(&mut self, state: &dyn State) {
        self.observer.keep(state);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Seen(Vec<u64>);

    impl Observer for Seen {
        fn progress(&mut self, done: u64, total: u64) {
            assert_eq!(total, STEPS as u64);
            self.0.push(done);
        }
        fn cancelled(&self) -> bool {
            false
        }
    }

    #[test]
    fn it_never_goes_back_nor_past_the_end() {
        let mut seen = Seen(Vec::new());
        let mut forward = MonotoneProgress::new(&mut seen);
        forward.span(0.0, 0.5);
        forward.progress(1, 2);
        forward.progress(2, 2);
        // More is ahead than was thought.
        forward.span(0.25, 0.75);
        forward.progress(1, 4);
        forward.progress(3, 4);
        forward.span(0.9, 7.0);
        forward.progress(5, 4);
        assert_eq!(seen.0, [2500, 5000, 5000, 6250, 10_000]);
    }
}

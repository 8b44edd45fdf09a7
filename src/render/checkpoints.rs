//! States of long work, written every few seconds: whatever ends the process, no more is lost.

use super::{ImageSoFar, Observer, State};
use std::time::{Duration, Instant};

/// Share of the time that writing states may take.
const WRITING: f64 = 0.05;

/// Writes a state.
pub type Write<'a> = Box<dyn FnMut(&dyn State) + 'a>;

/// An observer that also writes states.
pub struct Checkpoints<'a> {
    observer: &'a mut dyn Observer,
    write: Option<Write<'a>>,
    every: Duration,
    due: Instant,
}

impl<'a> Checkpoints<'a> {
    /// Calls `write` every `seconds`, or less often where writing would take more than a twentieth of the time. Without
    /// `write`, or with 0 `seconds`, no state is written.
    pub fn new(observer: &'a mut dyn Observer, write: Option<Write<'a>>, seconds: f64) -> Checkpoints<'a> {
        let write = write.filter(|_| seconds > 0.0);
        let every = Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX);
        Checkpoints { observer, write, every, due: after(every) }
    }
}

/// A time in the future, however far.
fn after(time: Duration) -> Instant {
    let now = Instant::now();
    now.checked_add(time).unwrap_or(now + Duration::from_secs(1 << 30))
}

impl Observer for Checkpoints<'_> {
    fn progress(&mut self, done: u64, total: u64) {
        self.observer.progress(done, total);
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
        self.write.is_some() && Instant::now() >= self.due
    }

    fn keep(&mut self, state: &dyn State) {
        let Some(write) = &mut self.write else { return };
        let start = Instant::now();
        write(state);
        self.due = after(self.every.max(start.elapsed().div_f64(WRITING)));
    }
}

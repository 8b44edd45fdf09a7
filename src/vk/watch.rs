//! Waiting for a driver. It may compile for minutes, within a call or a dispatch, and no call of Vulkan ends that: the wait is
//! given up where the user interrupts, and told of where it is long.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Time between two looks at the user's wish, where a driver does not answer.
pub(super) const LOOK: Duration = Duration::from_millis(20);
/// Time that a driver has to finish compiling after an interrupt, so that an interrupt is answered within two seconds.
const PATIENCE: Duration = Duration::from_millis(1200);
/// A wait is told of after this time, and again whenever it has doubled.
const LONG: Duration = Duration::from_secs(2);

/// Who is asked and told while a driver is waited for.
#[derive(Debug, Clone, Copy)]
pub struct Watch {
    /// True once the user wants an end.
    pub stopped: fn() -> bool,
    /// Is given what a driver has been at for how long.
    pub long: fn(&str, Duration),
}

static WATCH: OnceLock<Watch> = OnceLock::new();
static ABANDONED: AtomicBool = AtomicBool::new(false);

/// Has waits of this process watched; the first call counts. Without one, they last as long as the driver takes.
pub fn watch(watch: Watch) {
    WATCH.get_or_init(|| watch);
}

/// True if a driver was left at its work. It still uses what it was given, so nothing of Vulkan is destroyed any more,
/// and calls that would wait fail. The process ends by [`end`].
pub fn is_abandoned() -> bool {
    ABANDONED.load(Ordering::SeqCst)
}

/// Ends the process at once. Leaving in the usual way destroys what threads of a driver still use.
pub fn end(code: u8) -> ! {
    #[cfg(unix)]
    // SAFETY: takes no pointer and does not return; whatever is buffered in this program has been written.
    unsafe {
        libc::_exit(code.into())
    }
    #[cfg(not(unix))]
    std::process::exit(code.into())
}

/// A wait in progress, for work that may compile.
pub(super) struct Wait {
    watch: Option<Watch>,
    begun: Instant,
    tell_after: Duration,
    stopped: Option<Instant>,
}

impl Wait {
    /// Begins now.
    pub(super) fn new() -> Wait {
        Wait { watch: WATCH.get().copied(), begun: Instant::now(), tell_after: LONG, stopped: None }
    }

    /// To be called every [`LOOK`]; `at` says what the driver is at. False if the wait is to be given up: the
    /// driver counts as abandoned from then on.
    pub(super) fn goes_on(&mut self, at: impl FnOnce() -> String) -> bool {
        let Some(watch) = self.watch else { return true };
        if self.is_over(Instant::now(), (watch.stopped)()) {
            ABANDONED.store(true, Ordering::SeqCst);
            return false;
        }
        let waited = self.begun.elapsed();
        if waited >= self.tell_after {
            self.tell_after = waited * 2;
            (watch.long)(&at(), waited);
        }
        true
    }

    fn is_over(&mut self, now: Instant, stopped: bool) -> bool {
        stopped && now - *self.stopped.get_or_insert(now) >= PATIENCE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interrupt_leaves_the_driver_some_time() {
        let mut wait = Wait::new();
        let begun = wait.begun;
        let after = |ms| begun + Duration::from_millis(ms);
        assert!(!wait.is_over(after(100_000), false));
        assert!(!wait.is_over(after(100_000), true));
        assert!(!wait.is_over(after(100_500), true));
        assert!(wait.is_over(after(101_500), true));
        assert!(PATIENCE + 2 * LOOK < Duration::from_millis(1500));
    }

    /// Nothing watches the tests of a library.
    #[test]
    fn unwatched_waits_go_on() {
        assert!(Wait::new().goes_on(|| unreachable!("nobody is told")) && !is_abandoned());
    }
}

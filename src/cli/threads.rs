//! Threads of this process: as many as there are cores, or one where the system does not allow that many.

use anyhow::anyhow;
use rayon::ThreadPoolBuilder;
use std::sync::OnceLock;
use std::sync::mpsc::channel;
use std::thread;

/// Threads of a device's driver beside one for each core, and of this program: for signals, caches and queues.
const DRIVER: usize = 8;
/// Threads that the system starts and those that a device needs, where these are more.
static SHORT: OnceLock<[usize; 2]> = OnceLock::new();

/// Checks that a device can be used: some drivers wait for ever for threads that could not be started.
///
/// # Errors
/// If the system starts fewer threads than driver and program have.
pub(super) fn check() -> anyhow::Result<()> {
    match SHORT.get() {
        None => Ok(()),
        Some([started, needed]) => Err(anyhow!(
            "the system lets this process start {started} threads, and a device needs up to {needed}: raise the limit \
             on processes (ulimit -u, the control group's pids.max) or on memory (ulimit -v)"
        )),
    }
}

/// Starts the threads that work is shared among. Where the system starts fewer than there are cores (`ulimit -u`, a
/// control group, little address space), all work is done by the calling thread: rayon by itself would end the
/// process.
pub fn start() {
    let pool = ThreadPoolBuilder::new();
    // As many as rayon would start: cores, or RAYON_NUM_THREADS.
    let asked = std::env::var("RAYON_NUM_THREADS").ok().and_then(|n| n.parse().ok()).filter(|n| *n > 0);
    let wanted = asked.unwrap_or_else(|| thread::available_parallelism().map_or(1, usize::from));
    let all = DRIVER + 2 * wanted;
    let started = can_start(all);
    let pool = match started >= wanted {
        true => pool.num_threads(wanted),
        false => pool.num_threads(1).use_current_thread(),
    };
    if started < all {
        // Set once, here.
        let _ = SHORT.set([started, all]);
    }
    // It fails only where a pool is there already.
    drop(pool.build_global());
}

/// How many of `count` threads the system lets this process have at the same time, beside those there are.
fn can_start(count: usize) -> usize {
    let mut waiting = Vec::with_capacity(count);
    for _ in 0..count {
        let (release, released) = channel::<()>();
        match thread::Builder::new().spawn(move || released.recv().is_ok()) {
            Ok(handle) => waiting.push((handle, release)),
            Err(_) => break,
        }
    }
    let started = waiting.len();
    let handles: Vec<_> = waiting.into_iter().map(|(handle, _)| handle).collect();
    handles.into_iter().for_each(|handle| drop(handle.join()));
    started
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_few_threads_can_be_started_and_end() {
        assert_eq!((super::can_start(0), super::can_start(3)), (0, 3));
    }
}

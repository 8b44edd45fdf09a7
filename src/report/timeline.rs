//! When things happened, on the host and on the device, as Chrome trace events: complete events in
//! microseconds ("Trace Event Format", Chromium project), which Perfetto and chrome://tracing open.

use crate::kernel::table::Kernel;
use serde_json::{Value, json};
use std::time::Instant;

/// Something the host did.
#[derive(Debug, Clone)]
pub struct Phase {
    /// What.
    pub name: String,
    /// From.
    pub begin: Instant,
    /// To.
    pub end: Instant,
}

impl Phase {
    /// From `begin` to now.
    pub fn since(name: impl Into<String>, begin: Instant) -> Phase {
        Phase { name: name.into(), begin, end: Instant::now() }
    }
}

/// One submit with its dispatches.
#[derive(Debug, Clone)]
pub struct Submit {
    /// Just before it, by the host's clock.
    pub begin: Instant,
    /// Just after its end was seen.
    pub end: Instant,
    /// In order; none where it only copied.
    pub passes: Vec<Dispatched>,
}

/// One dispatch of a pass.
#[derive(Debug, Clone, Copy)]
pub struct Dispatched {
    /// What ran.
    pub kernel: Kernel,
    /// At which depth, from 1; 0 outside the loop.
    pub depth: u32,
    /// Seconds by the device's clock, which has any zero; None without timestamps.
    pub begin: Option<f64>,
    /// Until the barrier that closes it.
    pub seconds: f64,
    /// Live rays, samples or pixels; None if a queue was too small and nothing of the submit
    /// counts.
    pub items: Option<u64>,
    /// Rays at the next depth; 0 where the pass makes none, None as above.
    pub children: Option<u64>,
    /// Samples of the batch.
    pub samples: u64,
}

/// One render.
#[derive(Debug, Clone, Default)]
pub struct RenderTimeline {
    /// One after the other.
    pub phases: Vec<Phase>,
    /// Inside the last phase.
    pub submits: Vec<Submit>,
}

const PROCESS: u32 = 1;
const HOST: u32 = 1;
const DEVICE: u32 = 2;

/// The trace: `phases` and submits of the host, and the device's passes. Times count from `zero`;
/// `bytes` says what a dispatch moves, if that is known.
pub fn trace(
    zero: Instant,
    device: &str,
    phases: &[Phase],
    submits: &[Submit],
    bytes: impl Fn(&Dispatched) -> Option<u64>,
) -> Value {
    let mut events = vec![
        json!({"name": "process_name", "ph": "M", "pid": PROCESS, "tid": HOST, "args": {"name": "whitted"}}),
        json!({"name": "thread_name", "ph": "M", "pid": PROCESS, "tid": HOST, "args": {"name": "host"}}),
        json!({"name": "thread_name", "ph": "M", "pid": PROCESS, "tid": DEVICE, "args": {"name": device}}),
    ];
    for phase in phases {
        events.push(event(&phase.name, HOST, span(zero, phase.begin, phase.end), json!({})));
    }
    let alignment = Alignment::of(zero, submits);
    let mut free = 0;
    for (number, submit) in submits.iter().enumerate() {
        let host = span(zero, submit.begin, submit.end);
        let name = if submit.passes.is_empty() { "read pixels" } else { "submit" };
        events.push(event(name, HOST, host, json!({"submit": number, "dispatches": submit.passes.len()})));
        let shift = alignment.shift(zero, submit);
        for (pass, begin) in submit.passes.iter().zip(begins(submit)) {
            // Whole nanoseconds; the end of one is the beginning of the next, whatever rounding
            // says.
            let at = |seconds: f64| (1e9 * (seconds + shift)).round().max(0.0) as u64;
            let (begin, end) = (at(begin).max(free), at(begin + pass.seconds).max(free));
            free = end;
            let args = json!({
                "depth": pass.depth,
                "items": pass.items,
                "bytes": bytes(pass),
                "submit": number,
            });
            events.push(event(pass.kernel.name(), DEVICE, [begin, end], args));
        }
    }
    json!({
        "traceEvents": events,
        "displayTimeUnit": "ms",
        "otherData": {
            "device_clock": alignment.words(),
            "device_clock_uncertainty_us": alignment.uncertainty().map(|s| 1e6 * s),
        },
    })
}

fn event(name: &str, track: u32, [begin, end]: [u64; 2], args: Value) -> Value {
    let (ts, dur) = (begin as f64 / 1e3, (end - begin) as f64 / 1e3);
    json!({"name": name, "ph": "X", "ts": ts, "dur": dur, "pid": PROCESS, "tid": track, "args": args})
}

/// Nanoseconds after `zero`.
fn span(zero: Instant, begin: Instant, end: Instant) -> [u64; 2] {
    let [begin, end] = [begin, end].map(|t| t.saturating_duration_since(zero).as_nanos() as u64);
    [begin, end.max(begin)]
}

/// Where each dispatch begins by the device's clock; without timestamps, one after the other from
/// 0.
fn begins(submit: &Submit) -> Vec<f64> {
    let mut next = 0.0;
    let stamped = stamped(submit);
    let begin = |pass: &Dispatched| {
        let begin = pass.begin.filter(|_| stamped).unwrap_or(next);
        next = begin + pass.seconds;
        begin
    };
    submit.passes.iter().map(begin).collect()
}

fn stamped(submit: &Submit) -> bool {
    submit.passes.iter().all(|p| p.begin.is_some())
}

/// What to add to the device's clock to have the host's.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Alignment {
    /// One number for all: least and greatest with which every submit's passes lie between the
    /// submit and its end.
    Whole(f64, f64),
    /// The clocks differ in pace, or there are no timestamps: each submit by itself.
    Each,
}

/// Least and greatest shift with which this submit's passes lie between the submit and its end.
fn bounds(zero: Instant, submit: &Submit) -> Option<(f64, f64)> {
    let begins = begins(submit);
    let (first, last) = (begins.first()?, begins.last()? + submit.passes.last()?.seconds);
    let seconds = |t: Instant| t.saturating_duration_since(zero).as_secs_f64();
    Some((seconds(submit.begin) - first, seconds(submit.end) - last))
}

impl Alignment {
    fn of(zero: Instant, submits: &[Submit]) -> Alignment {
        let all = submits.iter().filter_map(|s| bounds(zero, s));
        let (low, high) =
            all.fold((f64::NEG_INFINITY, f64::INFINITY), |(low, high), (l, h)| (low.max(l), high.min(h)));
        if submits.iter().all(stamped) && low <= high && low.is_finite() && high.is_finite() {
            Alignment::Whole(low, high)
        } else {
            Alignment::Each
        }
    }

    fn shift(self, zero: Instant, submit: &Submit) -> f64 {
        match self {
            Alignment::Whole(low, high) => low + (high - low) / 2.0,
            Alignment::Each => bounds(zero, submit).map_or(0.0, |(low, high)| low + (high - low) / 2.0),
        }
    }

    /// Half of what is left open.
    fn uncertainty(self) -> Option<f64> {
        match self {
            Alignment::Whole(low, high) => Some((high - low) / 2.0),
            Alignment::Each => None,
        }
    }

    fn words(self) -> &'static str {
        match self {
            Alignment::Whole(..) => {
                "one offset between device and host clock for all submits: the middle of the range that keeps every pass inside its submit"
            }
            Alignment::Each => "one offset per submit, which centres its passes in it",
        }
    }
}

#[cfg(test)]
mod tests;

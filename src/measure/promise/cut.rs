//! Where paths are cut: the depth and the least throughput, from what a few pixels lose and cost.

use super::traced::Tracing;
use super::{DEEPEST, REPLICATES};
use crate::measure::gathered::Gathered;
use crate::measure::limit::RadianceLimit;
use crate::render::RenderError;

/// Depths that are tried, in this order.
const LADDER: [u32; 14] = [1, 2, 3, 4, 5, 6, 8, 10, 13, 17, 24, 32, 48, DEEPEST];
/// Pixels that are looked at.
pub(super) const PIXELS: u32 = 4096;
/// A deeper cut is not tried once a sample takes this many rays.
const MOST_RAYS: f64 = 4096.0;
/// Shares of an error that a single ray may hide, tried as weight cuts.
const SHARES: [f64; 4] = [1.0, 0.3, 0.1, 0.03];

/// A place to cut paths, and what it does in a few pixels.
#[derive(Debug, Clone)]
pub(super) struct Cut {
    pub(super) depth: u32,
    pub(super) cutoff: f32,
    /// Truncation part of the error.
    pub(super) hidden: f64,
    /// Rays of a sample.
    pub(super) rays: f64,
    /// Root of the expected squared error of [`REPLICATES`] samples a pixel.
    pub(super) noise: f64,
}

impl Cut {
    /// What it costs to make the sampling part small enough for the whole to be `target`, but for a
    /// factor: samples go with the -4/3 power of their error (edges; Mitchell, SIGGRAPH 1996).
    fn cost(&self, target: f64) -> f64 {
        let left = target - self.hidden;
        if left > 0.0 { self.rays * left.powf(-4.0 / 3.0) } else { f64::INFINITY }
    }

    /// The error to expect of so many rays.
    fn error(&self, rays: f64, pixels: u32) -> f64 {
        let samples = (rays / self.rays / f64::from(pixels)).max(1.0);
        self.hidden + self.noise * (samples / f64::from(REPLICATES)).powf(-0.75)
    }
}

/// What cutting there does in a few pixels.
pub(super) fn look(
    tracing: &mut Tracing<'_>,
    limit: &RadianceLimit,
    depth: u32,
    cutoff: f32,
) -> Result<Cut, RenderError> {
    tracing.survey.cut_at(depth, cutoff);
    let places = tracing.region.spread(PIXELS);
    let traced = crate::measure::samples::Source::trace(tracing, &places, 0..REPLICATES)?;
    // The pixels looked at are an image of their own.
    let count = traced.marks.len() as u32;
    let mut seen = Gathered::new(count, 1, REPLICATES as usize);
    seen.add(&(0..count).collect::<Vec<_>>(), REPLICATES, &traced);
    let rays: u64 = seen.marks.iter().map(|m| u64::from(m.rays)).sum();
    let noise = seen.noise();
    Ok(Cut {
        depth,
        cutoff,
        hidden: seen.truncation(limit).rms,
        rays: rays as f64 / f64::from((count * REPLICATES).max(1)),
        noise: (noise.squares / f64::from(count.max(1))).sqrt(),
    })
}

/// Deeper and deeper cuts, until nothing is hidden, `enough` says so, or a sample has too many rays.
fn ladder(
    tracing: &mut Tracing<'_>,
    limit: &RadianceLimit,
    mut enough: impl FnMut(&[Cut]) -> bool,
) -> Result<Vec<Cut>, RenderError> {
    let mut rungs = Vec::new();
    for depth in LADDER {
        match look(tracing, limit, depth, 0.0) {
            Ok(rung) => rungs.push(rung),
            // One sample's rays outgrew the queue: deeper ones would all the more.
            Err(RenderError::DoesNotFit(_)) if !rungs.is_empty() => break,
            Err(error) => return Err(error),
        }
        let last = &rungs[rungs.len() - 1];
        if last.hidden == 0.0 || last.rays > MOST_RAYS || enough(&rungs) || tracing.observer.cancelled() {
            break;
        }
    }
    Ok(rungs)
}

/// The cheapest cut for an error of `target`; the one that hides least where none will do.
pub(super) fn for_error(
    tracing: &mut Tracing<'_>,
    limit: &RadianceLimit,
    target: f64,
) -> Result<Cut, RenderError> {
    // Once a rung costs more than the best, deeper ones do too: they hide less, but not less than nothing.
    let past_best = |rungs: &[Cut]| {
        let best = rungs.iter().map(|r| r.cost(target)).fold(f64::INFINITY, f64::min);
        rungs.last().is_some_and(|last| last.rays * target.powf(-4.0 / 3.0) > best)
    };
    let mut cuts = ladder(tracing, limit, past_best)?;
    let brightest = limit.rgb.iter().fold(0.0, |m: f64, c| m.max(*c));
    let deepest = cuts.iter().map(|c| c.depth).max().unwrap_or(1);
    let reached = cuts.iter().any(|c| c.cost(target).is_finite());
    if brightest > 0.0 && brightest.is_finite() && deepest > 1 {
        for share in SHARES {
            let cutoff = (share * target / brightest) as f32;
            if cutoff >= 1.0 {
                continue;
            }
            let depth = if reached { best(&cuts, target).map_or(deepest, |c| c.depth) } else { DEEPEST };
            match look(tracing, limit, depth, cutoff) {
                Ok(cut) => cuts.push(cut),
                Err(RenderError::DoesNotFit(_)) => break,
                Err(error) => return Err(error),
            }
            if tracing.observer.cancelled() {
                break;
            }
        }
    }
    let least_hidden = cuts.iter().min_by(|a, b| a.hidden.total_cmp(&b.hidden)).cloned();
    best(&cuts, target)
        .cloned()
        .or(least_hidden)
        .ok_or_else(|| RenderError::Failed("no depth was tried".into()))
}

fn best(cuts: &[Cut], target: f64) -> Option<&Cut> {
    let possible = cuts.iter().filter(|c| c.cost(target).is_finite());
    possible.min_by(|a, b| a.cost(target).total_cmp(&b.cost(target)))
}

/// The cut of the least error for `rays` rays in all; `pace` says if there is time to look further.
pub(super) fn for_rays(
    tracing: &mut Tracing<'_>,
    limit: &RadianceLimit,
    rays: impl Fn() -> f64,
    in_time: impl Fn() -> bool,
) -> Result<Cut, RenderError> {
    let pixels = tracing.region.pixels();
    let worse = |rungs: &[Cut]| {
        let [.., before, last] = rungs else { return !in_time() };
        !in_time() || last.error(rays(), pixels) > before.error(rays(), pixels)
    };
    let rungs = ladder(tracing, limit, worse)?;
    let error = |cut: &Cut| cut.error(rays(), pixels);
    let best = rungs.into_iter().min_by(|a, b| error(a).total_cmp(&error(b)));
    best.ok_or_else(|| RenderError::Failed("no depth was tried".into()))
}

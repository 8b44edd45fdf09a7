//! Where paths are cut: the depth and the least throughput, from what a few pixels lose and cost.

use super::traced::Tracing;
use super::{DEEPEST, LOOK_SAMPLES};
use crate::accuracy::radiance_bound::RadianceLimit;
use crate::render::RenderError;
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// Depths that are tried, in this order.
const LADDER: [u32; 20] = [1, 2, 3, 4, 5, 6, 8, 10, 13, 17, 24, 32, 48, 64, 96, 144, 216, 324, 512, DEEPEST];
/// Rungs that a ladder climbs beyond the first that hides nothing in the pixels looked at: the others may hide
/// something yet, and empty depths cost next to nothing.
const MARGIN: usize = 3;
/// Depths beyond one and a half times that of the longest path in the pixels looked at.
const ROOM: u32 = 4;
/// A cut that costs as much as this share of another's is no better: to look for it costs more than it saves.
const ALIKE: f64 = 0.9;
/// Pixels that are looked at.
pub(super) const PIXELS: u32 = 4096;
/// A deeper cut is not tried once a sample takes this many rays.
const MOST_RAYS: f64 = 512.0;
/// Fewest, where that many are in the region.
const LEAST_PIXELS: f64 = 256.0;
/// Greatest share of a region's pixels that is looked at, so that looking at a dozen cuts costs no more than a
/// sample or two of every pixel.
const PIXEL_SHARE: f64 = 1.0 / 16.0;
/// Samples of each, where only cuts are chosen: other pixels tell more than other samples.
pub(super) const CUT_SAMPLES: u32 = 1;
/// Rays that one look may take, more or less.
const LOOK_RAYS: f64 = 1e6;
/// Share of an error that a single ray may hide, tried as a weight cut; then [`SHARE_MORE`] where that pays, else
/// [`SHARE_LESS`]. [`LEAST_SHARE`] is that of all other looks, which keeps branching paths from growing without end.
const SHARE: f64 = 0.3;
const SHARE_MORE: f64 = 1.0;
const SHARE_LESS: f64 = 0.1;
const LEAST_SHARE: f64 = 0.02;

/// A ray that hides less is not traced where time is short: an eighth of an 8-bit code.
const NEGLIGIBLE: f64 = 5e-4;

/// Pixels of the first look where time is short.
const FIRST_PIXELS: u32 = 256;
/// Share of the time for looks that one of them may take.
const LOOK_SHARE: f64 = 0.3;
/// RMS difference of a pixel to its neighbour that stands for it, as it is in ordinary pictures.
const NEIGHBOUR: f64 = 0.1;

/// A depth and cutoff at which paths are cut, with their effect in a few pixels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct TruncationChoice {
    pub(super) depth: u32,
    pub(super) cutoff: f32,
    /// Truncation part of the error.
    pub(super) hidden: f64,
    /// Rays of a sample.
    pub(super) rays: f64,
    /// Root of the expected squared error of the samples a pixel that were looked at.
    pub(super) noise: f64,
    /// True if no path that was looked at is as long as the depth: what is hidden, if anything, the cutoff hides.
    pub(super) all_ended: bool,
}

impl TruncationChoice {
    /// What it costs to make the sampling part small enough for the whole to be `target`, but for a
    /// factor: samples go with the -4/3 power of their error (edges; Mitchell, SIGGRAPH 1996).
    fn cost(&self, target: f64) -> f64 {
        let left = target - self.hidden;
        if left > 0.0 { self.rays * left.powf(-4.0 / 3.0) } else { f64::INFINITY }
    }

    /// A depth and cutoff whose effect is not known.
    pub(super) fn unseen(depth: u32, cutoff: f32) -> TruncationChoice {
        TruncationChoice { depth, cutoff, hidden: 0.0, rays: 1.0, noise: 0.0, all_ended: false }
    }

    /// Expected error of an image of `rays` rays.
    fn error(&self, rays: f64, pixels: u32) -> f64 {
        self.hidden + self.sampling(rays, pixels)
    }

    /// Its sampling part. Where the rays do not even make a pilot, pixels are as their neighbours.
    fn sampling(&self, rays: f64, pixels: u32) -> f64 {
        let share = rays / (self.rays * f64::from(pixels) * f64::from(LOOK_SAMPLES));
        let untraced = (1.0 - share).max(0.0);
        self.noise * share.max(1.0).powf(-0.75) + NEIGHBOUR * untraced.sqrt()
    }
}

/// Effect of a depth and cutoff in `pixels` pixels of `samples` samples; `None` if cancelled or out of time.
pub(super) fn look(
    tracing: &mut Tracing<'_>,
    limit: &RadianceLimit,
    depth: u32,
    cutoff: f32,
    (pixels, samples): (u32, u32),
) -> Result<Option<TruncationChoice>, RenderError> {
    tracing.survey.cut_at(depth, cutoff);
    let places = tracing.region.spread(pixels);
    let seen = tracing.see(&places, samples)?;
    let count = seen.samples.len() as u32;
    if (count as usize) < places.len() {
        return Ok(None);
    }
    let rays: u64 = seen.marks.iter().map(|m| u64::from(m.rays)).sum();
    let noise = seen.noise();
    // Depths that no path reaches are dispatched all the same. What is cut there after all is counted.
    let deepest = seen.marks.iter().map(|m| m.depth).max().unwrap_or(depth);
    Ok(Some(TruncationChoice {
        depth: depth.min(deepest + deepest / 2 + ROOM),
        cutoff,
        hidden: seen.truncation(limit).rms,
        rays: rays as f64 / f64::from((count * samples).max(1)),
        noise: (noise.variance() / f64::from(count.max(1))).sqrt(),
        all_ended: deepest < depth,
    }))
}

/// Pixels to look at with `samples` samples after `last`, of `pixels`: fewer where samples take many rays.
fn enough_pixels(pixels: u32, samples: u32, last: Option<&TruncationChoice>) -> u32 {
    let rays = last.map_or(1.0, |c| 2.0 * c.rays);
    let most = (PIXEL_SHARE * f64::from(pixels)).clamp(LEAST_PIXELS, f64::from(PIXELS));
    (LOOK_RAYS / (rays * f64::from(samples))).clamp(LEAST_PIXELS, most) as u32
}

/// Pixels and samples to look at after `last` where only cuts are chosen.
pub(super) fn for_cuts(pixels: u32, last: Option<&TruncationChoice>) -> (u32, u32) {
    (enough_pixels(pixels, CUT_SAMPLES, last), CUT_SAMPLES)
}

/// The depth at which `target` is hidden, if what is hidden goes on falling from depth to depth as it did over the last two
/// rungs; 0 where that is no matter.
fn needed(rungs: &[TruncationChoice], target: f64) -> f64 {
    let [.., before, last] = rungs else { return 0.0 };
    let fall = (before.hidden / last.hidden).ln() / (f64::from(last.depth) - f64::from(before.depth));
    let more = (last.hidden / target).ln() / fall;
    if fall > 0.0 && more > 0.0 { f64::from(last.depth) + more } else { 0.0 }
}

/// Cuts deeper than `after`, one after the other, until nothing is hidden, `enough` says so, or a sample has
/// too many rays. Those that would hide more than `target` are left out as far as that can be foretold.
fn ladder(
    tracing: &mut Tracing<'_>,
    limit: &RadianceLimit,
    (target, after): (f64, u32),
    cutoff: f32,
    mut enough: impl FnMut(&[TruncationChoice]) -> bool,
) -> Result<Vec<TruncationChoice>, RenderError> {
    let mut rungs: Vec<TruncationChoice> = Vec::new();
    let depths: Vec<u32> = LADDER.into_iter().filter(|d| *d > after || *d == DEEPEST).collect();
    for (i, &depth) in depths.iter().enumerate() {
        // The next one is looked at that is not too shallow.
        if depths.get(i + 1).is_some_and(|next| f64::from(*next) <= needed(&rungs, target)) {
            continue;
        }
        match look(tracing, limit, depth, cutoff, for_cuts(tracing.region.pixels(), rungs.last())) {
            Ok(Some(rung)) => rungs.push(rung),
            Ok(None) => break,
            // One sample's rays outgrew the queue: deeper ones would all the more.
            Err(error) if error.does_not_fit() && !rungs.is_empty() => break,
            Err(error) => return Err(error),
        }
        let last = &rungs[rungs.len() - 1];
        if last.hidden == 0.0 || last.all_ended {
            let beyond = depths[(i + MARGIN).min(depths.len() - 1)];
            let deeper = TruncationChoice { depth: beyond.max(last.depth), ..last.clone() };
            rungs.push(deeper);
            break;
        }
        if last.rays > MOST_RAYS || enough(&rungs) || tracing.observer.cancelled() {
            break;
        }
    }
    Ok(rungs)
}

/// The cheapest cut deeper than `after` for an error of `target`; the one that hides least where none will do.
pub(super) fn for_error(
    tracing: &mut Tracing<'_>,
    limit: &RadianceLimit,
    target: f64,
    after: u32,
) -> Result<TruncationChoice, RenderError> {
    // Once a rung is as dear as the best, deeper ones are too: they hide less, but not less than nothing.
    let past_best = |rungs: &[TruncationChoice]| {
        let best = rungs.iter().map(|r| r.cost(target)).fold(f64::INFINITY, f64::min);
        rungs.last().is_some_and(|last| last.rays * target.powf(-4.0 / 3.0) > ALIKE * best)
    };
    let brightest = limit.rgb.iter().fold(0.0, |m: f64, c| m.max(*c));
    let least = if brightest.is_finite() { LEAST_SHARE * target / brightest.max(1.0) } else { 0.0 };
    let mut cuts = ladder(tracing, limit, (target, after), least as f32, past_best)?;
    let deepest = cuts.iter().map(|c| c.depth).max().unwrap_or(1);
    let reached = cuts.iter().any(|c| c.cost(target).is_finite());
    if brightest > 0.0 && brightest.is_finite() && deepest > 1 {
        let mut share = SHARE;
        loop {
            let cutoff = ((share * target / brightest) as f32).min(1.0);
            let (depth, before) =
                best(&cuts, target).map_or((DEEPEST, f64::INFINITY), |c| (c.depth, c.cost(target)));
            let depth = if reached { depth } else { DEEPEST };
            match look(tracing, limit, depth, cutoff, for_cuts(tracing.region.pixels(), cuts.last())) {
                Ok(Some(cut)) => cuts.push(cut),
                Ok(None) => break,
                Err(error) if error.does_not_fit() => break,
                Err(error) => return Err(error),
            }
            if share != SHARE || tracing.observer.cancelled() {
                break;
            }
            let pays = cuts.last().is_some_and(|cut| cut.cost(target) <= before);
            share = if pays { SHARE_MORE } else { SHARE_LESS };
        }
    }
    let least_hidden = cuts.iter().rev().min_by(|a, b| a.hidden.total_cmp(&b.hidden)).cloned();
    Ok(best(&cuts, target).cloned().or(least_hidden).unwrap_or(TruncationChoice::unseen(1, 0.0)))
}

fn best(cuts: &[TruncationChoice], target: f64) -> Option<&TruncationChoice> {
    // Of equals the deepest.
    let possible = cuts.iter().rev().filter(|c| c.cost(target).is_finite());
    possible.min_by(|a, b| a.cost(target).total_cmp(&b.cost(target)))
}

/// The cut of the least error for what is left of the time, `left()` seconds, and rays a second of the device; `None` if
/// there was no time to look. No look is begun that would not be done `by` then.
pub(super) fn for_time(
    tracing: &mut Tracing<'_>,
    limit: &RadianceLimit,
    left: impl Fn() -> f64,
    by: Instant,
) -> Result<Option<(TruncationChoice, f64)>, RenderError> {
    let all = tracing.region.pixels();
    let brightest = limit.rgb.iter().fold(1.0, |m: f64, c| m.max(*c));
    let cutoff = (NEGLIGIBLE / brightest) as f32;
    let mut rungs: Vec<TruncationChoice> = Vec::new();
    // Small looks are slow looks: the device is at least as fast as in the best of them.
    let mut pace = 0.0;
    for (i, depth) in LADDER.into_iter().enumerate() {
        let in_time = by.saturating_duration_since(Instant::now()).as_secs_f64();
        let pixels = match rungs.last() {
            None => FIRST_PIXELS,
            // Another depth at most doubles the rays of a sample.
            Some(last) => {
                let rays = 2.0 * last.rays * f64::from(LOOK_SAMPLES);
                enough_pixels(tracing.region.pixels(), LOOK_SAMPLES, Some(last))
                    .min((LOOK_SHARE * in_time * pace / rays) as u32)
            }
        };
        if in_time <= 0.0 || (i > 0 && pixels < FIRST_PIXELS / 4) {
            break;
        }
        let start = Instant::now();
        tracing.survey.finish_by(Some(by));
        let seen = look(tracing, limit, depth, cutoff, (pixels, LOOK_SAMPLES));
        tracing.survey.finish_by(None);
        let rung = match seen {
            Ok(Some(rung)) => rung,
            Ok(None) => break,
            Err(error) if error.does_not_fit() && !rungs.is_empty() => break,
            Err(error) => return Err(error),
        };
        let rays = rung.rays * f64::from(tracing.region.spread(pixels).len() as u32 * LOOK_SAMPLES);
        pace = f64::max(pace, rays / start.elapsed().as_secs_f64());
        let (nothing_hidden, many_rays) = (rung.hidden == 0.0, rung.rays > MOST_RAYS);
        rungs.push(rung.clone());
        if nothing_hidden {
            let beyond = LADDER[(i + MARGIN).min(LADDER.len() - 1)];
            rungs.push(TruncationChoice { depth: beyond, ..rung });
            break;
        }
        // Deeper cuts err by their sampling part at least.
        let rays = pace * left();
        let best = rungs.iter().map(|r| r.error(rays, all)).fold(f64::INFINITY, f64::min);
        if rung.sampling(rays, all) > best || many_rays || tracing.observer.cancelled() {
            break;
        }
    }
    let error = |cut: &TruncationChoice| cut.error(pace * left(), all);
    let best = rungs.into_iter().rev().min_by(|a, b| error(a).total_cmp(&error(b)));
    Ok(best.map(|cut| (cut, pace)))
}

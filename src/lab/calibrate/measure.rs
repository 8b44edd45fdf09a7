//! Measures one scene: its trials first, then the truth that their errors need, then the judgement.

use super::bench::{Bench, Image};
use super::judge::Shown;
use super::layer::LayerTrial;
use super::plan::Trials;
use super::record::{
    BudgetRecord, ErrorRecord, ErrorTrialRecord, PlainInTime, PlainRecord, SceneRecord, TimeRecord,
};
use super::seeds;
use super::truth::{Paths, Tracer, Truth};
use crate::render::{Observer, RenderError, Renderer};
use crate::scene::Scene;
use crate::settings::Settings;
use crate::stats::median;
use std::time::Instant;

/// The truth's own RMSE / the smallest error judged.
const TRUTH_SHARE: f64 = 0.1;
/// Expected true error of `--error` / error asked for.
const REACHED_SHARE: f64 = 0.5;
/// Smallest error judged where there is no estimate.
const UNKNOWN_ERROR: f64 = 3e-3;
/// Share of the seeds in which a plain render must keep an error.
const PLAIN_SHARE: f64 = 0.95;
/// Error falls with the samples to this power at most (Owen, Annals of Statistics 25, 1997: smooth integrands).
const STEEPEST: f64 = 1.5;
/// Rays of a plain render / rays of `--error` beyond which nobody searches.
const MOST_GAIN: f64 = 8.0;
/// Most samples per pixel of a plain render.
const MOST_PLAIN: u32 = 4096;

/// A trial of `--budget` with its plain counterpart, not yet judged.
struct Pair {
    samples: u32,
    image: Image,
    plain: Shown,
    plain_rays: u64,
}

/// A trial of `--time` with its plain counterpart, not yet judged.
struct Timed {
    asked: f64,
    image: Image,
    /// Image, samples and wall seconds.
    plain: Option<(Shown, u32, f64)>,
}

/// Measures `scene`; `None` if cancelled.
pub(super) fn measure(
    renderer: &mut Renderer,
    scene: &Scene,
    trials: &Trials,
    observer: &mut dyn Observer,
) -> Result<Option<SceneRecord>, RenderError> {
    let start = Instant::now();
    let settings = Settings { width: trials.width, height: trials.height, ..Settings::of(scene) };
    let mut steps = Steps::new(observer, trials);
    let mut bench = Bench { renderer, scene, settings: settings.clone(), confidence: trials.confidence };
    let Some(pairs) = pairs(&mut bench, trials, &mut steps)? else { return Ok(None) };
    let mut reached: Vec<(f64, Vec<Image>)> = Vec::new();
    for &target in &trials.errors {
        let mut images = Vec::new();
        for seed in seeds::trials(trials.seeds) {
            let Some(image) = bench.error(seed, target, &mut steps)? else { return Ok(None) };
            images.push(image);
            steps.step();
        }
        reached.push((target, images));
    }
    let Some(timed) = timed(&mut bench, trials, &mut steps)? else { return Ok(None) };

    let sought = TRUTH_SHARE * smallest(&pairs, trials);
    let mut tracer = Tracer::new(bench.renderer, scene, &settings, trials.truth_rays);
    let Some(paths) = tracer.complete(sought, &mut steps)? else { return Ok(None) };
    let Some(truth) = tracer.truth(paths, sought, &mut steps)? else { return Ok(None) };
    steps.step();
    let own = Paths { depth: settings.depth, cutoff: 0.0, hidden: 0.0 };
    let at_depth = match paths.depth > own.depth && !pairs.is_empty() {
        true => match tracer.truth(own, sought, &mut steps)? {
            Some(truth) => Some(truth),
            None => return Ok(None),
        },
        false => None,
    };
    steps.step();

    let same_depth = at_depth.as_ref().unwrap_or(&truth);
    let mut record = SceneRecord {
        truth: truth.record.clone(),
        truth_at_depth: at_depth.as_ref().map(|t| t.record.clone()),
        budget: pairs.iter().map(|pair| pair.judged(&truth, same_depth)).collect(),
        time: timed.iter().map(|timed| timed.judged(&truth)).collect(),
        ..SceneRecord::default()
    };
    let mut bench = Bench { renderer: tracer.renderer, scene, settings, confidence: trials.confidence };
    for (target, images) in &reached {
        let Some(plain) = plain(&mut bench, *target, images, &truth, trials, &mut steps)? else {
            return Ok(None);
        };
        let trials = images.iter().map(|image| error_record(image, &truth)).collect();
        record.error.push(ErrorRecord { target: *target, trials, plain });
        steps.step();
    }
    record.seconds = start.elapsed().as_secs_f64();
    Ok(Some(record))
}

/// Trials of `--budget`, each followed by a plain render of as many rays.
fn pairs(
    bench: &mut Bench<'_>,
    trials: &Trials,
    steps: &mut Steps<'_>,
) -> Result<Option<Vec<Pair>>, RenderError> {
    let mut pairs = Vec::new();
    for &samples in &trials.samples {
        for seed in seeds::trials(trials.seeds) {
            let Some(image) = bench.budget(seed, samples, steps)? else { return Ok(None) };
            let settings = Settings { seed, samples, ..bench.settings.clone() };
            let Some(mut plain) = bench.plain(&settings, steps)? else { return Ok(None) };
            // If measuring the error cost rays, the plain render gets as many.
            let ratio = image.report.rays.total() as f64 / plain.1.max(1) as f64;
            let equal = (f64::from(samples) * ratio).round() as u32;
            if equal != samples && equal > 0 {
                let settings = Settings { samples: equal, ..settings };
                let Some(again) = bench.plain(&settings, steps)? else { return Ok(None) };
                plain = again;
            }
            pairs.push(Pair { samples, image, plain: plain.0, plain_rays: plain.1 });
            steps.step();
        }
    }
    Ok(Some(pairs))
}

/// Trials of `--time`, each followed by the plain render that fits into the same time.
fn timed(
    bench: &mut Bench<'_>,
    trials: &Trials,
    steps: &mut Steps<'_>,
) -> Result<Option<Vec<Timed>>, RenderError> {
    let mut timed = Vec::new();
    for &asked in &trials.times {
        // Compiles the kernels.
        if bench.time(seeds::WARM, asked, steps)?.is_none() {
            return Ok(None);
        }
        for seed in seeds::trials(trials.seeds) {
            let Some(image) = bench.time(seed, asked, steps)? else { return Ok(None) };
            let Some(plain) = bench.plain_in_time(seed, asked, steps)? else { return Ok(None) };
            timed.push(Timed { asked, image, plain });
            steps.step();
        }
    }
    Ok(Some(timed))
}

/// Estimate of the smallest error that is to be judged. Images with different seeds differ by the root of 2 times their
/// sampling error.
fn smallest(pairs: &[Pair], trials: &Trials) -> f64 {
    let reached = trials.errors.iter().map(|e| REACHED_SHARE * e);
    let sampled = trials.samples.iter().filter_map(|samples| {
        let of: Vec<&Pair> = pairs.iter().filter(|p| p.samples == *samples).collect();
        let apart: Vec<f64> =
            of.windows(2).map(|p| p[0].image.shown.distance(&p[1].image.shown) / 2f64.sqrt()).collect();
        median(&apart).filter(|error| *error > 0.0)
    });
    let least = reached.chain(sampled).fold(f64::INFINITY, f64::min);
    if least.is_finite() { least } else { UNKNOWN_ERROR }
}

impl Pair {
    fn judged(&self, truth: &Truth, same_depth: &Truth) -> BudgetRecord {
        let Image { shown, report, half_widths, edges, .. } = &self.image;
        BudgetRecord {
            samples: self.samples,
            seed: self.image.seed,
            stated: self.image.stated,
            error: truth.reference.measure(shown),
            sampling_error: same_depth.reference.measure(shown),
            rays: report.rays.total(),
            seconds: report.time.render,
            plain_error: same_depth.reference.measure(&self.plain),
            plain_rays: self.plain_rays,
            layer: LayerTrial::of(half_widths, edges, shown, &same_depth.reference),
        }
    }
}

fn error_record(image: &Image, truth: &Truth) -> ErrorTrialRecord {
    ErrorTrialRecord {
        seed: image.seed,
        met: image.report.asked.met == Some(true),
        why: image.report.asked.unmet_why.clone(),
        stated: image.stated,
        error: truth.reference.measure(&image.shown),
        rays: image.report.rays.total(),
        seconds: image.report.time.render,
        depth: image.report.settings.depth,
    }
}

impl Timed {
    fn judged(&self, truth: &Truth) -> TimeRecord {
        TimeRecord {
            asked: self.asked,
            seed: self.image.seed,
            seconds: self.image.wall,
            stated: self.image.stated,
            error: truth.reference.measure(&self.image.shown),
            plain: self.plain.as_ref().map(|(shown, samples, seconds)| PlainInTime {
                samples: *samples,
                seconds: *seconds,
                error: truth.reference.measure(shown),
            }),
        }
    }
}

/// The plain render with the fewest samples (of 1, 2, 3, 4, 6, 8, 12, ...) that keeps `target` in nearly all seeds, with
/// the settings that `--error` chose; `Some(None)` if it is not found, `None` if cancelled.
fn plain(
    bench: &mut Bench<'_>,
    target: f64,
    images: &[Image],
    truth: &Truth,
    trials: &Trials,
    steps: &mut Steps<'_>,
) -> Result<Option<Option<PlainRecord>>, RenderError> {
    // Without success there is nothing to compare with.
    let Some(first) = images.iter().find(|image| image.report.asked.met == Some(true)) else {
        return Ok(Some(None));
    };
    let told = bench.told(&first.report);
    let mut samples = 1;
    while samples <= MOST_PLAIN {
        let (mut kept, mut rays, mut seconds, mut error) = (0, 0, Vec::new(), 0.0);
        for seed in seeds::trials(trials.seeds) {
            let settings = Settings { seed, samples, ..told.clone() };
            let Some((shown, each, took)) = bench.plain(&settings, steps)? else { return Ok(None) };
            error = truth.reference.measure(&shown).error();
            kept += u32::from(error <= target);
            rays = each;
            seconds.push(took);
            // One seed that is far off settles it.
            if f64::from(trials.seeds - seed + kept) < PLAIN_SHARE * f64::from(trials.seeds) {
                break;
            }
        }
        if f64::from(kept) >= PLAIN_SHARE * f64::from(trials.seeds) {
            let seconds = median(&seconds).unwrap_or(f64::NAN);
            return Ok(Some(Some(PlainRecord { samples, rays, seconds })));
        }
        if rays as f64 > MOST_GAIN * first.report.rays.total() as f64 {
            break;
        }
        // Where the error is far too large, counts are left out that cannot suffice.
        let enough = f64::from(samples) * (error / target).max(1.0).powf(1.0 / STEEPEST);
        samples = next(samples);
        while f64::from(next(samples)) <= enough {
            samples = next(samples);
        }
    }
    Ok(Some(None))
}

/// 1, 2, 3, 4, 6, 8, 12, 16, ...
fn next(samples: u32) -> u32 {
    match samples {
        1 => 2,
        n if n.is_power_of_two() => n / 2 * 3,
        n => n / 3 * 4,
    }
}

/// Progress in trials; truths count as one each, and so does a search for the plain render.
struct Steps<'a> {
    observer: &'a mut dyn Observer,
    done: u64,
    total: u64,
}

impl<'a> Steps<'a> {
    fn new(observer: &'a mut dyn Observer, trials: &Trials) -> Steps<'a> {
        let settings = trials.samples.len() + trials.errors.len() + trials.times.len();
        let total = u64::from(trials.seeds) * settings as u64 + trials.errors.len() as u64 + 2;
        Steps { observer, done: 0, total }
    }

    fn step(&mut self) {
        self.done += 1;
        self.observer.progress(self.done, self.total);
    }
}

impl Observer for Steps<'_> {
    fn progress(&mut self, _done: u64, _total: u64) {}

    fn cancelled(&self) -> bool {
        self.observer.cancelled()
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn sample_counts_grow_by_a_half_at_most() {
        let counts: Vec<u32> = std::iter::successors(Some(1), |n| Some(super::next(*n))).take(10).collect();
        assert_eq!(counts, [1, 2, 3, 4, 6, 8, 12, 16, 24, 32]);
    }
}

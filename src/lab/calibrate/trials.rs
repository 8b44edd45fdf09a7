//! Single trials of `--budget`, `--error` and `--time`, and the uniform render that `--error` is
//! compared with.

use super::coverage::Coverage;
use super::truth::Truth;
use crate::accuracy::pixel_sums::PixelSums;
use crate::accuracy::promise::{BoundedImage, Request, Target};
use crate::render::{Observer, RenderError, Renderer, Survey};
use crate::scene::Scene;
use crate::settings::{Precision, Settings};
use serde::Serialize;
use std::time::Instant;

/// Most samples per pixel of a uniform render.
const MOST_UNIFORM: u32 = 4096;

/// An image rendered with `--budget`: its bounds and true errors, RMSE.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BudgetTrial {
    /// Sampler seed.
    pub seed: u32,
    /// Total bound.
    pub total: f64,
    /// Sampling part of the bound.
    pub sampling: f64,
    /// Truncation part of the bound.
    pub truncation: f64,
    /// Rounding part of the bound; missing if the device has no f64.
    pub rounding: Option<f64>,
    /// True error against complete paths.
    pub error: f64,
    /// True error against paths of the same depth.
    pub sampling_error: f64,
}

impl BudgetTrial {
    /// Compares an image with both truths.
    pub fn of(known: &BoundedImage, seed: u32, truth: &Truth, same_depth: &Truth) -> BudgetTrial {
        let stated = known.report.error.clone().unwrap_or_default();
        BudgetTrial {
            seed,
            total: stated.total,
            sampling: stated.sampling,
            truncation: stated.truncation,
            rounding: stated.rounding,
            error: truth.error(&known.samples),
            sampling_error: same_depth.error(&known.samples),
        }
    }

    /// True if the error is within the total bound.
    pub fn kept(&self) -> bool {
        self.error <= self.total
    }

    /// True if the error at equal depth, rounding included, is within the sampling part alone.
    pub fn sampling_kept(&self) -> bool {
        self.sampling_error <= self.sampling
    }
}

/// An image rendered with `--error`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ErrorTrial {
    /// Sampler seed.
    pub seed: u32,
    /// True if it reports success.
    pub met: bool,
    /// Reason for a failure.
    pub why: Option<String>,
    /// The bound it reports, RMSE.
    pub total: f64,
    /// True error, RMSE.
    pub error: f64,
    /// Seconds from the first submit to the last pixel, the choice of depth and precision included.
    pub seconds: f64,
    /// Rays traced, without the comparison with f64.
    pub rays: u64,
    /// Mean samples per pixel.
    pub samples: f64,
    /// Depth chosen.
    pub depth: u32,
    /// Precision chosen.
    pub precision: String,
}

impl ErrorTrial {
    /// True if it reports success and the true error is within `target`.
    pub fn kept(&self, target: f64) -> bool {
        self.met && self.error <= target
    }
}

/// The cheapest render with the same number of samples in every pixel that reaches the error.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Uniform {
    /// Samples per pixel; `None` if even the most allowed are too few.
    pub samples: Option<u32>,
    /// Number of seeds tried.
    pub seeds: u32,
    /// Seconds of each run.
    pub seconds: Vec<f64>,
    /// Rays of one run.
    pub rays: u64,
    /// Seconds of the `--error` runs measured in turn.
    pub adaptive_seconds: Vec<f64>,
}

/// An image rendered with `--time`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TimeTrial {
    /// Sampler seed.
    pub seed: u32,
    /// Wall seconds.
    pub seconds: f64,
    /// True if it reports that it was in time and sampled every pixel.
    pub met: bool,
    /// The bound it reports, RMSE.
    pub total: f64,
    /// True error, RMSE.
    pub error: f64,
}

/// Renders trials.
pub(super) struct Bench<'a> {
    pub(super) renderer: &'a mut Renderer,
    pub(super) scene: &'a Scene,
    pub(super) settings: Settings,
    pub(super) confidence: f64,
}

impl Bench<'_> {
    fn render(
        &mut self,
        seed: u32,
        samples: u32,
        target: Target,
        observer: &mut dyn Observer,
    ) -> Result<Option<BoundedImage>, RenderError> {
        let settings = Settings { seed, samples, ..self.settings.clone() };
        let fixed = target == Target::Settings;
        let request = Request {
            confidence: self.confidence,
            keep_depth: fixed,
            keep_precision: fixed,
            ..Request::to(target)
        };
        let known = self.renderer.render_bounded_with(self.scene, &settings, &request, observer)?;
        Ok((!known.cancelled && known.done == 1.0).then_some(known))
    }

    /// Renders with `--budget`; `None` if cancelled.
    pub(super) fn budget(
        &mut self,
        seed: u32,
        samples: u32,
        observer: &mut dyn Observer,
    ) -> Result<Option<BoundedImage>, RenderError> {
        self.render(seed, samples, Target::Settings, observer)
    }

    /// Edge pixels whose confidence interval (of the widest channel) contains the truth.
    pub(super) fn pixels(
        &mut self,
        seed: u32,
        samples: u32,
        truth: &Truth,
        observer: &mut dyn Observer,
    ) -> Result<Option<Coverage>, RenderError> {
        let settings = Settings { seed, ..self.settings.clone() };
        let mut survey = Survey::new(self.renderer, self.scene, &settings)?;
        let image = whole(&mut survey, 0..samples, observer)?;
        let Some(image) = image else { return Ok(None) };
        let half_widths = image.half_widths(self.confidence);
        let held = |at: usize| {
            let (mean, truth) = (image.mean(at), truth.pixels[at]);
            let error = |c: usize| (mean[c].clamp(0.0, 1.0) - truth[c].clamp(0.0, 1.0)).abs();
            (0..3).all(|c| error(c) <= half_widths[at])
        };
        let edge = |at: &usize| image.marks[*at].hash_least != image.marks[*at].hash_most;
        Ok(Some(Coverage::of((0..image.samples.len()).filter(edge).map(held))))
    }

    /// Renders with `--error`; `None` if cancelled.
    pub(super) fn error(
        &mut self,
        seed: u32,
        target: f64,
        truth: &Truth,
        observer: &mut dyn Observer,
    ) -> Result<Option<(ErrorTrial, Settings)>, RenderError> {
        let Some(known) = self.render(seed, 1, Target::Error(target), observer)? else { return Ok(None) };
        let report = &known.report;
        let traced: u64 = known.samples.samples.iter().map(|n| u64::from(*n)).sum();
        let trial = ErrorTrial {
            seed,
            met: report.asked.met == Some(true),
            why: report.asked.unmet_why.clone(),
            total: report.error.as_ref().map_or(f64::NAN, |e| e.total),
            error: truth.error(&known.samples),
            seconds: report.time.render,
            rays: report.rays.total(),
            samples: traced as f64 / known.samples.samples.len().max(1) as f64,
            depth: report.settings.depth,
            precision: report.settings.precision.clone(),
        };
        let double = trial.precision == Precision::Double.name();
        let used = Settings {
            depth: trial.depth,
            cutoff: report.settings.cutoff,
            precision: if double { Precision::Double } else { self.settings.precision },
            replicates: 1,
            ..self.settings.clone()
        };
        Ok(Some((trial, used)))
    }

    /// Renders with `--time`, counted from this call; `None` if cancelled.
    pub(super) fn time(
        &mut self,
        seed: u32,
        seconds: f64,
        truth: &Truth,
        observer: &mut dyn Observer,
    ) -> Result<Option<TimeTrial>, RenderError> {
        let from = Instant::now();
        let known = self.render(seed, 1, Target::Time { seconds, from, layers: 0 }, observer)?;
        let took = from.elapsed().as_secs_f64();
        let Some(known) = known else { return Ok(None) };
        Ok(Some(TimeTrial {
            seed,
            seconds: took,
            met: known.report.asked.met == Some(true),
            total: known.report.error.as_ref().map_or(f64::NAN, |e| e.total),
            error: truth.error(&known.samples),
        }))
    }

    /// RMSE of uniform renders with rising sample counts, until two in a row are within `target`.
    pub(super) fn decline(
        &mut self,
        settings: &Settings,
        target: f64,
        truth: &Truth,
        observer: &mut dyn Observer,
    ) -> Result<Option<Vec<f64>>, RenderError> {
        let mut survey = Survey::new(self.renderer, self.scene, settings)?;
        let mut image = PixelSums::new(settings.width, settings.height, 1);
        let places: Vec<u32> = (0..settings.width * settings.height).collect();
        let (mut errors, mut done, mut below) = (Vec::new(), 0, 0);
        for count in counts() {
            let traced = survey.trace(&places, done..count, observer)?;
            if traced.marks.len() < places.len() || observer.cancelled() {
                return Ok(None);
            }
            image.add_means(&places, count - done, &traced);
            done = count;
            errors.push(truth.error(&image));
            below = if errors[errors.len() - 1] <= target { below + 1 } else { 0 };
            if below == 2 {
                break;
            }
        }
        Ok(Some(errors))
    }

    /// Seconds and rays of a uniform render; `None` if cancelled.
    pub(super) fn plain(
        &mut self,
        settings: &Settings,
        samples: u32,
        observer: &mut dyn Observer,
    ) -> Result<Option<(f64, u64)>, RenderError> {
        let mut survey = Survey::new(self.renderer, self.scene, settings)?;
        let start = Instant::now();
        let image = whole(&mut survey, 0..samples, observer)?;
        let seconds = start.elapsed().as_secs_f64();
        Ok(image.map(|_| (seconds, survey.report().rays.total())))
    }
}

/// Sample counts of uniform renders: 1, 2, 3, 4, 6, 8, 12, ...
pub(super) fn counts() -> Vec<u32> {
    let mut all = vec![1, 2, 3];
    while all[all.len() - 1] < MOST_UNIFORM {
        // 4, 6, 8, 12, 16 ...: steps of at most a half.
        let last = all[all.len() - 2];
        all.push(2 * last);
    }
    all.retain(|n| *n <= MOST_UNIFORM);
    all
}

fn whole(
    survey: &mut Survey,
    samples: std::ops::Range<u32>,
    observer: &mut dyn Observer,
) -> Result<Option<PixelSums>, RenderError> {
    let Settings { width, height, replicates, .. } = *survey.settings();
    let places: Vec<u32> = (0..width * height).collect();
    let mut image = PixelSums::new(width, height, replicates as usize);
    let traced = survey.trace(&places, samples.clone(), observer)?;
    if traced.marks.len() < places.len() || observer.cancelled() {
        return Ok(None);
    }
    image.add(&places, samples.end - samples.start, &traced);
    Ok(Some(image))
}

#[cfg(test)]
mod tests {
    #[test]
    fn counts_grow_by_a_half_at_most() {
        let counts = super::counts();
        assert_eq!(counts[..8], [1, 2, 3, 4, 6, 8, 12, 16]);
        assert_eq!(counts[counts.len() - 1], super::MOST_UNIFORM);
    }
}

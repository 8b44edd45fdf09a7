//! The rounding part of an error that is asked for: the same samples of some pixels in f64.

use super::traced::{Region, Tracing};
use super::{LOOK_SAMPLES, Task};
use crate::accuracy::budget;
use crate::accuracy::pixel_sums::PixelSums;
use crate::accuracy::sampling::Noise;
use crate::render::{RenderError, Survey};
use crate::settings::{Precision, Settings};
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// One pixel in this many is compared, within limits.
const PIXEL_SHARE: u32 = 16;
const LEAST_PIXELS: u32 = 256;
const MOST_PIXELS: u32 = 4096;
/// What the difference of pixels that went the same way is multiplied by: few pixels have most of it.
const CAUTION: f64 = 1.5;

/// What single precision does, as seen in some samples. It is stated as measured: where no sample went another way
/// that part is 0, and the sampling part stands for itself.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct RoundingEstimate {
    /// RMSE of pixels whose samples all went the same way, `CAUTION` times: it does not average out.
    same_way: f64,
    /// Share of samples that go another way, and one standard error: that of a pixel of n samples changes it by
    /// 1/n of the difference there at most.
    other_way: f64,
    /// Mean square of that difference, as it is at edges.
    contrast: f64,
    /// Pixels with a sample that went another way.
    pub(super) pixels: u64,
}

impl RoundingEstimate {
    /// Of the same samples, as many in each pixel, in single precision and in f64.
    fn of(a: &PixelSums, b: &PixelSums) -> RoundingEstimate {
        let all = budget::rounding(a, b);
        let pixels = a.samples.len();
        let mut same = 0.0;
        for at in (0..pixels).filter(|at| budget::same_way(&a.marks[*at], &b.marks[*at])) {
            same += all.pixels[at].powi(2);
        }
        let samples = a.samples.iter().map(|n| f64::from(*n)).sum::<f64>().max(1.0);
        RoundingEstimate {
            contrast: contrast(b),
            same_way: CAUTION * (same / pixels.max(1) as f64).sqrt(),
            other_way: (all.ways as f64 + (all.ways as f64).sqrt()) / samples,
            pixels: all.ways,
        }
    }

    /// The rounding part of an image, as an RMSE.
    pub(super) fn part(&self, image: &PixelSums) -> f64 {
        let sampled = image.samples.iter().filter(|n| **n > 0);
        let inverse: f64 = sampled.map(|n| 1.0 / f64::from(*n)).sum();
        let inverse = inverse / image.samples.len().max(1) as f64;
        // Ways of other samples are other ways on their own: variances add; their mean is a bias.
        (self.same_way.powi(2) + self.contrast * (self.other_way * inverse + self.other_way.powi(2))).sqrt()
    }

    /// The same of an image of `samples` samples a pixel.
    pub(super) fn part_at(&self, samples: f64) -> f64 {
        (self.same_way.powi(2) + self.contrast * (self.other_way / samples + self.other_way.powi(2))).sqrt()
    }
}

impl Task<'_> {
    /// Compares `survey` with f64 on [`LOOK_SAMPLES`] samples of some pixels; `None` where the device has no f64, or
    /// it could not be done `by` then.
    pub(super) fn rounded(
        &mut self,
        survey: &mut Survey,
        by: Option<Instant>,
    ) -> Result<Option<RoundingEstimate>, RenderError> {
        if survey.precision() == Precision::Double {
            return Ok(Some(RoundingEstimate::default()));
        }
        if !self.renderer.device().has_double() {
            return Ok(None);
        }
        let (mut exact, places) = self.comparison(survey)?;
        let region = Region::of(&self.settings);
        let mut see = |survey: &mut Survey| -> Result<PixelSums, RenderError> {
            survey.finish_by(by);
            let seen = Tracing { survey, region, observer: &mut self.observer }.see(&places, LOOK_SAMPLES)?;
            survey.finish_by(None);
            Ok(seen)
        };
        let (a, b) = (see(survey)?, see(&mut exact)?);
        survey.count(&exact);
        let all = a.samples.len().min(b.samples.len()) == places.len();
        Ok(all.then(|| RoundingEstimate::of(&a, &b)))
    }

    /// Compares `image`, all of whose pixels have as many samples from `survey`, with the same in f64 in some pixels; `None`
    /// where the device has no f64, or it was cancelled.
    pub(super) fn rounded_image(
        &mut self,
        survey: &mut Survey,
        image: &PixelSums,
    ) -> Result<Option<RoundingEstimate>, RenderError> {
        if !self.renderer.device().has_double() {
            return Ok(None);
        }
        let (mut exact, places) = self.comparison(survey)?;
        let samples = image.samples.first().copied().unwrap_or(1);
        let a = image.of_some(&places, places.len() as u32);
        let region = Region::of(&self.settings);
        let mut tracing = Tracing { survey: &mut exact, region, observer: &mut self.observer };
        let b = tracing.all_of(&places, samples)?;
        survey.count(&exact);
        Ok(b.map(|b| {
            let seen = RoundingEstimate::of(&a, &b);
            // Pixels of one sample show no edges, but their neighbours do.
            if samples == 1 { RoundingEstimate { contrast: contrast_of_pairs(image), ..seen } } else { seen }
        }))
    }

    /// `survey` in f64, and the pixels to be compared.
    fn comparison(&mut self, survey: &Survey) -> Result<(Survey, Vec<u32>), RenderError> {
        let settings = Settings { precision: Precision::Double, ..survey.settings().clone() };
        let mut exact = self.survey(&settings)?;
        exact.cut_at(survey.settings().depth, survey.settings().cutoff);
        let region = Region::of(&self.settings);
        let places = region.spread((region.pixels() / PIXEL_SHARE).clamp(LEAST_PIXELS, MOST_PIXELS));
        Ok((exact, places))
    }
}

/// Mean squared difference between the two sides of an edge: a sample goes another way where it lies within
/// rounding of one. A pixel that an edge of difference c cuts anywhere has samples of variance c^2 a (1 - a),
/// a the share of one side; over all a that is c^2 / 6. No more than 1, the whole range, and 1 where no
/// pixel shows an edge.
fn contrast(seen: &PixelSums) -> f64 {
    let mixed = |at: &usize| seen.marks[*at].hash_least != seen.marks[*at].hash_most;
    let (mut count, mut sum) = (0u32, 0.0);
    for at in (0..seen.samples.len()).filter(mixed) {
        // The variance of one sample.
        sum += seen.noise_of(at).squares * f64::from(seen.samples[at]);
        count += 1;
    }
    if count == 0 { 1.0 } else { (6.0 * sum / f64::from(count)).min(1.0) }
}

/// The same from pixels of one sample: mean squared difference of pairs that took different paths.
fn contrast_of_pairs(image: &PixelSums) -> f64 {
    let (mut count, mut sum) = (0u32, 0.0);
    for at in 0..image.samples.len() {
        let other = image.pair_of(at).filter(|q| !budget::same_way(&image.marks[at], &image.marks[*q]));
        if let Some(other) = other {
            let (a, b) = (image.mean(at), image.mean(other));
            sum += Noise::of_one(a, b, 1.0).squares;
            count += 1;
        }
    }
    if count == 0 { 1.0 } else { sum / f64::from(count) }
}

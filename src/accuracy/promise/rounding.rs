//! The rounding part of an error that is asked for: the same samples of some pixels in f64.

use super::traced::{Region, Tracing};
use super::{LOOK_SAMPLES, Task};
use crate::accuracy::budget;
use crate::accuracy::pixel_sums::PixelSums;
use crate::render::{RenderError, Survey};
use crate::settings::{Precision, Settings};
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// Error of single precision, estimated from the samples of some pixels.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct RoundingEstimate {
    /// RMSE of pixels whose samples all went the same way: it does not average out.
    same_way: f64,
    /// Upper bound on the share of samples that go another way: that of a pixel of n samples changes it
    /// by 1/n of the difference there at most.
    other_way: f64,
    /// Mean square of that difference, as it is at edges.
    contrast: f64,
    /// Pixels with a sample that went another way.
    pub(super) pixels: u64,
}

impl RoundingEstimate {
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

/// Greatest mean of a Poisson distribution of which `count` or fewer come with probability `risk`: the
/// upper confidence limit of Garwood, Biometrika 28, 1936.
pub(super) fn poisson_limit(count: u64, risk: f64) -> f64 {
    let at_most = |mean: f64| {
        let mut term = (-mean).exp();
        (0..=count).fold(0.0, |sum, k| {
            let sum = sum + term;
            term *= mean / (k + 1) as f64;
            sum
        })
    };
    if count > 500 {
        // Normal beyond: the exponential would underflow.
        let n = count as f64;
        return n + crate::accuracy::quantile::normal(1.0 - risk) * n.sqrt() + 3.0;
    }
    let (mut low, mut high) = (0.0, count as f64 + 10.0 * (count as f64 + 1.0).sqrt() - 3.0 * risk.ln());
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if at_most(middle) > risk { low = middle } else { high = middle }
    }
    high
}

impl Task<'_> {
    /// Compares `survey` with f64 on about `samples` samples; `None` where the device has no f64, or it could
    /// not be done `by` then. `exact` keeps the scene in f64 from one comparison to the next.
    pub(super) fn rounded(
        &mut self,
        survey: &mut Survey,
        exact: &mut Option<Survey>,
        samples: u64,
        risk: f64,
        by: Option<Instant>,
    ) -> Result<Option<RoundingEstimate>, RenderError> {
        if survey.precision() == Precision::Double {
            return Ok(Some(RoundingEstimate::default()));
        }
        if !self.renderer.device().has_double() {
            return Ok(None);
        }
        let settings = Settings { precision: Precision::Double, ..survey.settings().clone() };
        let exact = match exact {
            Some(exact) => exact,
            None => exact.insert(Survey::new(self.renderer, self.scene, &settings)?),
        };
        let region = Region::of(&self.settings);
        let places = region.spread((samples / u64::from(LOOK_SAMPLES)).clamp(1024, 1 << 30) as u32);
        let mut see = |survey: &mut Survey| -> Result<PixelSums, RenderError> {
            survey.finish_by(by);
            let seen = Tracing { survey, region, observer: &mut self.observer }.see(&places)?;
            survey.finish_by(None);
            Ok(seen)
        };
        let (a, b) = (see(survey)?, see(exact)?);
        let seen = a.samples.len().min(b.samples.len());
        if seen < places.len() {
            return Ok(None);
        }
        let all = budget::rounding(&a, &b);
        let mut same = 0.0;
        for at in (0..seen).filter(|at| budget::same_way(&a.marks[*at], &b.marks[*at])) {
            same += all.pixels[at].powi(2);
        }
        Ok(Some(RoundingEstimate {
            contrast: contrast(&b),
            same_way: (same / seen.max(1) as f64).sqrt(),
            other_way: poisson_limit(all.ways, risk) / (seen.max(1) as f64 * f64::from(LOOK_SAMPLES)),
            pixels: all.ways,
        }))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_poisson_limit_is_garwoods() {
        // Garwood's table for 95 % one-sided: 0 -> 3.00, 1 -> 4.74, 5 -> 10.51, 30 -> 40.69.
        for (count, limit) in [(0, 2.996), (1, 4.744), (5, 10.513), (30, 40.691)] {
            let found = poisson_limit(count, 0.05);
            assert!((found - limit).abs() < 2e-3, "{count}: {found}");
        }
        // The normal tail joins on from above.
        let (below, above) = (poisson_limit(500, 0.05), poisson_limit(501, 0.05));
        assert!(above > below && above - below < 5.0);
    }
}

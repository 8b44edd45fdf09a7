//! How far an image is from the truth because rays were cut: at the last depth, or below a weight.
//!
//! A ray that was cut with throughput T hides a value in [0, T L], L from [`RadianceLimit`]. Summed over
//! a pixel's samples that is a certificate for these very samples, not an estimate. What is hidden only adds
//! light, and an image as shown ends at 1: a pixel of value v lacks no more than 1 - v. So the bound on
//! what is shown is finite even where radiance has no limit.

use super::pieces;
use super::radiance_bound::RadianceLimit;
use serde::{Deserialize, Serialize};

/// The part of an image's error that is due to rays that were cut.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TruncationBound {
    /// The RMSE of the image as shown, over all channels, is at most this.
    pub rms: f64,
    /// No channel of any pixel, as shown, lacks more.
    pub most: f64,
    /// Pixels of which rays were cut.
    pub pixels: u64,
    /// Why radiance has no limit, if it has none and rays were cut: then only white bounds what is hidden.
    pub unbounded: Option<String>,
}

/// What one pixel lacks at most, in each channel of the image as shown. `mean` is its linear RGB, unclamped, and
/// `cut` the mean over its samples of the throughput that was cut.
pub fn hidden(mean: [f64; 3], cut: f64, limit: &RadianceLimit) -> [f64; 3] {
    if cut <= 0.0 {
        return [0.0; 3];
    }
    std::array::from_fn(|c| {
        let room = (1.0 - mean[c].max(0.0)).max(0.0);
        // Zero times infinity cannot be: cut is greater than zero.
        (cut * limit.rgb[c]).min(room)
    })
}

/// The image's bound from each pixel's mean and cut, as for [`hidden`].
pub fn truncation(pixels: &[([f64; 3], f64)], limit: &RadianceLimit) -> TruncationBound {
    truncation_of(pixels.len(), |at| pixels[at], limit)
}

/// The same of `count` pixels by a function.
pub fn truncation_of(
    count: usize,
    of: impl Fn(usize) -> ([f64; 3], f64) + Sync + Send,
    limit: &RadianceLimit,
) -> TruncationBound {
    let add = |(squares, most, pixels): &mut (f64, f64, u64), at: usize| {
        let (mean, cut) = of(at);
        *pixels += u64::from(cut > 0.0);
        for missing in hidden(mean, cut, limit) {
            *squares += missing * missing;
            *most = most.max(missing);
        }
    };
    let join = |a: (f64, f64, u64), b: (f64, f64, u64)| (a.0 + b.0, f64::max(a.1, b.1), a.2 + b.2);
    let (squares, most, cut_pixels) = pieces::fold(count, add, join);
    TruncationBound {
        rms: (squares / (3 * count.max(1)) as f64).sqrt(),
        most,
        pixels: cut_pixels,
        unbounded: limit.unbounded.clone().filter(|_| cut_pixels > 0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two facing mirrors of weight rho and own colour L: n rays see L (1 - rho^n), the last is cut with
    /// rho^n, and the truth is L. The bound is the error itself.
    #[test]
    fn facing_mirrors_lack_what_the_bound_says() {
        let own = 0.6;
        let limit = RadianceLimit { rgb: [own; 3], unbounded: None };
        for rho in [0.5f64, 0.9, 0.99] {
            let mut before = f64::INFINITY;
            for depth in 1..40 {
                let cut = rho.powi(depth);
                let seen = own * (1.0 - cut);
                let bound = truncation(&[([seen; 3], cut)], &limit);
                let error = own - seen;
                // 1e-15: what the subtraction loses of a value below 1.
                assert!(error <= bound.rms + 1e-15 && bound.rms <= 1.01 * error + 1e-15);
                assert!(bound.rms < before, "deeper hides less");
                // One ray more changes the pixel by no more than the bound said.
                assert!(own * (1.0 - cut * rho) - seen <= bound.most + 1e-15);
                before = bound.rms;
            }
        }
    }

    #[test]
    fn without_a_limit_white_is_the_limit() {
        let limit = RadianceLimit { rgb: [f64::INFINITY; 3], unbounded: Some("a light touches".to_owned()) };
        let bound = truncation(&[([0.25, 0.5, 3.0], 1e-3), ([0.0; 3], 0.0)], &limit);
        assert_eq!((bound.most, bound.pixels), (0.75, 1));
        assert!((bound.rms - ((0.5625 + 0.25) / 6.0f64).sqrt()).abs() < 1e-15);
        assert!(bound.unbounded.is_some());
        // Nothing was cut: nothing is hidden, and the light does not matter.
        assert_eq!(
            truncation(&[([0.0; 3], 0.0)], &limit),
            TruncationBound { rms: 0.0, most: 0.0, pixels: 0, unbounded: None }
        );
    }

    /// The planted defect: a bound that forgets what is shown ends at 1, or that black is not below 0.
    #[test]
    fn bright_pixels_lack_nothing() {
        let limit = RadianceLimit { rgb: [10.0; 3], unbounded: None };
        assert_eq!(hidden([1.5, 0.9, -0.1], 0.5, &limit), [0.0, 1.0 - 0.9, 1.0]);
        assert_eq!(hidden([0.2; 3], 0.01, &limit), [0.1; 3]);
    }
}

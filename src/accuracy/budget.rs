//! The error of one image in its four parts: sampling, truncation, rounding, encoding. Each is an upper bound on the RMSE
//! that it makes, so by the triangle inequality their sum is one on the whole.

use super::pixel_sums::PixelSums;
use super::radiance_bound::RadianceLimit;
use super::unseen::Caps;
use crate::render::samples::Mark;
use crate::report::ErrorInfo;

/// What single precision changed.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Rounding {
    /// RMSE between the two, as shown.
    pub rmse: f64,
    /// Of each pixel, of its worst channel.
    pub pixels: Vec<f64>,
    /// Pixels of which some sample took another way.
    pub ways: u64,
}

impl Rounding {
    /// Of an image in f64.
    pub fn none(pixels: usize) -> Rounding {
        Rounding { pixels: vec![0.0; pixels], ..Rounding::default() }
    }
}

/// True if all samples of both took the same ways, as far as their extreme hashes tell.
pub fn same_way(a: &Mark, b: &Mark) -> bool {
    (a.hash_least, a.hash_most) == (b.hash_least, b.hash_most)
}

/// Compares the same samples in two precisions.
pub fn rounding(a: &PixelSums, b: &PixelSums) -> Rounding {
    let mut squares = 0.0;
    let mut worst = |at| {
        let (a, b) = (a.mean(at), b.mean(at));
        let apart: [f64; 3] = std::array::from_fn(|c| (a[c].clamp(0.0, 1.0) - b[c].clamp(0.0, 1.0)).abs());
        squares += apart.iter().map(|d| d * d).sum::<f64>();
        apart.into_iter().fold(0.0, f64::max)
    };
    let both = a.samples.len().min(b.samples.len());
    let pixels: Vec<f64> = (0..both).map(&mut worst).collect();
    let other_way = |(a, b): &(&Mark, &Mark)| !same_way(a, b);
    let ways = a.marks.iter().zip(&b.marks).filter(other_way).count() as u64;
    Rounding { rmse: root_mean(squares, pixels.len()), pixels, ways }
}

fn root_mean(squares: f64, pixels: usize) -> f64 {
    (squares / (3.0 * pixels.max(1) as f64)).sqrt()
}

/// The parts and their sum. `rounding`: its part, and pixels of which some sample took another way; `encoding`: the
/// part of the file.
pub fn budget(
    image: &PixelSums,
    limit: &RadianceLimit,
    caps: &Caps,
    rounding: Option<(f64, u64)>,
    encoding: Option<f64>,
    confidence: f64,
) -> ErrorInfo {
    let unseen = image.unseen(caps).squares(confidence);
    let not_excluded = image.not_excluded(caps).squares(confidence);
    let sampling = image.noise().bound(image.replicates, confidence, unseen);
    let truncation = image.truncation(limit);
    ErrorInfo {
        kind: "rmse".into(),
        confidence,
        sampling: sampling.bound,
        sampling_estimate: sampling.estimate,
        truncation: truncation.rms,
        truncation_bounded: truncation.unbounded.is_none(),
        total: sampling.bound
            + truncation.rms
            + rounding.map_or(0.0, |(part, _)| part)
            + encoding.unwrap_or(0.0),
        unseen: sampling.unseen,
        not_excluded: (not_excluded > unseen)
            .then(|| (not_excluded / image.samples.len().max(1) as f64).sqrt()),
        encoding,
        void: None,
        truncation_unbounded_why: truncation.unbounded,
        cut: image.mean_cut(),
        rounding: rounding.map(|(part, _)| part),
        rounding_pixels: rounding.map(|(_, pixels)| pixels),
    }
}

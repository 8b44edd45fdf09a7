//! Is the difference of two noisy pictures more than their noise?
//!
//! The test is that of the renderers' regression suites (Mitsuba 3, `src/render/tests/test_renders.py`: a Z-test per
//! pixel against a reference with known variance, with Sidak's correction over all pixels; Subr and Arvo, "Statistical
//! Hypothesis Testing for Assessing Monte Carlo Estimators", Pacific Graphics 2007). Two files hold no variances, so here
//! a *block* of n pixels is tested, and the noise is taken from its differences d = a - b themselves:
//!
//! ```text
//! z = mean / standard error = (sum d / n) / (sqrt(sum d^2) / n) = sum d / sqrt(sum d^2)
//! ```
//!
//! per channel, in linear light clamped to [0, 1]. The sum of squares is not centred: if the pictures agree, the mean of
//! every d is 0.
//!
//! **Level.** Let the pictures be exchangeable under the hypothesis that they agree: same scene and settings, independent
//! seeds, noise that is independent from pixel to pixel. Then each d is as likely as -d, however unequal the noise of the
//! pixels is, and given all |d|, z is a sum of independent signs with weights of square sum 1 (Efron, "Student's t-test
//! under symmetry conditions", JASA 64, 1969). For such sums
//!
//! ```text
//! P(z >= x) <= c P(N(0, 1) >= x),   c = 1 / (4 P(N(0, 1) >= sqrt 2)) < 3.18
//! ```
//!
//! for every x and n (Bentkus and Dzindzalieta, "A tight Gaussian bound for weighted sums of Rademacher random variables",
//! Bernoulli 21(2), 2015). `p = min(1, 2 c P(N >= |z|))` is thus a bound, not an approximation that asks for large n. With
//! the correction of Sidak ("Rectangular confidence regions for the means of multivariate normal distributions", JASA 62,
//! 1967) over m tests, a difference is reported where `p < 1 - (1 - alpha)^(1/m)`. Channels and nested blocks are
//! correlated; for two-sided normal tests the correction holds all the same (Sidak 1967), and Bonferroni's alpha / m, which
//! needs no assumption at all, is only 0.5 % stricter at alpha = 0.01.
//!
//! Where the pictures are not exchangeable, for instance 4 samples against 256, skewed noise makes the level approximate:
//! the error of P(z >= x) is of the order of skewness / sqrt n. With channels that are 1 in one sample of 20, else 0, at
//! alpha = 0.01 and 64 x 48 pixels, 4 samples against 256 gave 11 % false alarms (of 200 pairs), 16 against 256 gave 0.5 %,
//! and 4 against 4 none. Jung, Hanika and Dachsbacher ("Detecting Bias in Monte Carlo Renderers using Welch's t-test", JCGT
//! 9(2), 2020) treat unequal pictures, but need the variance of the samples.
//!
//! **Blocks.** A block in which k pixels differ has |z| <= sqrt k. For alpha = 0.01 the threshold lies between 3.3 (one
//! block) and 6.3 (10^7 tests), so at least 11 to 40 pixels must differ: of the powers of two, 8 x 8 pixels are the
//! smallest blocks that can always show a difference. In a picture of 600 x 500 pixels (threshold 5.2) such a block shows
//! a bias of sigma x / sqrt(64 - x^2) = 0.85 standard deviations of a pixel's difference in every second try. A smaller
//! bias of a larger area, and noise of few pixels such as edges, need more pixels: blocks of 32 x 32 and the whole picture
//! are tested too. Blocks at the far edges are not smaller: a side is divided evenly into parts of at least 8 (32) pixels.
//!
//! **No noise.** If too few pixels differ in the whole picture for any test, there is no noise to judge by, and the
//! pictures are compared exactly.

use super::metrics::{Rgb, SizeMismatch};
use serde::Serialize;
use std::f64::consts::{PI, SQRT_2};

/// Sides of the blocks, pixels; the whole picture follows.
const SIDES: [usize; 2] = [8, 32];
/// Names of the channels.
const CHANNELS: [&str; 3] = ["red", "green", "blue"];

/// The result of a test.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Statistics {
    /// Probability of a false alarm over all tests, at most.
    pub significance: f64,
    /// Number of tests: blocks of all sizes, times three channels.
    pub tests: u64,
    /// Probability of a false alarm per test, at most: Sidak's correction of `significance`.
    pub significance_per_test: f64,
    /// A test with a larger |z| is significant.
    pub threshold: f64,
    /// Blocks of all sizes, the whole picture included.
    pub blocks: u64,
    /// Of these, blocks with a significant channel.
    pub significant_blocks: u64,
    /// Pixels with a difference in any channel.
    pub differing_pixels: u64,
    /// True if too few pixels differ for any test, so that the pictures were compared exactly.
    pub exact: bool,
    /// True if the pictures differ by more than noise, or at all if `exact`.
    pub significant: bool,
    /// The test with the largest |z|; None if the pictures are equal.
    pub worst: Option<Block>,
}

/// One channel of one block.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Block {
    /// `[x0, y0, x1, y1]`, pixels; the ends are outside.
    pub region: [u32; 4],
    /// `red`, `green` or `blue`.
    pub channel: &'static str,
    /// Mean difference a - b, linear light.
    pub mean: f64,
    /// Standard error of the mean if the pictures agree.
    pub standard_error: f64,
    /// `mean / standard_error`.
    pub z: f64,
    /// Bound on the probability of a |z| at least as large if the pictures agree.
    pub p: f64,
}

/// Why two pictures cannot be tested.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum CannotTest {
    /// They cannot be laid over each other.
    #[error(transparent)]
    Size(#[from] SizeMismatch),
    /// Even a difference of all pixels would be taken for noise.
    #[error(
        "a picture of {pixels} pixels is too small for a statistical test at a significance of {significance}: \
         at least {needed} pixels are needed; use --threshold instead"
    )]
    TooSmall {
        /// Of the picture.
        pixels: usize,
        /// As asked for.
        significance: f64,
        /// Pixels of the smallest picture that can be tested.
        needed: usize,
    },
}

/// A test of all blocks, with |z| of each pixel's block.
pub struct Tested {
    /// The result.
    pub statistics: Statistics,
    /// Largest |z| of the three channels of the 8 x 8 block that the pixel is in; rows from the top.
    pub map: Vec<f64>,
}

/// Tests whether two pictures, rows of `width` pixels, differ by more than noise, with a probability of a false alarm of
/// at most `significance`, in (0, 1).
///
/// # Errors
/// If the pictures differ in length, are not whole rows of `width` pixels, or are too small.
pub fn test<A: Rgb, B: Rgb>(a: &[A], b: &[B], width: usize, significance: f64) -> Result<Tested, CannotTest> {
    if a.len() != b.len() || width == 0 || !a.len().is_multiple_of(width) {
        return Err(SizeMismatch(a.len(), b.len()).into());
    }
    let height = a.len() / width;
    let differences: Vec<[f64; 3]> = a.iter().zip(b).map(|(a, b)| difference(a.rgb(), b.rgb())).collect();
    let blocks = blocks(width, height);
    let tests = (3 * blocks.len()) as u64;
    let per_test = corrected(significance, tests);
    let threshold = threshold(per_test);
    let needed = (threshold * threshold).floor() as usize + 1;
    if a.len() < needed {
        return Err(CannotTest::TooSmall { pixels: a.len(), significance, needed });
    }
    let mut map = vec![0.0; a.len()];
    let mut worst: Option<Block> = None;
    let mut significant_blocks = 0;
    let mut finest = count(width, SIDES[0]) * count(height, SIDES[0]);
    for region in blocks {
        let channels = sums(&differences, width, region);
        let [x0, y0, x1, y1] = region;
        let n = ((x1 - x0) * (y1 - y0)) as f64;
        let mut largest = 0.0f64;
        for (channel, [sum, squares]) in CHANNELS.into_iter().zip(channels) {
            if squares == 0.0 {
                continue;
            }
            let z = sum / squares.sqrt();
            largest = largest.max(z.abs());
            if worst.as_ref().is_none_or(|w| z.abs() > w.z.abs()) {
                let region = region.map(|edge| edge as u32);
                let (mean, standard_error) = (sum / n, squares.sqrt() / n);
                worst = Some(Block { region, channel, mean, standard_error, z, p: bound(z.abs()) });
            }
        }
        significant_blocks += u64::from(largest > threshold);
        if finest > 0 {
            finest -= 1;
            (y0..y1).for_each(|y| map[y * width + x0..y * width + x1].fill(largest));
        }
    }
    let differing = differences.iter().filter(|d| **d != [0.0; 3]).count();
    let exact = differing < needed;
    let statistics = Statistics {
        significance,
        tests,
        significance_per_test: per_test,
        threshold,
        blocks: tests / 3,
        significant_blocks,
        differing_pixels: differing as u64,
        exact,
        significant: if exact { differing > 0 } else { significant_blocks > 0 },
        worst,
    };
    Ok(Tested { statistics, map })
}

/// a - b of each channel, as shown. A channel that is not a number counts as wholly wrong.
fn difference(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|c| {
        let d = a[c].clamp(0.0, 1.0) - b[c].clamp(0.0, 1.0);
        if d.is_nan() { 1.0 } else { d }
    })
}

/// Blocks along a side.
fn count(length: usize, side: usize) -> usize {
    (length / side).max(1)
}

/// `[x0, y0, x1, y1]` of all blocks: the smallest first, the whole picture last, none twice.
fn blocks(width: usize, height: usize) -> Vec<[usize; 4]> {
    let mut grids: Vec<[usize; 2]> =
        SIDES.iter().map(|side| [count(width, *side), count(height, *side)]).collect();
    grids.push([1, 1]);
    grids.dedup();
    let of_grid = |[across, down]: [usize; 2]| {
        (0..down).flat_map(move |j| {
            let (y0, y1) = (j * height / down, (j + 1) * height / down);
            (0..across).map(move |i| [i * width / across, y0, (i + 1) * width / across, y1])
        })
    };
    grids.into_iter().flat_map(of_grid).collect()
}

/// Sum and sum of squares of each channel's differences.
fn sums(differences: &[[f64; 3]], width: usize, [x0, y0, x1, y1]: [usize; 4]) -> [[f64; 2]; 3] {
    let mut channels = [[0.0; 2]; 3];
    for row in differences.chunks(width).take(y1).skip(y0) {
        for pixel in &row[x0..x1] {
            for (sums, d) in channels.iter_mut().zip(pixel) {
                sums[0] += d;
                sums[1] += d * d;
            }
        }
    }
    channels
}

/// Sidak's correction: the level of each of `tests` independent tests, if all together shall have the level `alpha`:
/// 1 - (1 - alpha)^(1/m), without cancellation.
pub fn corrected(alpha: f64, tests: u64) -> f64 {
    -((-alpha).ln_1p() / tests as f64).exp_m1()
}

/// Bound on P(|z| >= x) under the hypothesis, for x >= 0.
fn bound(x: f64) -> f64 {
    (2.0 * normal_above(x) / (4.0 * normal_above(SQRT_2))).min(1.0)
}

/// The x with `bound(x) = p`.
fn threshold(p: f64) -> f64 {
    // At 38 the tail is below the least normal number.
    let (mut low, mut high) = (0.0, 38.0);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if bound(middle) > p { low = middle } else { high = middle }
    }
    high
}

/// P(N(0, 1) >= x) for x >= 0: Abramowitz and Stegun 26.2.11 (series) below 3, 26.2.14 (continued fraction) above.
/// Relative error below 1e-10.
fn normal_above(x: f64) -> f64 {
    let density = (-0.5 * x * x).exp() / (2.0 * PI).sqrt();
    if x < 3.0 {
        let (mut term, mut sum, mut k) = (x, x, 1.0);
        while term > sum * 1e-17 {
            k += 2.0;
            term *= x * x / k;
            sum += term;
        }
        return 0.5 - sum * density;
    }
    let fraction = (1..=100).rev().fold(x, |below, k| x + f64::from(k) / below);
    density / fraction
}

#[cfg(test)]
mod tests;

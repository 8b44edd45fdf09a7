//! The error of one image in its three parts: sampling, truncation, rounding. Each is an upper bound on the RMSE
//! that it makes, so by the triangle inequality their sum is one on the whole.

use super::interval;
use super::limit::RadianceLimit;
use super::samples::{Mark, Traced};
use super::sampling::Noise;
use crate::report::ErrorInfo;

/// The samples of an image so far, pixel by pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct Gathered {
    /// Pixels.
    pub width: u32,
    /// Replicates of a pixel.
    pub replicates: usize,
    /// Samples of each pixel.
    pub samples: Vec<u32>,
    /// Sums of the replicates, `replicates` a pixel.
    pub sums: Vec<[f64; 3]>,
    /// What the samples did.
    pub marks: Vec<Mark>,
}

impl Gathered {
    /// No samples yet.
    pub fn new(width: u32, height: u32, replicates: usize) -> Gathered {
        let pixels = width as usize * height as usize;
        Gathered {
            width,
            replicates,
            samples: vec![0; pixels],
            sums: vec![[0.0; 3]; pixels * replicates],
            marks: vec![Mark::default(); pixels],
        }
    }

    /// Adds `samples` samples of each of `pixels`; of the first of them if fewer were traced.
    pub fn add(&mut self, pixels: &[u32], samples: u32, traced: &Traced) {
        let r = self.replicates;
        for ((at, more), sums) in pixels.iter().zip(&traced.marks).zip(traced.sums.chunks(r)) {
            let at = *at as usize;
            let mark = &mut self.marks[at];
            *mark = if self.samples[at] == 0 { *more } else { mark.and(more) };
            self.samples[at] += samples;
            for (sum, more) in self.sums[at * r..].iter_mut().zip(sums) {
                sum.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
            }
        }
    }

    /// Sums of the replicates of pixel `at`.
    pub fn sums_of(&self, at: usize) -> &[[f64; 3]] {
        &self.sums[at * self.replicates..(at + 1) * self.replicates]
    }

    /// Mean of pixel `at`, linear RGB, unclamped.
    pub fn mean(&self, at: usize) -> [f64; 3] {
        let total = self.sums_of(at).iter().fold([0.0; 3], |a, b| std::array::from_fn(|c| a[c] + b[c]));
        total.map(|channel| channel / f64::from(self.samples[at].max(1)))
    }

    /// The image, linear RGB; pixels without samples are black.
    pub fn linear(&self) -> Vec<[f32; 3]> {
        (0..self.samples.len()).map(|at| self.mean(at).map(|channel| channel as f32)).collect()
    }

    /// Share of pixels that have samples.
    pub fn done(&self) -> f64 {
        self.samples.iter().filter(|n| **n > 0).count() as f64 / self.samples.len().max(1) as f64
    }

    /// What the pixels say of their sampling error; those without samples say nothing.
    pub fn noise(&self) -> Noise {
        let sampled = (0..self.samples.len()).filter(|at| self.samples[*at] > 0);
        sampled.map(|at| Noise::of(self.sums_of(at), self.samples[at])).sum()
    }

    /// Half the width of each pixel's interval, of its widest channel.
    pub fn half_widths(&self, confidence: f64) -> Vec<f64> {
        let half = |at: usize| {
            let each = f64::from(self.samples[at]) / self.replicates as f64;
            let brightest = self.sums_of(at).iter().flatten().fold(1.0, |m: f64, sum| m.max(sum / each));
            let of = |c: usize| {
                let sums: Vec<f64> = self.sums_of(at).iter().map(|s| s[c]).collect();
                let n = self.samples[at];
                let i = interval::pixel(&sums, n, &self.marks[at], (0.0, brightest), confidence);
                (i.high - i.low) / 2.0
            };
            if self.samples[at] == 0 { f64::NAN } else { of(0).max(of(1)).max(of(2)) }
        };
        (0..self.samples.len()).map(half).collect()
    }

    /// Mean throughput that each pixel lost to the cut.
    pub fn cuts(&self) -> Vec<f64> {
        let lost = |(mark, n): (&Mark, &u32)| mark.cut / f64::from((*n).max(1));
        self.marks.iter().zip(&self.samples).map(lost).collect()
    }

    /// What hidden light can add to each pixel as shown, of its worst channel: never less than nothing, no more
    /// than the throughput that was cut times the greatest radiance, nor than what is missing to white.
    pub fn hidden(&self, limit: &RadianceLimit) -> Vec<f64> {
        (0..self.samples.len()).map(|at| self.hidden_of(at, limit).into_iter().fold(0.0, f64::max)).collect()
    }

    fn hidden_of(&self, at: usize, limit: &RadianceLimit) -> [f64; 3] {
        let cut = self.marks[at].cut / f64::from(self.samples[at].max(1));
        let mean = self.mean(at);
        std::array::from_fn(|c| {
            let room = 1.0 - mean[c].clamp(0.0, 1.0);
            if cut > 0.0 { (cut * limit.rgb[c]).min(room) } else { 0.0 }
        })
    }

    /// Root mean square of what hidden light can add to the image as shown.
    pub fn truncation(&self, limit: &RadianceLimit) -> f64 {
        let squares = |at| self.hidden_of(at, limit).iter().map(|h| h * h).sum::<f64>();
        root_mean((0..self.samples.len()).map(squares).sum(), self.samples.len())
    }
}

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

/// Compares the same samples in two precisions.
pub fn rounding(a: &Gathered, b: &Gathered) -> Rounding {
    let mut squares = 0.0;
    let mut worst = |at| {
        let (a, b) = (a.mean(at), b.mean(at));
        let apart: [f64; 3] = std::array::from_fn(|c| (a[c].clamp(0.0, 1.0) - b[c].clamp(0.0, 1.0)).abs());
        squares += apart.iter().map(|d| d * d).sum::<f64>();
        apart.into_iter().fold(0.0, f64::max)
    };
    let pixels: Vec<f64> = (0..a.samples.len()).map(&mut worst).collect();
    let other_way = |(a, b): &(&Mark, &Mark)| (a.hash_least, a.hash_most) != (b.hash_least, b.hash_most);
    let ways = a.marks.iter().zip(&b.marks).filter(other_way).count() as u64;
    Rounding { rmse: root_mean(squares, pixels.len()), pixels, ways }
}

fn root_mean(squares: f64, pixels: usize) -> f64 {
    (squares / (3.0 * pixels.max(1) as f64)).sqrt()
}

/// The three parts and their sum.
pub fn budget(
    image: &Gathered,
    limit: &RadianceLimit,
    rounding: f64,
    rounding_pixels: u64,
    confidence: f64,
) -> ErrorInfo {
    let sampling = image.noise().bound(image.replicates, confidence);
    let truncation = image.truncation(limit);
    let cuts = image.cuts();
    let cut = cuts.iter().sum::<f64>() / cuts.len().max(1) as f64;
    ErrorInfo {
        kind: "rmse".into(),
        confidence,
        sampling: sampling.bound,
        sampling_estimate: sampling.estimate,
        truncation,
        truncation_bounded: cut == 0.0 || limit.unbounded.is_none(),
        truncation_unbounded_why: limit.unbounded.clone().filter(|_| cut > 0.0),
        cut,
        rounding,
        rounding_pixels,
        total: sampling.bound + truncation + rounding,
    }
}

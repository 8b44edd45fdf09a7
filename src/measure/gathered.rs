//! The samples of an image so far, and what its pixels say of their errors.

use super::interval::{self, Interval};
use super::limit::RadianceLimit;
use super::samples::{Mark, Traced};
use super::sampling::Noise;
use super::truncation::{self, TruncationBound};
use serde::{Deserialize, Serialize};

/// The samples of an image so far, pixel by pixel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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

    /// Lets pixel `to` be what pixel `from` is.
    pub fn copy(&mut self, from: usize, to: usize) {
        let r = self.replicates;
        self.samples[to] = self.samples[from];
        self.marks[to] = self.marks[from];
        self.sums.copy_within(from * r..(from + 1) * r, to * r);
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

    /// The intervals of pixel `at`, one a channel; it has samples.
    pub fn intervals(&self, at: usize, confidence: f64) -> [Interval; 3] {
        let n = self.samples[at];
        let each = f64::from(n) / self.replicates as f64;
        let brightest = self.sums_of(at).iter().flatten().fold(1.0, |m: f64, sum| m.max(sum / each));
        std::array::from_fn(|c| {
            let sums: Vec<f64> = self.sums_of(at).iter().map(|s| s[c]).collect();
            interval::pixel(&sums, n, &self.marks[at], (0.0, brightest), confidence)
        })
    }

    /// Half the width of each pixel's interval, of its widest channel.
    pub fn half_widths(&self, confidence: f64) -> Vec<f64> {
        let half = |at: usize| match self.samples[at] {
            0 => f64::NAN,
            _ => self.intervals(at, confidence).iter().fold(0.0, |m: f64, i| m.max((i.high - i.low) / 2.0)),
        };
        (0..self.samples.len()).map(half).collect()
    }

    /// Mean throughput that the image lost to the cut.
    pub fn mean_cut(&self) -> f64 {
        (0..self.samples.len()).map(|at| self.cut(at)).sum::<f64>() / self.samples.len().max(1) as f64
    }

    /// What hidden light can add to each pixel as shown, of its worst channel: never less than nothing, no more
    /// than the throughput that was cut times the greatest radiance, nor than what is missing to white.
    pub fn hidden(&self, limit: &RadianceLimit) -> Vec<f64> {
        (0..self.samples.len()).map(|at| self.hidden_of(at, limit).into_iter().fold(0.0, f64::max)).collect()
    }

    fn hidden_of(&self, at: usize, limit: &RadianceLimit) -> [f64; 3] {
        truncation::hidden(self.mean(at), self.cut(at), limit)
    }

    fn cut(&self, at: usize) -> f64 {
        self.marks[at].cut / f64::from(self.samples[at].max(1))
    }

    /// What hidden light can add to the image as shown.
    pub fn truncation(&self, limit: &RadianceLimit) -> TruncationBound {
        truncation::truncation((0..self.samples.len()).map(|at| (self.mean(at), self.cut(at))), limit)
    }
}

//! What the error budget asks of a tracer: samples of chosen pixels, and what each pixel's rays did.

use serde::{Deserialize, Serialize};
use std::ops::Range;

/// What one pixel's samples did, apart from their colour.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Mark {
    /// Least hash of the path trees of the samples: which primitives they met, which branches they took.
    pub hash_least: u32,
    /// Greatest of those hashes. Where it equals the least, all samples went the same way.
    pub hash_most: u32,
    /// Rays traced, shadow rays included.
    pub rays: u32,
    /// Rays in the longest path.
    pub depth: u32,
    /// Sum over the samples of the throughput of the rays that were cut.
    pub cut: f64,
}

impl Mark {
    /// Of both sets of samples.
    pub fn and(&self, other: &Mark) -> Mark {
        Mark {
            hash_least: self.hash_least.min(other.hash_least),
            hash_most: self.hash_most.max(other.hash_most),
            rays: self.rays.saturating_add(other.rays),
            depth: self.depth.max(other.depth),
            cut: self.cut + other.cut,
        }
    }
}

/// Samples of a list of pixels.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Traced {
    /// Replicates a pixel's samples are divided among.
    pub replicates: usize,
    /// Linear RGB, unclamped: the sum over replicate r of the i-th listed pixel stands at
    /// `i * replicates + r`.
    pub sums: Vec<[f64; 3]>,
    /// One for each listed pixel.
    pub marks: Vec<Mark>,
}

/// Anything that can trace samples of pixels. Sample k is point `k / R` of replicate `k % R`. Replicates are
/// independent of each other; inside one the points may be spread as evenly as one likes. The first
/// samples of many are the samples of few (prefix property).
pub trait Source {
    /// Why tracing failed.
    type Error;

    /// R: replicates of every pixel, at least 2.
    fn replicates(&self) -> usize;

    /// Traces samples of the pixels `y * width + x`. Both ends of `samples` are multiples of R.
    ///
    /// # Errors
    /// Whatever the tracer reports.
    fn trace(&mut self, pixels: &[u32], samples: Range<u32>) -> Result<Traced, Self::Error>;
}

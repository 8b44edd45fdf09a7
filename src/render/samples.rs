//! What the error budget asks of a tracer: samples of chosen pixels, and what each pixel's rays did.

use crate::kernel::abi;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Sets of samples whose sums are kept apart for each pixel: its replicates; or, of one sequence, its consecutive
/// quarters.
pub fn sets(replicates: usize) -> usize {
    if replicates > 1 { replicates } else { abi::PARTS as usize }
}

/// Samples in each quarter of `samples` consecutive ones: quarter q begins at sample ceil(q n / 4)
/// (`place_in_batch` in glsl/resolve.comp).
pub fn quarters(samples: u32) -> [u32; 4] {
    let begin = |q: u32| (q * samples).div_ceil(abi::PARTS);
    std::array::from_fn(|q| begin(q as u32 + 1) - begin(q as u32))
}

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
    /// Replicates a pixel's samples are divided among; 1 for one sequence in quarters.
    pub replicates: usize,
    /// Linear RGB, unclamped: the sum over set s of the i-th listed pixel stands at
    /// `i * sets(replicates) + s`.
    pub sums: Vec<[f64; 3]>,
    /// One for each listed pixel.
    pub marks: Vec<Mark>,
}

/// Anything that can trace samples of pixels. Sample k is point `k / R` of replicate `k % R`. Replicates are
/// independent of each other; within one the points may be spread evenly. The first samples of many are the
/// samples of few (prefix property).
pub trait Source {
    /// Why tracing failed.
    type Error;

    /// R: replicates of every pixel; 1 for one sequence, whose quarters are told apart.
    fn replicates(&self) -> usize;

    /// Traces samples of the pixels `y * width + x`. Both ends of `samples` are multiples of R.
    ///
    /// # Errors
    /// Whatever the tracer reports.
    fn trace(&mut self, pixels: &[u32], samples: Range<u32>) -> Result<Traced, Self::Error>;
}

//! Confidence intervals of single pixels of one sequence, for the sampling layer.
//!
//! One pixel's half difference d ([`sampling`](super::sampling)) has one degree of freedom, too few for an interval.
//! Its neighbours of the same kind - an edge, several path trees among the samples; or not - have errors of about the
//! same size, so the pixel's variance is estimated from its own |d|^2, weighed `OWN`, and those in a window around
//! it (empirical Bayes; Efron and Morris, Journal of the American Statistical Association 70(350), 1975). Of pixels
//! with other numbers of samples n the variances are compared as n^-1.5, the rate along edges (Mitchell, SIGGRAPH
//! 1996).
//! How a doubling divides the variance is measured for each kind over the image, up to 8 where smooth. The half-width
//! is Student's factor for the freedom of the window times the deviation. A pixel whose samples all took the same
//! path next to an edge may hold a part of it that no sample met: the variance of such pixels is at least that of an
//! area below 1/n of the contrast around.

use super::pieces;
use super::pixel_sums::PixelSums;
use super::quantile;
use super::sampling::RATE_MOST;
use crate::render::samples::quarters;

/// Pixels to each side of a window.
const REACH: u32 = 2;
/// Weight of a pixel's own estimate against one of a neighbour.
const OWN: f64 = 4.0;
/// Greatest rate of a doubling: smooth functions, n^-3.
const SMOOTH_RATE: f64 = 8.0;

/// What the quarters of a pixel say, channel by channel.
#[derive(Clone, Copy, Default)]
struct Evidence {
    /// Several path trees.
    edge: bool,
    samples: f64,
    mean: [f64; 3],
    /// d^2; of one sample, half the square of the difference from its pair.
    coarse: [f64; 3],
    /// Mean of the halves' d'^2; 0 where quarters are not known.
    fine: [f64; 3],
    dyadic: bool,
}

/// Half the width of each pixel's interval in its widest channel, in the image as shown; NaN without samples.
pub fn half_widths(image: &PixelSums, confidence: f64) -> Vec<f64> {
    let evidence = pieces::map(image.samples.len(), |at| evidence(image, at));
    let rates = [false, true].map(|edge| rate(&evidence, edge));
    let factors = factors(confidence);
    let half = |at| half_width(image.width, &evidence, at, rates, &factors);
    pieces::map(evidence.len(), half)
}

/// Student's factor for a window with 0, 1, ... neighbours of the pixel's kind. Estimates of unequal weight w have
/// Satterthwaite's freedom, (sum w)^2 / sum w^2.
fn factors(confidence: f64) -> Vec<f64> {
    let factor = |neighbours: u32| {
        let n = f64::from(neighbours);
        quantile::student(0.5 + confidence / 2.0, (OWN + n).powi(2) / (OWN * OWN + n))
    };
    (0..(2 * REACH + 1).pow(2)).map(factor).collect()
}

fn evidence(image: &PixelSums, at: usize) -> Evidence {
    let samples = image.samples[at];
    let (sums, counts) = (image.sums_of(at), quarters(samples).map(f64::from));
    let mark = &image.marks[at];
    let edge = mark.hash_least != mark.hash_most;
    let mut e = Evidence {
        edge,
        samples: f64::from(samples),
        dyadic: samples.is_power_of_two(),
        ..Evidence::default()
    };
    if samples < 2 {
        if samples == 1 {
            e.mean = image.mean(at);
            let other = image.pair_of(at).map_or([f64::INFINITY; 3], |q| image.mean(q));
            // Half the square of their difference: a variance.
            e.coarse = std::array::from_fn(|c| 0.5 * (e.mean[c] - other[c]).abs().min(1.0).powi(2));
        }
        return e;
    }
    for c in 0..3 {
        let apart = |(a, n): (f64, f64), (b, m): (f64, f64)| {
            if n > 0.0 && m > 0.0 { (a / n - b / m).powi(2) * n * m / (n + m).powi(2) } else { 0.0 }
        };
        let q: [(f64, f64); 4] = std::array::from_fn(|i| (sums[i][c], counts[i]));
        let both = |a: (f64, f64), b: (f64, f64)| (a.0 + b.0, a.1 + b.1);
        e.mean[c] = (q[0].0 + q[1].0 + q[2].0 + q[3].0) / f64::from(samples);
        e.coarse[c] = apart(both(q[0], q[1]), both(q[2], q[3]));
        e.fine[c] = 0.5 * (apart(q[0], q[1]) + apart(q[2], q[3]));
    }
    e.dyadic &= samples >= 4;
    e
}

/// By how much a doubling divides the variance of the pixels of a kind.
fn rate(evidence: &[Evidence], edge: bool) -> f64 {
    let (mut coarse, mut fine) = (0.0, 0.0);
    for e in evidence.iter().filter(|e| e.edge == edge && e.dyadic) {
        coarse += e.coarse.iter().sum::<f64>();
        fine += e.fine.iter().sum::<f64>();
    }
    let most = if edge { RATE_MOST } else { SMOOTH_RATE };
    if coarse > 0.0 { (fine / coarse).clamp(2.0, most) } else { 2.0 }
}

fn half_width(width: u32, evidence: &[Evidence], at: usize, rates: [f64; 2], factors: &[f64]) -> f64 {
    let own = &evidence[at];
    if own.samples < 1.0 {
        return f64::NAN;
    }
    let (x, y) = (at as u32 % width, at as u32 / width);
    let height = evidence.len() as u32 / width;
    let columns = x.saturating_sub(REACH)..(x + REACH + 1).min(width);
    let window = (y.saturating_sub(REACH)..(y + REACH + 1).min(height))
        .flat_map(|v| columns.clone().map(move |u| (v * width + u) as usize));
    let rate = rates[usize::from(own.edge)];
    let (mut sum, mut weights, mut neighbours) = ([0.0; 3], 0.0, 0);
    let (mut low, mut high, mut near_edge) = (own.mean, own.mean, false);
    for (q, e) in window.map(|q| (q, &evidence[q])).filter(|(_, e)| e.samples >= 1.0) {
        let near = at.abs_diff(q) <= 1 || at.abs_diff(q).abs_diff(width as usize) <= 1;
        if near {
            near_edge |= e.edge || e.mean != own.mean;
            for c in 0..3 {
                (low[c], high[c]) = (low[c].min(e.mean[c]), high[c].max(e.mean[c]));
            }
        }
        if e.edge != own.edge {
            continue;
        }
        let weight = if q == at { OWN } else { 1.0 };
        // What a pair differs by is no half difference: no doubling goes before it.
        let rate = if e.samples > 1.0 { rate } else { 2.0 };
        let scale = weight * (e.samples / own.samples).powf(1.5) / (rate - 1.0);
        for c in 0..3 {
            sum[c] += scale * e.coarse[c];
        }
        weights += weight;
        neighbours += usize::from(q != at);
    }
    let factor = factors[neighbours];
    let mut widest = 0.0f64;
    for c in 0..3 {
        let mut variance = if weights > 0.0 { sum[c] / weights } else { 0.0 };
        if !own.edge && near_edge {
            // The share of such pixels that hold a part of the edge is small, and it is below 1/n of them.
            let contrast = high[c].min(1.0) - low[c].clamp(0.0, 1.0);
            variance = f64::max(variance, (0.1 * contrast / own.samples).powi(2));
        }
        let half = factor * variance.sqrt();
        let (below, above) = ((own.mean[c] - half).clamp(0.0, 1.0), (own.mean[c] + half).clamp(0.0, 1.0));
        widest = widest.max(0.5 * (above - below));
    }
    widest
}

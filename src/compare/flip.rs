//! LDR-FLIP: how different two pictures look when one is flipped to the other and back. Andersson,
//! Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild, "FLIP: A Difference Evaluator for
//! Alternating Images", Proc. ACM Computer Graphics and Interactive Techniques 3(2), 2020. Names
//! of steps below are that paper's.
//!
//! All filters are Gaussians or their derivatives, so each is run as a row and a column. In f64: the
//! judge of a difference should add none of its own.

use super::metrics::{Rgb, SizeMismatch};
use glam::{DMat3, DVec3};
use rayon::prelude::*;
use std::f64::consts::{FRAC_1_SQRT_2, PI};
use std::sync::LazyLock;

/// Pixels per degree of visual angle that the authors take: a display of 3840 pixels on 0.7 m, seen
/// from 0.7 m.
pub const PIXELS_PER_DEGREE: f64 = 0.7 * 3840.0 / 0.7 * PI / 180.0;

/// Contrast sensitivity as sums of a sqrt(pi / b) exp(-pi^2 d^2 / b) over the distance d in degrees:
/// pairs (a, b) for the achromatic, red-green and blue-yellow channels ("spatial filtering").
const SENSITIVITY: [&[(f64, f64)]; 3] = [&[(1.0, 0.0047)], &[(1.0, 0.0053)], &[(34.1, 0.04), (13.5, 0.025)]];
/// The largest b above: all three filters have the radius that it needs, three standard deviations.
const WIDEST: f64 = 0.04;
/// Width of the edge and point detectors from peak to trough, degrees ("feature pipeline").
const FEATURE_WIDTH: f64 = 0.082;
/// Exponent of the colour difference, q_c ("error redistribution").
const COLOR_EXPONENT: f64 = 0.7;
/// Exponent of the feature difference, q_f ("feature pipeline").
const FEATURE_EXPONENT: f64 = 0.5;
/// Colour differences up to this share of the largest, p_c, ...
const KNEE: f64 = 0.4;
/// ... fill this share of the scale, p_t.
const BELOW_KNEE: f64 = 0.95;

/// FLIP of every pixel, in [0, 1]: 0 where the pictures look the same. Rows of `width` pixels, linear
/// RGB, clamped to [0, 1]. Which of the two is the reference does not matter.
///
/// # Errors
/// If the pictures differ in length, or are not whole rows of `width` pixels.
pub fn flip<A: Rgb + Sync, B: Rgb + Sync>(
    a: &[A],
    b: &[B],
    width: usize,
    pixels_per_degree: f64,
) -> Result<Vec<f64>, SizeMismatch> {
    if a.len() != b.len() || width == 0 || !a.len().is_multiple_of(width) {
        return Err(SizeMismatch(a.len(), b.len()));
    }
    let (a, b) = (Seen::new(a, width, pixels_per_degree), Seen::new(b, width, pixels_per_degree));
    let largest = distance(hunt_lab(DVec3::Y), hunt_lab(DVec3::Z)).powf(COLOR_EXPONENT);
    Ok((0..a.color.len())
        .into_par_iter()
        .map(|i| {
            let color = redistributed(distance(a.color[i], b.color[i]).powf(COLOR_EXPONENT), largest);
            let [edge, point] = [0, 1].map(|k| (a.features[i][k] - b.features[i][k]).abs());
            let feature = (FRAC_1_SQRT_2 * edge.max(point)).powf(FEATURE_EXPONENT);
            // "Final difference". 0 to the power 0 would be 1 where an edge appears in an unchanged colour.
            if color == 0.0 { 0.0 } else { color.powf(1.0 - feature).min(1.0) }
        })
        .collect())
}

/// The mean of a map, which the authors give as the one number of a pair ("pooling"); 0 of none.
pub fn mean(map: &[f64]) -> f64 {
    if map.is_empty() { 0.0 } else { map.iter().sum::<f64>() / map.len() as f64 }
}

/// What an observer has of a picture.
struct Seen {
    /// Hunt-adjusted L*a*b*, after the spatial filters.
    color: Vec<DVec3>,
    /// Strength of edges and of points.
    features: Vec<[f64; 2]>,
}

impl Seen {
    fn new<P: Rgb + Sync>(picture: &[P], width: usize, pixels_per_degree: f64) -> Seen {
        let opponent: Vec<DVec3> = picture
            .par_iter()
            .map(|p| ycxcz(DVec3::from_array(p.rgb()).clamp(DVec3::ZERO, DVec3::ONE)))
            .collect();
        let plane = |c: usize| opponent.iter().map(|p| p[c]).collect::<Vec<f64>>();
        let planes = [0, 1, 2].map(plane);
        let radius = (3.0 * (WIDEST / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as usize;
        let filtered = [0, 1, 2].map(|c| {
            let mut sum = vec![0.0; picture.len()];
            for (weight, taps) in sensitivity(SENSITIVITY[c], radius, pixels_per_degree) {
                let part = separable(&planes[c], width, &taps, &taps);
                sum.iter_mut().zip(part).for_each(|(s, p)| *s += weight * p);
            }
            sum
        });
        let color = (0..picture.len())
            .into_par_iter()
            .map(|i| {
                let rgb = linear(DVec3::new(filtered[0][i], filtered[1][i], filtered[2][i]));
                hunt_lab(rgb.clamp(DVec3::ZERO, DVec3::ONE))
            })
            .collect();

        let light: Vec<f64> = planes[0].iter().map(|y| (y + 16.0) / 116.0).collect();
        let detectors = Detectors::new(pixels_per_degree);
        let strength = |taps: &[f64]| -> Vec<f64> {
            let across = separable(&light, width, taps, &detectors.smooth);
            let down = separable(&light, width, &detectors.smooth, taps);
            across.iter().zip(down).map(|(x, y)| x.hypot(y)).collect()
        };
        let (edges, points) = (strength(&detectors.edge), strength(&detectors.point));
        Seen { color, features: edges.into_iter().zip(points).map(|(e, p)| [e, p]).collect() }
    }
}

/// A Gaussian's taps from -radius to radius, of sum 1, and their sum before.
fn gaussian(radius: usize, exponent: impl Fn(f64) -> f64) -> (Vec<f64>, f64) {
    let taps: Vec<f64> = offsets(radius).map(|x| exponent(x).exp()).collect();
    let sum: f64 = taps.iter().sum();
    (taps.iter().map(|t| t / sum).collect(), sum)
}

fn offsets(radius: usize) -> impl Iterator<Item = f64> {
    (0..=2 * radius).map(move |i| i as f64 - radius as f64)
}

/// Weights, which add up to 1, and taps of one channel's filter.
fn sensitivity(terms: &[(f64, f64)], radius: usize, pixels_per_degree: f64) -> Vec<(f64, Vec<f64>)> {
    let parts: Vec<_> = terms
        .iter()
        .map(|(a, b)| {
            let (taps, sum) = gaussian(radius, |x| -(PI * x / pixels_per_degree).powi(2) / b);
            // In two dimensions the part's weights sum to the square.
            (a * (PI / b).sqrt() * sum * sum, taps)
        })
        .collect();
    let total: f64 = parts.iter().map(|(weight, _)| weight).sum();
    parts.into_iter().map(|(weight, taps)| (weight / total, taps)).collect()
}

/// First and second derivative of a Gaussian, each with its positive taps scaled to the sum 1 and its
/// negative ones to -1, and the Gaussian itself.
struct Detectors {
    smooth: Vec<f64>,
    edge: Vec<f64>,
    point: Vec<f64>,
}

impl Detectors {
    fn new(pixels_per_degree: f64) -> Detectors {
        let deviation = 0.5 * FEATURE_WIDTH * pixels_per_degree;
        let radius = (3.0 * deviation).ceil() as usize;
        let (smooth, _) = gaussian(radius, |x| -(x / deviation).powi(2) / 2.0);
        let derived = |factor: &dyn Fn(f64) -> f64| {
            let taps: Vec<f64> = offsets(radius).zip(&smooth).map(|(x, g)| factor(x) * g).collect();
            let side = |sign: f64| taps.iter().map(|t| (sign * t).max(0.0)).sum::<f64>();
            let (above, below) = (side(1.0), side(-1.0));
            taps.iter().map(|t| if *t > 0.0 { t / above } else { t / below }).collect()
        };
        let edge = derived(&|x| -x);
        let point = derived(&|x| (x / deviation).powi(2) - 1.0);
        Detectors { smooth, edge, point }
    }
}

/// Filters rows with `across` and columns with `down`; beyond an edge its pixels repeat.
fn separable(plane: &[f64], width: usize, across: &[f64], down: &[f64]) -> Vec<f64> {
    let height = plane.len() / width;
    let place = |at: usize, tap: usize, taps: usize, length: usize| {
        (at + tap).saturating_sub(taps / 2).min(length - 1)
    };
    let mut rows = vec![0.0; plane.len()];
    rows.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        let source = &plane[y * width..][..width];
        for (x, out) in row.iter_mut().enumerate() {
            *out = across.iter().enumerate().map(|(i, t)| t * source[place(x, i, across.len(), width)]).sum();
        }
    });
    let mut both = vec![0.0; plane.len()];
    both.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        for (i, t) in down.iter().enumerate() {
            let source = &rows[place(y, i, down.len(), height) * width..][..width];
            out.iter_mut().zip(source).for_each(|(o, s)| *o += t * s);
        }
    });
    both
}

/// Linear sRGB to CIE XYZ, from the primaries and D65 of IEC 61966-2-1, in the digits of the authors.
static XYZ: LazyLock<DMat3> = LazyLock::new(|| {
    let row = |r: f64, g: f64, b: f64, over: f64| DVec3::new(r, g, b) / over;
    DMat3::from_cols(
        row(10_135_552.0, 8_788_810.0, 4_435_075.0, 24_577_794.0),
        row(2_613_072.0, 8_788_810.0, 887_015.0, 12_288_897.0),
        row(1_425_312.0, 8_788_810.0, 70_074_185.0, 73_733_382.0),
    )
    .transpose()
});
static RGB: LazyLock<DMat3> = LazyLock::new(|| XYZ.inverse());
static WHITE: LazyLock<DVec3> = LazyLock::new(|| *XYZ * DVec3::ONE);

/// Linear RGB to the opponent space YCxCz, a linear relative of L*a*b*.
fn ycxcz(rgb: DVec3) -> DVec3 {
    let v = *XYZ * rgb / *WHITE;
    DVec3::new(116.0 * v.y - 16.0, 500.0 * (v.x - v.y), 200.0 * (v.y - v.z))
}

/// The way back.
fn linear(ycxcz: DVec3) -> DVec3 {
    let y = (ycxcz.x + 16.0) / 116.0;
    *RGB * (DVec3::new(y + ycxcz.y / 500.0, y, y - ycxcz.z / 200.0) * *WHITE)
}

/// CIE L*a*b* of linear RGB, with a* and b* scaled by the lightness: Hunt's effect.
fn hunt_lab(rgb: DVec3) -> DVec3 {
    const DELTA: f64 = 6.0 / 29.0;
    let f = |t: f64| {
        if t > DELTA * DELTA * DELTA { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
    };
    let v = *XYZ * rgb / *WHITE;
    let (x, y, z) = (f(v.x), f(v.y), f(v.z));
    let lightness = 116.0 * y - 16.0;
    let hunt = 0.01 * lightness;
    DVec3::new(lightness, hunt * 500.0 * (x - y), hunt * 200.0 * (y - z))
}

/// HyAB: city block in lightness, Euclidean in colour.
fn distance(a: DVec3, b: DVec3) -> f64 {
    let d = a - b;
    d.x.abs() + d.y.hypot(d.z)
}

/// To [0, 1], most of it for the smaller differences.
fn redistributed(difference: f64, largest: f64) -> f64 {
    let knee = KNEE * largest;
    if difference < knee {
        BELOW_KNEE / knee * difference
    } else {
        BELOW_KNEE + (difference - knee) / (largest - knee) * (1.0 - BELOW_KNEE)
    }
}

#[cfg(test)]
mod tests;

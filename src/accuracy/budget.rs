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
    /// True for the pixels of which some sample took another way.
    pub other_way: Vec<bool>,
    /// Their number.
    pub ways: u64,
    /// RMSE over the other pixels, whose samples differ in value alone.
    pub values: f64,
}

impl Rounding {
    /// Of an image in f64.
    pub fn none(pixels: usize) -> Rounding {
        Rounding { pixels: vec![0.0; pixels], other_way: vec![false; pixels], ..Rounding::default() }
    }

    /// Of each pixel the difference in value; NaN where some sample took another way.
    pub fn value_differences(&self) -> Vec<f64> {
        let of = |(x, other): (&f64, &bool)| if *other { f64::NAN } else { *x };
        self.pixels.iter().zip(&self.other_way).map(of).collect()
    }

    /// 1 for the pixels of which some sample took another way, else 0.
    pub fn path_differences(&self) -> Vec<f64> {
        self.other_way.iter().map(|other| f64::from(u8::from(*other))).collect()
    }
}

/// True if all samples of both took the same ways, as far as their extreme hashes tell.
pub fn same_way(a: &Mark, b: &Mark) -> bool {
    (a.hash_least, a.hash_most) == (b.hash_least, b.hash_most)
}

/// Compares the same samples in two precisions.
pub fn rounding(a: &PixelSums, b: &PixelSums) -> Rounding {
    let (mut squares, mut of_values) = (0.0, 0.0);
    let other_way: Vec<bool> = a.marks.iter().zip(&b.marks).map(|(a, b)| !same_way(a, b)).collect();
    let mut worst = |at: usize| {
        let (a, b) = (a.mean(at), b.mean(at));
        let apart: [f64; 3] = std::array::from_fn(|c| (a[c].clamp(0.0, 1.0) - b[c].clamp(0.0, 1.0)).abs());
        let square = apart.iter().map(|d| d * d).sum::<f64>();
        squares += square;
        of_values += if other_way[at] { 0.0 } else { square };
        apart.into_iter().fold(0.0, f64::max)
    };
    let both = a.samples.len().min(b.samples.len());
    let pixels: Vec<f64> = (0..both).map(&mut worst).collect();
    let ways = other_way.iter().filter(|other| **other).count();
    let values = root_mean(of_values, both - ways);
    Rounding { rmse: root_mean(squares, both), pixels, other_way, ways: ways as u64, values }
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
    (rounding, encoding): (Option<(f64, u64)>, Option<f64>),
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
        truncation_certain: None,
        truncation_pixels: None,
        cut: image.mean_cut(),
        rounding: rounding.map(|(part, _)| part),
        rounding_pixels: rounding.map(|(_, pixels)| pixels),
        rounding_values: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::samples::Traced;

    /// Pixels of four equal samples each, by level and hash.
    fn image(pixels: &[(f64, u32)]) -> PixelSums {
        let count = pixels.len() as u32;
        let mut image = PixelSums::new(count, 1, 1);
        let mark = |hash| Mark { hash_least: hash, hash_most: hash, ..Mark::default() };
        let traced = Traced {
            replicates: 1,
            sums: pixels.iter().flat_map(|p| [[p.0; 3]; 4]).collect(),
            marks: pixels.iter().map(|p| mark(p.1)).collect(),
        };
        image.add(&(0..count).collect::<Vec<_>>(), 4, &traced);
        image
    }

    #[test]
    fn changed_paths_are_told_from_changed_values() {
        let a = image(&[(0.5, 1), (0.5, 2), (0.5, 3), (0.25, 4)]);
        let b = image(&[(0.5, 1), (0.75, 2), (0.5, 3), (1.0, 7)]);
        let rounding = rounding(&a, &b);
        assert_eq!((rounding.ways, &rounding.path_differences()[..]), (1, &[0.0, 0.0, 0.0, 1.0][..]));
        let values = rounding.value_differences();
        assert!(values[..3] == [0.0, 0.25, 0.0] && values[3].is_nan(), "{values:?}");
        // One of three pixels with the same paths is off by 1/4; one of all four by 3/4 more.
        assert!((rounding.values - (0.0625f64 / 3.0).sqrt()).abs() < 1e-12, "{}", rounding.values);
        assert!((rounding.rmse - ((0.0625f64 + 0.5625) / 4.0).sqrt()).abs() < 1e-12, "{}", rounding.rmse);
        // Where every path differs there is nothing to compare by value.
        let other = super::rounding(&image(&[(0.5, 1)]), &image(&[(0.25, 2)]));
        assert_eq!((other.values, other.ways), (0.0, 1));
    }
}

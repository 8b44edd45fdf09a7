//! The true error of an image, measured against a truth that is itself noisy, and what it says about a bound.
//!
//! Let I be the image, mu the exact pixel and T the mean of M renders with independent seeds, so that T = mu + t with
//! E t = 0 and Var t = v. Then
//!
//! ```text
//! E (I - T)^2 = (I - mu)^2 + v
//! ```
//!
//! since I and T are independent: the measured mean square is too large by v, and sqrt(e^2 + s^2) is what one measures for
//! an error e with a truth of RMSE s. v is estimated by the spread between the seeds, so q = (I - T)^2 - v is an unbiased
//! estimate of the squared error. (It equals the mean of (I - x_i)(I - x_j) over all pairs of different seeds.) It is a
//! mean over the pixels, so its uncertainty is small even where v is not. Per pixel, with d = I - T,
//!
//! ```text
//! Var q <= 4 d^2 v + 2 v^2 M / (M - 1)
//! ```
//!
//! The first term is that of 2 (I - mu) t, with d^2, which is (I - mu)^2 + v on average, in place of (I - mu)^2. The
//! second is Var(t^2) = 2 v^2 plus Var(v) = 2 v^2 / (M - 1), for normal t; where few samples meet something bright t is
//! far from normal, and M is then too small to know v well. Channels of a pixel are taken as fully correlated, which is
//! the worst case (Cauchy-Schwarz); pixels are independent, since each has its own scrambling.
//!
//! Errors are those of the image as shown, in [0, 1]. Clamping is not linear: v is the delete-one jackknife variance
//! (Efron and Stein, Annals of Statistics 9, 1981) of the clamped mean, which is the ordinary variance where nothing is
//! clamped. A pixel whose mean is within its noise of 1 leaves a bias of second order, which is not corrected.

use serde::{Deserialize, Serialize};

/// Standard errors of the truth within which a comparison is left undecided.
const DOUBT: f64 = 2.0;

/// An image as shown: linear RGB clamped to [0, 1], rows from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Shown(pub Vec<[f64; 3]>);

impl Shown {
    /// Clamps `linear`.
    pub fn of(linear: &[[f32; 3]]) -> Shown {
        Shown(linear.iter().map(|p| p.map(|c| f64::from(c).clamp(0.0, 1.0))).collect())
    }

    /// Root of the mean square difference.
    pub fn distance(&self, other: &Shown) -> f64 {
        let squares =
            self.0.iter().zip(&other.0).flat_map(|(a, b)| (0..3).map(move |c| (a[c] - b[c]).powi(2)));
        (squares.sum::<f64>() / (3 * self.0.len().max(1)) as f64).sqrt()
    }
}

/// The mean of renders with independent seeds, with its variance per pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// As shown.
    pub pixels: Shown,
    /// Variance of each channel of `pixels`.
    pub variance: Vec<[f64; 3]>,
    /// Number of seeds, at least 2.
    pub seeds: u32,
    /// RMSE that the paths which the truth leaves out may cause.
    pub hidden: f64,
}

impl Reference {
    /// The mean of `renders`, linear RGB, unclamped; at least two of the same size.
    pub fn of(renders: &[Vec<[f32; 3]>], hidden: f64) -> Reference {
        let seeds = renders.len().max(1) as f64;
        let shown = |x: f64| x.clamp(0.0, 1.0);
        let pixels = renders.first().map_or(0, Vec::len);
        let mut reference = Reference {
            pixels: Shown(Vec::with_capacity(pixels)),
            variance: Vec::with_capacity(pixels),
            seeds: renders.len() as u32,
            hidden,
        };
        for at in 0..pixels {
            let (mut mean, mut variance) = ([0.0; 3], [0.0; 3]);
            for c in 0..3 {
                let values = || renders.iter().map(|r| f64::from(r[at][c]));
                let total: f64 = values().sum();
                let without: Vec<f64> = values().map(|x| shown((total - x) / (seeds - 1.0))).collect();
                let middle = without.iter().sum::<f64>() / seeds;
                mean[c] = shown(total / seeds);
                variance[c] =
                    (seeds - 1.0) / seeds * without.iter().map(|x| (x - middle).powi(2)).sum::<f64>();
            }
            reference.pixels.0.push(mean);
            reference.variance.push(variance);
        }
        reference
    }

    /// Its own RMSE.
    pub fn error(&self) -> f64 {
        let sum: f64 = self.variance.iter().flatten().sum();
        (sum / (3 * self.variance.len().max(1)) as f64).sqrt()
    }

    /// The true error of `image`.
    pub fn measure(&self, image: &Shown) -> Measured {
        let seeds = f64::from(self.seeds.max(2));
        let (mut square, mut variance) = (0.0, 0.0);
        for ((pixel, truth), v) in image.0.iter().zip(&self.pixels.0).zip(&self.variance) {
            let d: [f64; 3] = std::array::from_fn(|c| pixel[c] - truth[c]);
            let noise: f64 = v.iter().sum();
            square += d.iter().map(|d| d * d).sum::<f64>() - noise;
            let cross: f64 = (0..3).map(|c| d[c].abs() * v[c].sqrt()).sum();
            variance += 4.0 * cross * cross + 2.0 * noise * noise * seeds / (seeds - 1.0);
        }
        let n = (3 * image.0.len().max(1)) as f64;
        Measured { square: square / n, deviation: variance.sqrt() / n, hidden: self.hidden }
    }
}

/// A true error with its uncertainty.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// Estimate of the mean square error; below 0 where the truth's noise hides the error.
    pub square: f64,
    /// Standard error of `square`.
    pub deviation: f64,
    /// RMSE that the paths which the truth leaves out may cause.
    pub hidden: f64,
}

/// A bound compared with a true error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Judgement {
    /// The error is within the bound.
    Kept,
    /// It is not.
    Broken,
    /// The truth is not exact enough to say.
    Undecided,
}

impl Measured {
    /// The best estimate of the RMSE.
    pub fn error(&self) -> f64 {
        self.square.max(0.0).sqrt()
    }

    /// Least and greatest RMSE that agree with the measurement.
    pub fn range(&self) -> [f64; 2] {
        let root = |square: f64| square.max(0.0).sqrt();
        let reach = DOUBT * self.deviation;
        [(root(self.square - reach) - self.hidden).max(0.0), root(self.square + reach) + self.hidden]
    }

    /// Compares the error with `bound`. A bound that is no number is broken.
    pub fn judge(&self, bound: f64) -> Judgement {
        let [least, most] = self.range();
        match bound {
            b if b.is_nan() || b < least => Judgement::Broken,
            b if b >= most => Judgement::Kept,
            _ => Judgement::Undecided,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::procedural::families::draw::Draw;

    /// Roughly normal, with mean 0 and variance 1.
    fn normal(draw: &mut Draw) -> f64 {
        (0..12).map(|_| draw.unit()).sum::<f64>() - 6.0
    }

    fn grey(values: impl Iterator<Item = f64>) -> Vec<[f32; 3]> {
        values.map(|x| [x as f32; 3]).collect()
    }

    /// The error is found although the truth's own is as large, and it varies as much as stated.
    #[test]
    fn the_truths_own_noise_is_taken_off_and_its_uncertainty_is_stated() {
        let (pixels, error, noise) = (600, 0.02, 0.04);
        let mut draw = Draw::new("judge", 0, 1);
        let (mut scores, mut squares) = (Vec::new(), 0.0);
        for _ in 0..200 {
            let renders: Vec<_> =
                (0..4).map(|_| grey((0..pixels).map(|_| 0.5 + noise * normal(&mut draw)))).collect();
            let truth = Reference::of(&renders, 0.0);
            assert!((truth.error() - noise / 2.0).abs() < 0.1 * noise);
            let measured = truth.measure(&Shown(vec![[0.5 + error; 3]; pixels]));
            squares += measured.square / 200.0;
            scores.push((measured.square - error * error) / measured.deviation);
        }
        // Without the correction it would be twice as large.
        assert!((squares / (error * error) - 1.0).abs() < 0.05, "{squares}");
        let spread = (scores.iter().map(|z| z * z).sum::<f64>() / 200.0).sqrt();
        println!("spread {spread:.3}");
        // d^2 contains v, so the stated deviation is 1.2 times the true one here.
        assert!((0.65..1.05).contains(&spread), "{spread}");
    }

    #[test]
    fn only_what_lies_within_two_standard_errors_is_undecided() {
        let measured = Measured { square: 1e-4, deviation: 1e-5, hidden: 0.0 };
        let bounds = [0.003, 0.0088, 0.009, 0.01, 0.0109, 0.011, f64::NAN, f64::INFINITY];
        use Judgement::{Broken, Kept, Undecided};
        let want = [Broken, Broken, Undecided, Undecided, Undecided, Kept, Broken, Kept];
        assert_eq!(bounds.map(|b| measured.judge(b)), want);
        let hidden = Measured { hidden: 0.002, ..measured };
        assert_eq!([0.0088, 0.011].map(|b| hidden.judge(b)), [Undecided, Undecided]);
        assert_eq!(Measured::default().judge(0.0), Kept);
    }

    #[test]
    fn clamped_pixels_have_no_noise() {
        let renders = [grey([3.0, 0.2].into_iter()), grey([5.0, 0.4].into_iter())];
        let truth = Reference::of(&renders, 0.0);
        assert_eq!((truth.pixels.0[0], truth.variance[0]), ([1.0; 3], [0.0; 3]));
        // The variance of a mean of two: their half difference, squared.
        assert!((truth.pixels.0[1][0] - 0.3).abs() < 1e-6 && (truth.variance[1][0] - 0.01).abs() < 1e-6);
    }
}

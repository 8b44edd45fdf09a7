//! The truncation part of an image's error from complete paths of drawn pixels.
//!
//! What cut rays may hide is certain ([`truncation`](super::truncation)), but it is reckoned with the brightest of the
//! whole scene: a lamp near one ceiling raises it everywhere. What they do hide is seen where the same samples are
//! traced again with longer paths. Let h_p^2 be the sum over the channels of pixel p of the squares of what it may lack,
//! H their sum over the image, and e_p^2 <= h_p^2 the same of what it does lack. A pixel that is drawn with probability
//! h_p^2 / H has x = e_p^2 / h_p^2 in [0, 1], of expectation E / H, where E is the sum of e_p^2 that is sought.
//!
//! One pixel is drawn in each of M equal strata of the cumulated h_p^2. The draws are independent, and the mean of
//! their expectations is mu = E / H. For independent variables in [0, 1] the mean x' lies at or below q <= mu with a
//! probability of at most exp(-M KL(q, mu)), `KL(q, mu) = q ln(q / mu) + (1 - q) ln((1 - q) / (1 - mu))` (Hoeffding,
//! Journal of the American Statistical Association 58(301), 1963, Theorem 1). So with risk r, mu is at most the greater
//! root of M KL(x', mu) = -ln r: with nothing hidden in any of M draws, 1 - r^(1/M).
//!
//! Longer paths are cut somewhere, too: what they may lack is added to what they show, so x is never too small.

use super::pieces;
use super::pixel_sums::PixelSums;
use super::radiance_bound::RadianceLimit;
use crate::settings::sampler::pcg4d;

/// Stream of the draws, apart from those of the sampler.
const STREAM: u32 = 0xd4a3_17e5;

/// h_p^2 of each pixel of an image.
pub struct Weights(Vec<f64>);

impl Weights {
    /// Of `image`.
    pub fn new(image: &PixelSums, limit: &RadianceLimit) -> Weights {
        Weights(pieces::map(image.samples.len(), |at| squares(image.hidden_of(at, limit))))
    }

    /// `draws` pixels for random numbers `seed`, in rising order, some of them more than once; none where nothing is
    /// hidden.
    pub fn draw(&self, draws: u32, seed: u32) -> Vec<u32> {
        let Weights(weights) = self;
        let whole: f64 = weights.iter().sum();
        let mut drawn = Vec::with_capacity(draws as usize);
        let (mut at, mut end) = (0, weights.first().copied().unwrap_or(0.0));
        for stratum in 0..draws {
            let [high, low, ..] = pcg4d([stratum, draws, seed, STREAM]);
            let within = (f64::from(high) + f64::from(low) / 2f64.powi(32)) / 2f64.powi(32);
            let place = (f64::from(stratum) + within) / f64::from(draws) * whole;
            while end <= place && at + 1 < weights.len() {
                at += 1;
                end += weights[at];
            }
            if weights.get(at).is_some_and(|weight| *weight > 0.0) {
                drawn.push(at as u32);
            }
        }
        drawn
    }

    /// Mean of `values`, one a pixel, over the pixels that are drawn; 0 where nothing is hidden.
    pub fn mean(&self, values: &[u32]) -> f64 {
        let all: f64 = self.0.iter().sum();
        let weighted = self.0.iter().zip(values).map(|(weight, value)| weight * f64::from(*value));
        if all > 0.0 { weighted.sum::<f64>() / all } else { 0.0 }
    }
}

/// x of pixel `at` of `image`, whose samples with longer paths are pixel `deeper_at` of `deeper`; and what the longer
/// paths may lack of it. Both in [0, 1].
pub fn lacking(
    (image, at): (&PixelSums, usize),
    (deeper, deeper_at): (&PixelSums, usize),
    limit: &RadianceLimit,
) -> (f64, f64) {
    let most = image.hidden_of(at, limit);
    let whole = squares(most);
    if whole <= 0.0 {
        return (0.0, 0.0);
    }
    let (seen, longer) = (image.mean(at), deeper.mean(deeper_at));
    let rest = deeper.hidden_of(deeper_at, limit);
    let shown = |c: usize| (longer[c].clamp(0.0, 1.0) - seen[c].clamp(0.0, 1.0)).abs();
    let lacks: [f64; 3] = std::array::from_fn(|c| (shown(c) + rest[c]).min(most[c]));
    (squares(lacks) / whole, (squares(rest) / whole).min(1.0))
}

/// Upper limit, with risk `risk`, of the mean of the expectations of `draws` independent variables in [0, 1] whose mean is
/// `mean`.
pub fn upper_mean(mean: f64, draws: u32, risk: f64) -> f64 {
    let allowed = -risk.ln() / f64::from(draws.max(1));
    let part = |q: f64, mu: f64| if q > 0.0 { q * (q / mu).ln() } else { 0.0 };
    let apart = |mu: f64| part(mean, mu) + part(1.0 - mean, 1.0 - mu);
    let (mut low, mut high) = (mean.clamp(0.0, 1.0), 1.0);
    // 64 halvings leave less than the last bit of 1; the upper end is the safe one.
    for _ in 0..64 {
        let middle = 0.5 * (low + high);
        if apart(middle) < allowed { low = middle } else { high = middle }
    }
    high
}

fn squares(channels: [f64; 3]) -> f64 {
    channels.iter().map(|c| c * c).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::samples::{Mark, Traced};

    fn random(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Pixels of one sample each: level, and throughput cut.
    fn image(pixels: &[(f64, f64)]) -> PixelSums {
        let count = pixels.len() as u32;
        let mut image = PixelSums::new(count, 1, 1);
        let traced = Traced {
            replicates: 1,
            sums: pixels.iter().flat_map(|p| [[p.0; 3], [0.0; 3], [0.0; 3], [0.0; 3]]).collect(),
            marks: pixels.iter().map(|p| Mark { cut: p.1, ..Mark::default() }).collect(),
        };
        image.add(&(0..count).collect::<Vec<_>>(), 1, &traced);
        image
    }

    const LIMIT: RadianceLimit = RadianceLimit { rgb: [1.0; 3], unbounded: None };

    #[test]
    fn upper_limits_are_those_of_closed_forms() {
        for draws in [1u32, 32, 1000] {
            for risk in [0.05f64, 0.0025] {
                let none = 1.0 - risk.powf(1.0 / f64::from(draws));
                assert!((upper_mean(0.0, draws, risk) - none).abs() < 1e-12);
                assert_eq!(upper_mean(1.0, draws, risk), 1.0);
            }
        }
        // Where the normal law holds, KL is (mu - q)^2 / (2 q (1 - q)).
        let (mean, draws) = (0.3, 1_000_000);
        let by_hand = mean + (2.0 * mean * (1.0 - mean) * -0.05f64.ln() / f64::from(draws)).sqrt();
        assert!((upper_mean(mean, draws, 0.05) - by_hand).abs() < 1e-5);
    }

    /// Images whose pixels lack anything from nothing to all that they may: the limit fails no more often than it says.
    #[test]
    fn the_limit_holds_as_often_as_it_says() {
        let mut state = 5;
        for share in [0.02, 0.2, 0.7] {
            let pixels: Vec<(f64, f64)> = (0..400).map(|_| (0.1, 0.3 * random(&mut state).powi(3))).collect();
            let shallow = image(&pixels);
            let weights = Weights::new(&shallow, &LIMIT);
            // Some lack all, the others next to nothing.
            let longer: Vec<(f64, f64)> = pixels
                .iter()
                .map(|(level, cut)| (level + if random(&mut state) < share { *cut } else { 0.01 * cut }, 0.0))
                .collect();
            let deep = image(&longer);
            let (mut most, mut real) = (0.0, 0.0);
            for (at, (level, cut)) in pixels.iter().enumerate() {
                most += cut * cut;
                real += (longer[at].0 - level).powi(2);
            }
            let (draws, risk, trials) = (64, 0.05, 2000);
            let (mut failed, mut unwarned) = (0, 0);
            for seed in 0..trials {
                let drawn = weights.draw(draws, seed);
                assert_eq!(drawn.len(), draws as usize);
                let x =
                    drawn.iter().map(|p| lacking((&shallow, *p as usize), (&deep, *p as usize), &LIMIT).0);
                let mean = x.sum::<f64>() / f64::from(draws);
                failed += u32::from(upper_mean(mean, draws, risk) < real / most);
                // The planted mistake: the mean taken for its limit.
                unwarned += u32::from(mean < real / most);
            }
            assert!(f64::from(failed) <= risk * f64::from(trials), "{share}: {failed} of {trials}");
            assert!(f64::from(unwarned) > 0.2 * f64::from(trials), "{share}: {unwarned}");
        }
    }

    /// A pixel is drawn as often as the squares of what it may lack say, each by itself.
    #[test]
    fn pixels_are_drawn_by_what_they_may_lack() {
        let shallow = image(&[(0.0, 0.0), (0.0, 0.1), (0.0, 0.2), (0.5, 0.9), (0.0, 0.0)]);
        let squares = [0.0, 0.01, 0.04, 0.25, 0.0];
        let mut counts = [0u32; 5];
        let draws = 30_000;
        Weights::new(&shallow, &LIMIT).draw(draws, 7).into_iter().for_each(|p| counts[p as usize] += 1);
        for (count, square) in counts.into_iter().zip(squares) {
            let wanted = f64::from(draws) * square / 0.3;
            assert!((f64::from(count) - wanted).abs() <= 1.0, "{counts:?}");
        }
        assert!(Weights::new(&image(&[(0.5, 0.0); 4]), &LIMIT).draw(10, 1).is_empty());
        assert!(Weights::new(&image(&[]), &LIMIT).draw(10, 1).is_empty());
    }

    #[test]
    fn what_longer_paths_lack_is_counted() {
        let shallow = image(&[(0.2, 0.4)]);
        let x = |level, cut| lacking((&shallow, 0), (&image(&[(level, cut)]), 0), &LIMIT);
        let near = |(a, b): (f64, f64), (c, d): (f64, f64)| (a - c).abs() < 1e-12 && (b - d).abs() < 1e-12;
        assert!(near(x(0.2, 0.0), (0.0, 0.0)));
        assert!(near(x(0.3, 0.0), (0.0625, 0.0)));
        assert!(near(x(0.3, 0.1), (0.25, 0.0625)));
        // Never more than all.
        assert!(near(x(0.6, 0.4), (1.0, 1.0)));
        assert!(near(x(9.0, 0.0), (1.0, 0.0)));
    }
}

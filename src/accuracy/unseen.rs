//! What no sample met: an upper bound on its part of the sum of squared errors.
//!
//! Let a_p be the share of pixel p that differs from what its samples met. All n_p samples miss it with probability
//! (1 - a_p)^n_p (stratified points: no more, by the inequality of the means; scrambled nets: assumed), so with risk
//! alpha the sum of n_p u_p, u_p = -ln(1 - a_p), is at most c = -ln(alpha): the rule of three for all pixels
//! together. The pixel as shown then errs by at most f_p = min(1, L_p a_p)^2, L_p its greatest radiance that is not
//! yet seen ([`Caps`]), at most 1 where nothing is brighter than white. There a_p errs by what the missed part differs
//! from the rest: if the rest has the value s and nothing in the pixel exceeds L_p, by no more than max(s, L_p - s). For
//! s stand the least and the greatest of the means of the pixel's sets of samples, whichever is worse; how far the rest
//! is from what they show is the error of what samples do show, which is bounded elsewhere.
//!
//! The greatest sum of f_p under that constraint: f_p(u) is convex up to the u_p* where f_p/u is greatest. Pixels
//! that could be missed up to u_p* within c are taken by the greatest f/cost first, the last of them in part (the
//! concave envelope: an upper bound). Of the others the sum is convex, so all that is left goes to one of them.
//! Envelope and convex part together are greatest where a class of pixels is exhausted.
//!
//! Mirrors and glass may show the brightest of the scene in any size: no bound on what they hide would be worth
//! stating. What they, and bright surfaces larger than a pixel, hide is taken to be no brighter than what some set of
//! samples saw in the pixels around, and no brighter than white where all samples of the pixel and its neighbours took
//! one path: their edges would be in the neighbours too. Calibration tests both assumptions; how much could be hidden
//! without them is stated beside the bound.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Where f/u is greatest for L <= 1: the root of 2u = e^u - 1.
const PEAK: f64 = 1.256_431_208_626_17;

/// What a pixel may hold unseen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cap {
    /// Greatest radiance; infinite if unbounded.
    pub radiance: f32,
    /// Greatest share of the pixel, in (0, 1].
    pub area: f32,
    /// Greatest radiance in mirrors and glass there; 0 if there are none.
    pub mirrored: f32,
}

impl Cap {
    /// Anything up to white, anywhere.
    pub const WHITE: Cap = Cap { radiance: 1.0, area: 1.0, mirrored: 0.0 };

    /// The cap under what is known of the pixel.
    pub fn given(self, known: Known) -> Cap {
        let dim = self.radiance.min(1.0);
        // What is larger than a pixel shows in the neighbours too.
        let large = if self.area >= 1.0 { self.radiance } else { 0.0 };
        let shown = large.max(self.mirrored).min(known.brightest);
        let small = self.area < 1.0 && self.radiance > 1.0;
        match small && shown <= self.radiance && !known.white {
            true => self,
            false if known.white => Cap { radiance: dim, area: 1.0, ..self },
            false => Cap { radiance: dim.max(shown), area: 1.0, ..self },
        }
    }

    /// Squared error of the pixel where `u` = -ln(1 - a) of it was missed.
    fn lost(&self, u: f64) -> f64 {
        let area = (-(-u).exp_m1()).min(f64::from(self.area));
        if area <= 0.0 { 0.0 } else { (f64::from(self.radiance) * area).min(1.0).powi(2) }
    }

    /// u*.
    fn peak(&self) -> f64 {
        let at_white = -(-1.0 / f64::from(self.radiance.max(1.0))).ln_1p();
        let at_area = -(-f64::from(self.area)).ln_1p();
        PEAK.min(at_white).min(at_area)
    }
}

/// What the samples of a pixel and its neighbours tell of what else it may hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Known {
    /// All its samples are white or brighter: whatever brighter is in it, it is shown as white.
    pub white: bool,
    /// Surfaces larger than the pixel, mirrors and glass show no more than this.
    pub brightest: f32,
    /// Least mean of a set of its samples, linear RGB.
    pub low: [f32; 3],
    /// The greatest.
    pub high: [f32; 3],
}

impl Known {
    /// Nothing.
    pub const NOTHING: Known =
        Known { white: false, brightest: f32::INFINITY, low: [0.0; 3], high: [0.0; 3] };

    /// How far a part of the pixel that no sample met can be from the rest, as shown, if it is no brighter than `radiance`:
    /// root of the mean square over the channels.
    pub fn contrast(&self, radiance: f32) -> f32 {
        let most = radiance.min(1.0);
        let apart = |c: usize| self.high[c].min(1.0).max(most - self.low[c].max(0.0));
        ((0..3).map(|c| apart(c).powi(2)).sum::<f32>() / 3.0).sqrt()
    }
}

/// Parts of a factor of two that caps are told apart by, before anything is sampled.
const COARSE: f32 = 4.0;
/// The same of what pixels may hold beside their samples, whose square the bound has: 4 % too much at most.
const FINE: f32 = 32.0;

/// Rounded up to a part of a power of two, so that few differ.
fn up(x: f32, parts: f32) -> f32 {
    if x > 0.0 && x != 1.0 { f32::exp2((x.log2() * parts).ceil() / parts) } else { x }
}

/// The caps of an image's pixels, rows from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Caps {
    list: Vec<Cap>,
    /// Index into `list` of each pixel; empty if all have the first.
    of: Vec<u16>,
}

impl Default for Caps {
    fn default() -> Caps {
        Caps::uniform(Cap::WHITE)
    }
}

impl Caps {
    /// The same cap everywhere.
    pub fn uniform(cap: Cap) -> Caps {
        Caps { list: vec![cap], of: Vec::new() }
    }

    /// Of each pixel; areas are rounded up to a power of two and radiances to a quarter of one, so that few differ.
    pub fn new(pixels: impl Iterator<Item = Cap>) -> Caps {
        let mut index: BTreeMap<[u32; 3], u16> = BTreeMap::new();
        let mut list = Vec::new();
        // Neighbours are mostly alike.
        let mut last = None;
        let of = pixels
            .map(|cap| {
                if let Some((same, at)) = last
                    && same == cap
                {
                    return at;
                }
                let own = cap;
                let mut cap = Cap {
                    area: f32::exp2(cap.area.max(f32::MIN_POSITIVE).log2().ceil()).min(1.0),
                    radiance: up(cap.radiance, COARSE),
                    mirrored: up(cap.mirrored, COARSE),
                };
                if list.len() >= usize::from(u16::MAX) {
                    // More than any image has; the worst of all is safe.
                    cap = Cap { radiance: f32::INFINITY, area: 1.0, mirrored: f32::INFINITY };
                }
                let at = *index
                    .entry([cap.radiance, cap.area, cap.mirrored].map(f32::to_bits))
                    .or_insert_with(|| {
                        list.push(cap);
                        (list.len() - 1) as u16
                    });
                last = Some((own, at));
                at
            })
            .collect();
        Caps { list, of }
    }

    /// The radiance that no more than `share` of the pixels can exceed; at most white.
    pub fn base(&self, share: f64) -> f32 {
        let mut of: Vec<f32> = match self.of.is_empty() {
            true => self.list.iter().map(|cap| cap.radiance.min(1.0)).collect(),
            false => self.of.iter().map(|at| self.list[usize::from(*at)].radiance.min(1.0)).collect(),
        };
        let at = ((1.0 - share) * (of.len() - 1) as f64).ceil() as usize;
        *of.select_nth_unstable_by(at, f32::total_cmp).1
    }

    /// Of pixel `at`.
    pub fn of(&self, at: usize) -> Cap {
        self.list[self.of.get(at).map_or(0, |i| usize::from(*i))]
    }
}

/// Pixels by their samples and caps; below white, by the [contrast](Known::contrast) they may hold.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Unseen {
    /// Samples, radiance and area (as bits): number of pixels.
    #[serde(with = "pairs")]
    pixels: BTreeMap<(u32, u32, u32), u64>,
}

/// JSON has no keys but strings.
mod pairs {
    use super::BTreeMap;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    type Pixels = BTreeMap<(u32, u32, u32), u64>;

    pub fn serialize<S: Serializer>(pixels: &Pixels, to: S) -> Result<S::Ok, S::Error> {
        pixels.iter().collect::<Vec<_>>().serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Pixels, D::Error> {
        Ok(Vec::deserialize(from)?.into_iter().collect())
    }
}

impl Unseen {
    /// Adds a pixel of `samples` samples. What is brighter than white and smaller than the pixel has a white pixel
    /// around it.
    pub fn add(&mut self, samples: u32, cap: Cap, known: Known) {
        let cap = cap.given(known);
        let mut add = |cap: Cap| {
            *self.pixels.entry((samples, cap.radiance.to_bits(), cap.area.to_bits())).or_default() += 1;
        };
        let bright = cap.radiance > 1.0;
        if !bright || cap.area < 1.0 {
            add(Cap { radiance: up(known.contrast(cap.radiance), FINE), area: 1.0, ..cap });
        }
        if bright {
            add(Cap { radiance: up(cap.radiance, FINE), ..cap });
        }
    }

    /// Adds the pixels of `other`.
    pub fn join(&mut self, other: &Unseen) {
        for (key, count) in &other.pixels {
            *self.pixels.entry(*key).or_default() += count;
        }
    }

    /// Both together.
    pub fn joined(mut self, other: Unseen) -> Unseen {
        self.join(&other);
        self
    }

    /// As many times as many pixels of each kind.
    pub fn times(mut self, times: u64) -> Unseen {
        self.pixels.values_mut().for_each(|count| *count *= times);
        self
    }

    /// Greatest radiance that some pixel may hold unseen; 0 without pixels.
    pub fn brightest(&self) -> f32 {
        self.pixels.keys().map(|(_, radiance, _)| f32::from_bits(*radiance)).fold(0.0, f32::max)
    }

    /// True if something brighter than white may be unseen.
    pub fn is_bright(&self) -> bool {
        self.pixels.keys().any(|(_, radiance, _)| f32::from_bits(*radiance) > 1.0)
    }

    /// The same with at least `least` samples in every pixel.
    pub fn raised(&self, least: u32) -> Unseen {
        let mut pixels = BTreeMap::new();
        for (&(samples, radiance, area), &count) in &self.pixels {
            *pixels.entry((samples.max(least), radiance, area)).or_default() += count;
        }
        Unseen { pixels }
    }

    /// The same with twice the samples in the pixels of `part`, which are some of these.
    pub fn with_doubled(mut self, part: &Unseen) -> Unseen {
        for (&(samples, radiance, area), &count) in &part.pixels {
            let left = self.pixels.entry((samples, radiance, area)).or_default();
            *left -= count;
            if *left == 0 {
                self.pixels.remove(&(samples, radiance, area));
            }
        }
        for (&(samples, radiance, area), &count) in &part.pixels {
            *self.pixels.entry((samples.saturating_mul(2), radiance, area)).or_default() += count;
        }
        self
    }

    /// Greatest sum of squared errors that the pixels have from what no sample met, with confidence `confidence`.
    pub fn squares(&self, confidence: f64) -> f64 {
        let all = -(-confidence).ln_1p();
        let (mut whole, mut rest) = (Vec::new(), Vec::new());
        for (&(samples, radiance, area), &count) in &self.pixels {
            let cap = Cap { radiance: f32::from_bits(radiance), area: f32::from_bits(area), mirrored: 0.0 };
            let (n, peak) = (f64::from(samples), cap.peak());
            let (cost, gain) = (n * peak, cap.lost(peak));
            if cost <= all && cost > 0.0 {
                whole.push((gain / cost, cost * count as f64));
            } else {
                rest.push((n, cap));
            }
        }
        // Everything that is left goes to one of the others.
        let one = |left: f64| rest.iter().map(|(n, cap)| cap.lost(left / n)).fold(0.0, f64::max);
        whole.sort_by(|a, b| b.0.total_cmp(&a.0));
        let (mut left, mut got, mut most) = (all, 0.0, one(all));
        for (density, supply) in whole {
            if left <= 0.0 {
                break;
            }
            let taken = left.min(supply);
            got += density * taken;
            left -= taken;
            most = f64::max(most, got + one(left));
        }
        most
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(pixels: &[(u32, Cap, u64)]) -> Unseen {
        let mut unseen = Unseen::default();
        for (samples, cap, count) in pixels {
            (0..*count).for_each(|_| unseen.add(*samples, *cap, Known::NOTHING));
        }
        unseen
    }

    #[test]
    fn the_peak_is_where_spreading_becomes_worse() {
        assert!((2.0 * PEAK - PEAK.exp_m1()).abs() < 1e-13);
        // Any division of the total is within the bound, and one is near it.
        for n in [1u32, 2, 4, 16, 64] {
            let total = -0.05f64.ln() / f64::from(n);
            let worst = (1..40)
                .map(|k| f64::from(k) * (1.0 - (-total / f64::from(k)).exp()).powi(2))
                .fold(0.0, f64::max);
            let bound = of(&[(n, Cap::WHITE, 1000)]).squares(0.95);
            assert!(worst <= bound * (1.0 + 1e-12) && worst > 0.85 * bound, "{n}: {worst} {bound}");
        }
    }

    /// The defect that this mends: a dot of 3 % of a pixel and radiance 32 errs by 0.96, not by 0.03.
    #[test]
    fn bright_things_weigh_what_they_shine() {
        let bright = Cap { radiance: 32.0, area: 1.0, mirrored: 0.0 };
        let squares = of(&[(16, bright, 1000)]).squares(0.95);
        // By hand: each pixel lost for a = 1/32 at a cost of -16 ln(1 - 1/32), of 3.0 in all.
        let by_hand = -0.05f64.ln() / (16.0 * -(-1.0f64 / 32.0).ln_1p());
        assert!((squares / by_hand - 1.0).abs() < 1e-9, "{squares} {by_hand}");
        assert!(of(&[(16, Cap::WHITE, 1000)]).squares(0.95) < 0.1 * squares);
        // One such pixel errs by no more than 1, and what is left is another's.
        let one = of(&[(16, bright, 1), (16, Cap::WHITE, 1000)]).squares(0.95);
        assert!(one > 1.0 && one < 1.03, "{one}");
        // Known to be no larger than 1e-3 of the pixel, it errs by 0.03.
        let small = Cap { radiance: 32.0, area: 1e-3, mirrored: 0.0 };
        let around = of(&[(16, Cap::WHITE, 1)]).squares(0.95);
        let squares = of(&[(16, small, 1)]).squares(0.95) - around;
        assert!(squares > 5e-4 && squares < 1.03e-3, "{squares}");
        // Shown as white already.
        let mut white = Unseen::default();
        white.add(16, bright, Known { white: true, ..Known::NOTHING });
        assert!(white.squares(0.95) < 0.03);
    }

    /// Against all ways to divide the risk among three pixels of different caps, on a grid.
    #[test]
    fn no_division_of_the_risk_is_worse() {
        let caps = [
            Cap { radiance: 5.0, area: 1.0, mirrored: 0.0 },
            Cap { radiance: 0.5, area: 1.0, mirrored: 0.0 },
            Cap { radiance: 40.0, area: 1.0, mirrored: 0.0 },
        ];
        for n in [2u32, 8, 32] {
            let total = -0.05f64.ln() / f64::from(n);
            let bound = of(&caps.map(|cap| (n, cap, 1))).squares(0.95);
            let mut worst = 0.0f64;
            for i in 0..=60 {
                for j in 0..=60 - i {
                    let u = [i, j, 60 - i - j].map(|k| f64::from(k) / 60.0 * total);
                    worst = worst.max((0..3).map(|p| caps[p].lost(u[p])).sum());
                }
            }
            assert!(worst <= bound * (1.0 + 1e-9), "{n}: {worst} {bound}");
            assert!(worst > 0.4 * bound, "{n}: {worst} {bound}");
        }
    }

    /// What is larger than a pixel is not hidden in a quiet one; what is smaller may be.
    #[test]
    fn quiet_pixels_hide_small_things_only() {
        let quiet = Known { brightest: 1.0, ..Known::NOTHING };
        let squares = |cap, known| {
            let mut unseen = Unseen::default();
            unseen.add(8, cap, known);
            unseen.squares(0.95)
        };
        let white = squares(Cap::WHITE, Known::NOTHING);
        let large = Cap { radiance: 40.0, area: 1.0, mirrored: 40.0 };
        assert_eq!(squares(large, quiet), white);
        assert!(squares(large, Known::NOTHING) > 5.0 * white);
        let small = Cap { radiance: 40.0, area: 0.05, mirrored: 0.0 };
        assert!(squares(small, quiet) > 5.0 * white);
    }

    /// Radiances as seen are of as many values as there are pixels; they are rounded up, to 2.2 % more at most.
    #[test]
    fn many_radiances_are_few_kinds_and_none_is_rounded_down() {
        let large = Cap { radiance: 1e6, ..Cap::WHITE };
        let seen = (0..20_000).map(|i| 1.0 + i as f32 / 500.0);
        let mut unseen = Unseen::default();
        seen.clone().for_each(|brightest| unseen.add(8, large, Known { brightest, ..Known::NOTHING }));
        assert!(unseen.pixels.len() < 180, "{}", unseen.pixels.len());
        for radiance in seen {
            let rounded = up(radiance, FINE);
            assert!(rounded >= radiance * (1.0 - 1e-6) && rounded < 1.023 * radiance, "{radiance} {rounded}");
        }
    }

    #[test]
    fn doubled_pixels_are_counted_once() {
        let part = of(&[(4, Cap::WHITE, 3), (8, Cap::WHITE, 2)]);
        let whole = of(&[(4, Cap::WHITE, 3), (8, Cap::WHITE, 5)]);
        assert_eq!(whole.with_doubled(&part), of(&[(8, Cap::WHITE, 6), (16, Cap::WHITE, 2)]));
    }

    #[test]
    fn raised_pixels_have_at_least_so_many_samples() {
        let few = of(&[(4, Cap::WHITE, 3), (64, Cap::WHITE, 2)]);
        assert_eq!(few.raised(16), of(&[(16, Cap::WHITE, 3), (64, Cap::WHITE, 2)]));
    }

    /// What mirrors may show counts up to what was seen.
    #[test]
    fn mirrors_hide_what_was_seen_elsewhere() {
        let mirror = Cap { mirrored: 50.0, ..Cap::WHITE };
        let squares = |seen| {
            let mut unseen = Unseen::default();
            (0..100).for_each(|_| unseen.add(8, mirror, Known { brightest: seen, ..Known::NOTHING }));
            unseen.squares(0.95)
        };
        assert_eq!(squares(0.5), of(&[(8, Cap::WHITE, 100)]).squares(0.95));
        assert!(squares(4.0) > squares(1.0) && squares(f32::INFINITY) > squares(4.0));
        assert_eq!(
            squares(f32::INFINITY),
            of(&[(8, Cap { radiance: 50.0, ..Cap::WHITE }, 100)]).squares(0.95)
        );
    }

    #[test]
    fn dark_scenes_hide_little() {
        let dark = Cap { radiance: 0.125, area: 1.0, mirrored: 0.0 };
        let ratio = of(&[(4, dark, 9)]).squares(0.95) / of(&[(4, Cap::WHITE, 9)]).squares(0.95);
        assert!((ratio - 1.0 / 64.0).abs() < 1e-6, "{ratio}");
    }

    /// Whatever the rest of a pixel is between its least and greatest set, and whatever is hidden up to the cap: the pixel
    /// errs by no more than the missed share of the contrast.
    #[test]
    fn what_is_missed_differs_by_no_more_than_the_contrast() {
        let known = Known { low: [0.2, 0.5, 0.9], high: [0.4, 0.5, 1.3], ..Known::NOTHING };
        let levels = |from: f32, to: f32| (0..=8).map(move |i| from + (to - from) * i as f32 / 8.0);
        let (mut worst, mut beyond_mean) = (0.0f32, false);
        for radiance in [0.7f32, 1.0] {
            let most = known.contrast(radiance);
            let channel = |c: usize| {
                let rest = levels(known.low[c], known.high[c].min(1.0));
                let apart = rest.flat_map(|s| levels(0.0, radiance).map(move |h| (s - h).abs()));
                apart.fold(0.0, f32::max)
            };
            let real = ((0..3).map(|c| channel(c).powi(2)).sum::<f32>() / 3.0).sqrt();
            assert!(real <= most * (1.0 + 1e-6), "{real} {most}");
            worst = worst.max(real / most);
            // The planted mistake: the mean of the sets instead of the worst.
            let middle: [f32; 3] = std::array::from_fn(|c| (known.low[c] + known.high[c]) / 2.0);
            beyond_mean |= Known { low: middle, high: middle, ..known }.contrast(radiance) < real;
        }
        assert!(worst > 0.99 && beyond_mean, "{worst}");
        // A grey pixel hides less than a black one, and a white one as much.
        let squares = |level: f32| {
            let mut unseen = Unseen::default();
            unseen.add(8, Cap::WHITE, Known { low: [level; 3], high: [level; 3], ..Known::NOTHING });
            unseen.squares(0.95)
        };
        assert!(squares(0.5) < 0.26 * squares(0.0) && squares(1.0) == squares(0.0));
    }
}

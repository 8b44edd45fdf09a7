//! Random numbers: the same on every machine.

use glam::DVec3;
use std::f64::consts::TAU;

/// A generator: SplitMix64 (Steele, Lea and Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014).
#[derive(Debug, Clone)]
pub(crate) struct Draw(u64);

impl Draw {
    /// The generator of one scene. Family, number and seed are mixed in turn, so that neighbours have nothing in common.
    pub(crate) fn new(family: &str, number: u32, seed: u64) -> Draw {
        let mut draw = Draw(seed);
        let name = family.bytes().map(u64::from);
        for word in name.chain([u64::from(number)]) {
            draw.0 = draw.word() ^ word;
        }
        draw
    }

    /// 64 random bits.
    pub(crate) fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        (self.word() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in [low, high).
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// With uniform logarithm in [low, high); both above 0.
    pub(crate) fn log(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    /// A whole number from `low` to `high`, both included, each as probable.
    pub(crate) fn whole(&mut self, low: u32, high: u32) -> u32 {
        low + (self.unit() * f64::from(high - low + 1)) as u32
    }

    /// A whole number from `low` to `high` whose logarithm is about uniform.
    pub(crate) fn count(&mut self, low: u32, high: u32) -> u32 {
        (self.log(f64::from(low), f64::from(high) + 1.0) as u32).clamp(low, high)
    }

    /// True with this probability.
    pub(crate) fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// One of `choices`.
    pub(crate) fn of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.whole(0, choices.len() as u32 - 1) as usize]
    }

    /// A sign: -1 or 1.
    pub(crate) fn sign(&mut self) -> f64 {
        if self.chance(0.5) { 1.0 } else { -1.0 }
    }

    /// Each coordinate uniform in its range.
    pub(crate) fn inside(&mut self, low: [f64; 3], high: [f64; 3]) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|i| self.between(low[i], high[i])))
    }

    /// A colour whose channels lie in the range; grey in one draw of three.
    pub(crate) fn color(&mut self, low: f64, high: f64) -> [f64; 3] {
        match self.chance(1.0 / 3.0) {
            true => [self.between(low, high); 3],
            false => std::array::from_fn(|_| self.between(low, high)),
        }
    }

    /// A unit vector in the plane of two perpendicular unit vectors.
    pub(crate) fn direction(&mut self, right: DVec3, up: DVec3) -> DVec3 {
        let angle = self.between(0.0, TAU);
        right * angle.cos() + up * angle.sin()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// First outputs of the reference implementation with seed 1234567.
    #[test]
    fn words_are_those_of_splitmix64() {
        let mut draw = Draw(1_234_567);
        let words = [draw.word(), draw.word(), draw.word()];
        assert_eq!(words, [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423]);
    }

    #[test]
    fn draws_stay_in_their_ranges_and_reach_them() {
        let mut draw = Draw::new("wires", 0, 1);
        let whole: Vec<u32> = (0..200).map(|_| draw.whole(2, 5)).collect();
        assert!((2..=5).all(|n| whole.contains(&n)) && whole.iter().all(|n| (2..=5).contains(n)));
        assert!((0..200).all(|_| (0.01..100.0).contains(&draw.log(0.01, 100.0))));
        assert!((0..200).all(|_| (3..=40).contains(&draw.count(3, 40))));
        assert!((0..50).all(|_| (draw.direction(DVec3::X, DVec3::Z).length() - 1.0).abs() < 1e-12));
    }
}

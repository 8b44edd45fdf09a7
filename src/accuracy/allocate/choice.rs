//! Which classes to double next, and whether that is worth its price.

use super::Allocation;
use super::class::Class;
use crate::accuracy::sampling::{Noise, RATE_MOST, joined};
use crate::accuracy::unseen::Unseen;

/// Rays for each pixel of the image that it may cost to exclude what is brighter than white. Beyond that the promise is
/// refused, and the image gets what the rest of its error asks for, up to [`REFUSED_PRICE`].
const PRICE: f64 = 16384.0;

/// Rays of each pixel once the promise is refused: what is too bright to be excluded is also too bright to be averaged
/// out, and a picture without its promise is not worth minutes.
const REFUSED_PRICE: f64 = 1024.0;
/// But no fewer samples than this, for it is to show something.
const REFUSED_LEAST: u32 = 16;

/// What all classes say together.
pub(super) struct Present {
    pub(super) noise: Noise,
    /// What the variance is multiplied by to be safe.
    pub(super) factor: f64,
    pub(super) unseen: Unseen,
    /// Greatest sum of squared errors from what no sample met.
    pub(super) hidden: f64,
    /// Upper limit of the sum of squared errors.
    pub(super) squares: f64,
}

impl Present {
    pub(super) fn of(allocation: &Allocation) -> Present {
        let (noise, unseen) = (allocation.noise(), allocation.unseen());
        let confidence = allocation.goal.confidence;
        let (_, factor) = noise.factor(allocation.gathered.replicates, confidence);
        let hidden = if allocation.refused.is_some() { 0.0 } else { unseen.squares(confidence) };
        Present { noise, factor, hidden, squares: joined(noise.variance(), factor, hidden), unseen }
    }
}

/// What a class would gain by doubling the rest of it.
pub(super) struct Candidate {
    pub(super) class: usize,
    pub(super) pixels: usize,
    pub(super) samples: u32,
    /// Fall of the squared error.
    pub(super) drop: f64,
    /// Rays.
    pub(super) cost: f64,
}

impl Allocation {
    /// Upper limit of the sum of squared errors if the rest of each of `classes`, in ascending order, is doubled.
    fn after(&self, present: &Present, classes: &[usize]) -> f64 {
        let variance = present.noise.variance();
        let share = variance / present.noise.squares.max(f64::MIN_POSITIVE);
        let (mut unseen, mut fall) = (present.unseen.clone(), 0.0);
        for c in classes.iter().map(|class| &self.classes[*class]) {
            unseen = unseen.with_doubled(&c.unseen[1]);
            fall += c.noise[1].squares * (1.0 - c.doubled);
        }
        let hidden = if self.refused.is_some() { 0.0 } else { unseen.squares(self.goal.confidence) };
        joined(variance - share * fall, present.factor, hidden)
    }

    /// Classes that can be doubled, most gain per ray first.
    pub(super) fn candidates(&self, present: &Present) -> Vec<Candidate> {
        let mut all: Vec<Candidate> = (self.classes.iter().enumerate())
            .filter(|(_, c)| c.can_double(&self.goal))
            .map(|(class, c)| {
                let pixels = c.pixels.len() - c.ahead;
                Candidate {
                    class,
                    pixels,
                    samples: c.samples,
                    drop: present.squares - self.after(present, &[class]),
                    cost: c.rays * pixels as f64 * f64::from(c.samples),
                }
            })
            .collect();
        all.sort_by(|a, b| (b.drop / b.cost).total_cmp(&(a.drop / a.cost)));
        all
    }

    /// Classes to double together where that gains more per ray than any of them alone, because what no sample met
    /// weighs most: classes of equal samples whose pixels may hold a radiance of some least value or more.
    pub(super) fn lift(&self, present: &Present, candidates: &[Candidate]) -> Option<Vec<usize>> {
        if self.refused.is_some() {
            return None;
        }
        let mut best: Option<(f64, Vec<usize>)> = None;
        let radiance = |c: &Candidate| self.classes[c.class].brightest();
        let mut kinds: Vec<(u32, f32)> = candidates.iter().map(|c| (c.samples, radiance(c))).collect();
        kinds.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
        kinds.dedup();
        for (samples, least) in kinds {
            let able = |c: &&Candidate| c.samples == samples && radiance(c) >= least;
            let those: Vec<&Candidate> = candidates.iter().filter(able).collect();
            let mut classes: Vec<usize> = those.iter().map(|c| c.class).collect();
            classes.sort_unstable();
            let cost: f64 = those.iter().map(|c| c.cost).sum();
            let gain = (present.squares - self.after(present, &classes)) / cost;
            if best.as_ref().is_none_or(|b| gain > b.0) {
                best = Some((gain, classes));
            }
        }
        let alone = candidates.first().map_or(0.0, |c| c.drop / c.cost);
        best.filter(|(gain, _)| *gain > alone).map(|(_, classes)| classes)
    }

    /// True if the most samples that a pixel may have would not reach the target, were all samples as good as along edges;
    /// `unseen`: what no sample met is reckoned with.
    pub(super) fn is_out_of_reach(&self, unseen: bool) -> bool {
        let Some(target) = self.goal.target else { return false };
        let (pixels, most) = (self.gathered.samples.len() as f64, f64::from(self.goal.most));
        let noise = self.noise();
        let (_, factor) = noise.factor(self.gathered.replicates, self.goal.confidence);
        let variance = noise.variance() * RATE_MOST.powf((f64::from(self.goal.pilot) / most).log2());
        let hidden = || self.unseen().raised(self.goal.most).squares(self.goal.confidence);
        joined(variance, factor, if unseen { hidden() } else { 0.0 }) > target * target * pixels
    }

    /// Most samples of a pixel once the promise is refused.
    pub(super) fn refused_most(&self) -> u32 {
        let each = self.rays() as f64 / self.samples().max(1) as f64;
        let samples = (REFUSED_PRICE / each.max(1.0)).log2().floor().exp2() as u32;
        samples.max(REFUSED_LEAST).clamp(self.goal.pilot, self.goal.most)
    }

    /// True if samples that exclude enough of what is brighter than white cost more than [`PRICE`].
    pub(super) fn is_too_dear(&self) -> bool {
        let Some(target) = self.goal.target else { return false };
        let pixels = self.gathered.samples.len() as f64;
        let bright: Vec<&Class> = self.classes.iter().filter(|c| c.is_bright()).collect();
        if bright.is_empty() {
            return false;
        }
        let unseen = self.unseen();
        let mut samples = self.goal.pilot;
        while unseen.raised(samples).squares(self.goal.confidence) > target * target * pixels {
            if samples > self.goal.most / 2 {
                return true;
            }
            samples *= 2;
        }
        let rays = bright.iter().map(|c| c.rays * c.pixels.len() as f64).sum::<f64>();
        rays * f64::from(samples) > PRICE * pixels
    }
}

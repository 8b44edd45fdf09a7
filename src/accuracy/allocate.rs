//! Which pixels get how many samples: the sampling error asked for with the fewest rays, or the least error
//! for the rays there are.
//!
//! Stopping on the very samples that are averaged is biased (Kirk and Arvo, "Unbiased Sampling Techniques
//! for Image Synthesis", SIGGRAPH 1991): a pixel whose first samples agree by chance is left as it is. Here
//! no pixel's sample decides on that pixel alone. A pilot samples all pixels alike; each pixel's *class* is
//! read from the pilot samples of its eight neighbours, never its own; and a class of at least
//! `LEAST_CLASS` pixels is sampled as a whole, by its pooled variance. The last step takes as many of a
//! class as the target needs, in an order fixed by a hash of the pixel's number.
//!
//! Each step doubles where the bound falls most per ray (Neyman's rule, taken greedily), so that a prefix of
//! the work is the best use of a prefix of the time.

mod choice;
mod class;
mod goal;

pub use goal::Goal;

use super::pieces;
use super::pixel_order;
use super::pixel_sums::PixelSums;
use super::sampling::{Noise, SamplingBound};
use super::unseen::{Caps, Unseen};
use crate::render::samples::{Source, Traced};
use choice::{Candidate, Present};
use class::Class;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// A class joins a step that another leads if it gains at least this much as much per ray: the leader's own
/// next doubling would gain `DOUBLED / 2`.
const JOINS: f64 = 0.3;

/// Samples of a class that a step has at least: fewer take a device as long.
const STEP_SAMPLES: usize = 256;

/// Samples to trace next. Give it back to [`Allocation::record`] with what came of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// Pixels `y * width + x`.
    pub pixels: Vec<u32>,
    /// Samples of each.
    pub samples: Range<u32>,
    /// Parts of classes it consists of: class and how many pixels, those recorded before included; none in
    /// the pilot.
    parts: Vec<(usize, usize)>,
}

/// Why a target is given up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Refusal {
    /// To exclude what no sample met takes more samples than the image is worth.
    TooDear,
    /// The most samples that pixels may have would not get there.
    OutOfReach,
}

/// Why there is no next step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Outcome {
    /// The bound is at the target.
    Reached,
    /// Every pixel that errs has as many samples as a pixel may have.
    Capped,
    /// There is more to do.
    Unfinished,
}

/// The state of an adaptive render: all that was traced, and what to trace next. Deterministic.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Allocation {
    height: u32,
    goal: Goal,
    gathered: PixelSums,
    /// Empty until the pilot is done.
    classes: Vec<Class>,
    /// Samples that every pixel has from the rounds of the pilot that are done.
    round: u32,
    /// Pixels of this round that are done: the first of [`pixel_order::order`].
    piloted: usize,
    /// What is left of a step that was cut short.
    open: Option<Step>,
    /// Why the target is given up: what no sample met is then left out of all choices.
    refused: Option<Refusal>,
    /// What each pixel may hold unseen.
    #[serde(skip)]
    caps: Caps,
}

impl Allocation {
    /// Nothing traced yet.
    pub fn new(width: u32, height: u32, replicates: usize, goal: Goal, caps: Caps) -> Allocation {
        let gathered = PixelSums::new(width, height, replicates);
        Allocation {
            height,
            goal,
            gathered,
            classes: Vec::new(),
            round: 0,
            piloted: 0,
            open: None,
            refused: None,
            caps,
        }
    }

    /// The state after the pilot whose samples are `gathered`.
    pub fn piloted(gathered: PixelSums, goal: Goal, caps: Caps) -> Allocation {
        let round = goal.pilot;
        let nothing = Allocation::new(gathered.width, 0, gathered.replicates, goal, caps);
        Allocation { height: gathered.height(), gathered, round, ..nothing }
    }

    /// What is asked for.
    pub fn goal(&self) -> Goal {
        self.goal
    }

    /// Asks for another sampling error than before.
    pub fn aim_at(&mut self, target: f64) {
        self.goal.target = Some(target);
    }

    /// All samples so far.
    pub fn gathered(&self) -> &PixelSums {
        &self.gathered
    }

    /// Hands the samples out, to be kept elsewhere, and forgets the caps; they must be [put back](Allocation::put_gathered) before
    /// anything else is done.
    pub fn take_gathered(&mut self) -> PixelSums {
        self.caps = Caps::default();
        let nothing = PixelSums::new(self.gathered.width, 0, self.gathered.replicates);
        std::mem::replace(&mut self.gathered, nothing)
    }

    /// Takes back what [`Allocation::take_gathered`] gave; false if it is of another image.
    pub fn put_gathered(&mut self, gathered: PixelSums, caps: Caps) -> bool {
        self.caps = caps;
        let fits = gathered.width == self.gathered.width
            && gathered.replicates == self.gathered.replicates
            && gathered.samples.len() as u64 == u64::from(gathered.width) * u64::from(self.height);
        self.gathered = gathered;
        fits && self.is_sound()
    }

    /// True if all pixels and classes that are named are there: what was read from a file need not be so.
    fn is_sound(&self) -> bool {
        let all = self.gathered.samples.len();
        let within = |pixels: &[u32]| pixels.iter().all(|p| (*p as usize) < all);
        let class = |c: &Class| within(&c.pixels) && c.ahead <= c.pixels.len() && c.samples > 0;
        let step = |s: &Step| {
            let parts = s.parts.iter().all(|(class, _)| *class < self.classes.len());
            within(&s.pixels) && parts && s.samples.start < s.samples.end
        };
        let numbers = self.piloted <= all && self.round <= 1 << 30 && self.goal.first > 0;
        numbers && self.classes.iter().all(class) && self.open.iter().all(step)
    }

    /// True while a step that was cut short waits to be completed.
    pub fn is_open(&self) -> bool {
        self.open.is_some()
    }

    /// The sampling bound of the image as it is; `None` until every pixel has its pilot.
    pub fn bound(&self) -> Option<SamplingBound> {
        let bound = || {
            let unseen = self.unseen().squares(self.goal.confidence);
            self.noise().bound(self.gathered.replicates, self.goal.confidence, unseen)
        };
        (!self.classes.is_empty()).then(bound)
    }

    /// Samples traced.
    pub fn samples(&self) -> u64 {
        self.gathered.total()
    }

    /// Rays traced.
    pub fn rays(&self) -> u64 {
        pieces::total(self.gathered.marks.len(), |at| u64::from(self.gathered.marks[at].rays))
    }

    /// Whether there is more to do.
    pub fn outcome(&self) -> Outcome {
        let seen = |bound: SamplingBound| match self.refused.is_some() {
            true => self.noise().bound(self.gathered.replicates, self.goal.confidence, 0.0),
            false => bound,
        };
        match self.bound().map(seen) {
            Some(b) if self.goal.target.is_some_and(|target| b.bound <= target) => Outcome::Reached,
            Some(_) if !self.classes.iter().any(|c| c.can_double(&self.goal)) => Outcome::Capped,
            _ => Outcome::Unfinished,
        }
    }

    /// What to trace next with at most `budget` rays, as far as they can be foretold from those traced
    /// (`f64::INFINITY` for no limit). `None` at the end ([`Allocation::outcome`]), or where the
    /// budget is too small for any sample. A step that was cut short is completed first, at any cost.
    pub fn next_step(&mut self, budget: f64) -> Option<Step> {
        if let Some(open) = &self.open {
            return Some(open.clone());
        }
        self.decide();
        if self.classes.is_empty() {
            return self.pilot_step(budget);
        }
        if self.outcome() != Outcome::Unfinished {
            return None;
        }
        let present = Present::of(self);
        let mut candidates = self.candidates(&present);
        let lift = self.lift(&present, &candidates);
        if let Some(lifted) = &lift {
            candidates.retain(|c| lifted.contains(&c.class));
        }
        let leader = candidates.first()?;
        let samples = leader.samples;
        let joins = |c: &&Candidate| {
            c.samples == samples && (lift.is_some() || c.drop * leader.cost >= JOINS * leader.drop * c.cost)
        };
        let bound = present.noise.bound(self.gathered.replicates, self.goal.confidence, present.hidden).bound;
        let mut need = match self.goal.target {
            Some(target) if lift.is_none() => {
                (bound * bound - target * target) * self.gathered.samples.len() as f64
            }
            _ => f64::INFINITY,
        };
        let mut budget = budget;
        let mut step = Step { pixels: Vec::new(), samples: samples..2 * samples, parts: Vec::new() };
        for c in candidates.iter().filter(joins) {
            if need <= 0.0 {
                break;
            }
            // One in 64 at least, or the last steps would be endless.
            let share = if c.drop > need { (need / c.drop).max(1.0 / 64.0) } else { 1.0 };
            let each = c.cost / c.pixels as f64;
            let least = (STEP_SAMPLES / c.samples as usize).min(c.pixels) as f64;
            let wanted = (share * c.pixels as f64).ceil().max(least).min((budget / each).floor()) as usize;
            if wanted == 0 {
                break;
            }
            let class = &self.classes[c.class];
            step.pixels.extend(&class.pixels[class.ahead..class.ahead + wanted]);
            step.parts.push((c.class, wanted));
            need -= c.drop * wanted as f64 / c.pixels as f64;
            budget -= each * wanted as f64;
        }
        (!step.pixels.is_empty()).then_some(step)
    }

    /// True once every pixel has samples.
    pub fn is_covered(&self) -> bool {
        self.round > 0
    }

    /// Sorts the pixels into classes, once every pixel has its pilot; [`Allocation::next_step`] does so too.
    pub fn decide(&mut self) {
        if !self.classes.is_empty() || self.round < self.goal.pilot {
            return;
        }
        self.gathered.fix_brightest();
        self.classes = class::classify(&self.gathered, &self.caps, &self.goal);
        self.refused = if self.is_out_of_reach(false) {
            Some(Refusal::OutOfReach)
        } else if self.is_too_dear() {
            Some(Refusal::TooDear)
        } else {
            self.is_out_of_reach(true).then_some(Refusal::OutOfReach)
        };
        if self.refused.is_some() {
            self.goal.most = self.refused_most();
        }
    }

    fn pilot_step(&self, budget: f64) -> Option<Step> {
        let left = self.gathered.samples.len() - self.piloted;
        let rays = if self.samples() > 0 { self.rays() as f64 / self.samples() as f64 } else { 1.0 };
        let samples = if self.round == 0 { 0..self.goal.first } else { self.round..2 * self.round };
        let each = f64::from(samples.end - samples.start);
        let wanted = (budget / (rays * each)).floor().min(left as f64) as usize;
        let places = self.piloted..self.piloted + wanted;
        let pixels = pixel_order::order(self.gathered.width, self.height, places);
        (!pixels.is_empty()).then_some(Step { pixels, samples, parts: Vec::new() })
    }

    /// Takes in what came of `step`: of all its pixels, or of the first of them if it was cut short. Nothing is
    /// decided until the rest follows, so that the image does not depend on where it was cut.
    pub fn record(&mut self, step: &Step, traced: &Traced) {
        let there = traced.marks.len().min(step.pixels.len());
        self.gathered.add(&step.pixels, step.samples.end - step.samples.start, traced);
        if self.classes.is_empty() {
            self.piloted += there;
            if self.piloted == self.gathered.samples.len() {
                (self.round, self.piloted) = (step.samples.end, 0);
            }
            return;
        }
        if there < step.pixels.len() {
            self.open = Some(Step { pixels: step.pixels[there..].to_vec(), ..step.clone() });
            return;
        }
        self.open = None;
        let apart = self.compared_apart(step);
        for &(class, pixels) in &step.parts {
            self.advance(class, pixels);
        }
        for class in apart {
            self.classes[class].measure(&self.gathered, &self.caps);
        }
    }

    /// Classes that `step` does not name of which a pixel of one sample has its pair in the step. They are few: pairs are of one class
    /// but where classes were merged.
    fn compared_apart(&self, step: &Step) -> Vec<usize> {
        let named = |class: usize| step.parts.iter().any(|part| part.0 == class);
        let single = |class: &usize| self.classes[*class].samples == 1 && !named(*class);
        let singles: Vec<usize> = (0..self.classes.len()).filter(single).collect();
        if singles.is_empty() {
            return singles;
        }
        let mut doubled = vec![false; self.gathered.samples.len()];
        for &(class, pixels) in &step.parts {
            let class = &self.classes[class];
            class.pixels.iter().skip(class.ahead).take(pixels).for_each(|p| doubled[*p as usize] = true);
        }
        let pair = |p: &u32| self.gathered.pair_of(*p as usize).is_some_and(|q| doubled[q]);
        singles.into_iter().filter(|class| self.classes[*class].pixels.par_iter().any(pair)).collect()
    }

    fn advance(&mut self, class: usize, pixels: usize) {
        let mut c = std::mem::take(&mut self.classes[class]);
        let before = c.noise[1].squares;
        c.ahead += pixels;
        if c.ahead == c.pixels.len() {
            let whole = c.noise[0].squares + before;
            // The part that was ahead before had doubled already: compare like with like.
            let fresh = c.ahead == pixels;
            (c.ahead, c.samples) = (0, 2 * c.samples);
            c.measure(&self.gathered, &self.caps);
            if fresh && whole > 0.0 {
                c.doubled = (c.noise[1].squares / whole).clamp(0.15, 0.7);
            }
        } else {
            c.measure(&self.gathered, &self.caps);
        }
        self.classes[class] = c;
    }

    fn noise(&self) -> Noise {
        self.classes.iter().flat_map(|c| c.noise).sum()
    }

    fn unseen(&self) -> Unseen {
        let mut all = Unseen::default();
        self.classes.iter().flat_map(|c| &c.unseen).for_each(|part| all.join(part));
        all
    }

    /// Why the target was given up after the pilot, if it was.
    pub fn refused(&self) -> Option<Refusal> {
        self.refused
    }
}

/// Traces until the goal is met, the cap is reached, or `go_on` says no after a step.
///
/// # Errors
/// Whatever the tracer reports; what was recorded before stays.
pub fn run<S: Source>(
    allocation: &mut Allocation,
    source: &mut S,
    mut go_on: impl FnMut(&Allocation) -> bool,
) -> Result<Outcome, S::Error> {
    while let Some(step) = allocation.next_step(f64::INFINITY) {
        let traced = source.trace(&step.pixels, step.samples.clone())?;
        allocation.record(&step, &traced);
        if !go_on(allocation) {
            break;
        }
    }
    Ok(allocation.outcome())
}

#[cfg(test)]
mod tests;

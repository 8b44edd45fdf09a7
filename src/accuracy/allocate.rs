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

use super::pixel_order;
use super::pixel_sums::PixelSums;
use super::sampling::{Noise, SamplingBound, joined};
use super::unseen::{Cap, Caps, Known, Unseen};
use crate::render::samples::{Source, Traced};
use crate::settings::sampler::pcg4d;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ops::Range;

/// Fewest pixels of a class, so that one pixel's samples weigh little in its class's.
const LEAST_CLASS: usize = 64;

/// What doubling leaves of a class's squared error, before it was seen to: between 1/2 (random) and 2^-1.5
/// (stratified, edges; Mitchell, SIGGRAPH 1996).
const DOUBLED: f64 = 0.42;

/// Fewest samples of every pixel: their difference is all that is known of its error.
const LEAST_PILOT: u32 = 2;

/// Share of the squared target that may be unseen after the pilot.
const PILOT_UNSEEN: f64 = 0.5;

/// Samples for each pixel of the image that it may cost to exclude what is brighter than white. Beyond that the promise is
/// refused, and the image gets what the rest of its error asks for, up to [`REFUSED_MOST`].
const PRICE: f64 = 4096.0;

/// Most samples of a pixel once the promise is refused: what is too bright to be excluded is also too bright to be averaged
/// out, and a picture without its promise is not worth minutes.
const REFUSED_MOST: u32 = 256;

/// A class joins a step that another leads if it gains at least this much as much per ray: the leader's own
/// next doubling would gain `DOUBLED / 2`.
const JOINS: f64 = 0.3;

/// What is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Goal {
    /// Greatest RMSE; `None` to go on while there is budget.
    pub target: Option<f64>,
    /// With this confidence.
    pub confidence: f64,
    /// Samples of every pixel in the first round.
    pub first: u32,
    /// Samples of every pixel before any gets more than others: `first` doubled some times.
    pub pilot: u32,
    /// Most samples of a pixel.
    pub most: u32,
}

impl Goal {
    /// A goal whose pilot leaves at most `PILOT_UNSEEN` of the target to what no sample met in pixels that hold nothing
    /// brighter than white; `most` permitting.
    pub fn for_target(target: f64, confidence: f64, pixels: usize, caps: &Caps, most: u32) -> Goal {
        let mut pilot = LEAST_PILOT;
        let allowed = PILOT_UNSEEN * target * target * pixels as f64;
        let base = Cap { radiance: caps.base(), ..Cap::WHITE };
        let unseen = |samples| {
            let mut one = Unseen::default();
            one.add(samples, base, Known::NOTHING);
            one.squares(confidence)
        };
        while pilot <= most / 2 && unseen(pilot) > allowed {
            pilot *= 2;
        }
        Goal { target: Some(target), confidence, first: pilot, pilot, most: most.max(pilot) }
    }
}

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

/// Pixels whose neighbourhoods look alike.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Class {
    /// In the order they are taken.
    pixels: Vec<u32>,
    /// The first `ahead` of them have `2 * samples`, the rest `samples`.
    ahead: usize,
    samples: u32,
    /// Noise of those ahead, and of the rest.
    noise: [Noise; 2],
    /// The same pixels by what they may hold unseen.
    unseen: [Unseen; 2],
    /// What doubling leaves of the squared error.
    doubled: f64,
    /// Rays of one sample.
    rays: f64,
}

impl Class {
    /// True if a pixel of the rest may hold something brighter than white.
    fn is_bright(&self) -> bool {
        self.unseen[1].is_bright()
    }
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
    /// True if what no sample met is not worth its price: it is then left out of all choices.
    refused: bool,
    /// What each pixel may hold unseen.
    #[serde(skip)]
    caps: Caps,
}

/// What all classes say together.
struct Present {
    noise: Noise,
    /// What the variance is multiplied by to be safe.
    factor: f64,
    unseen: Unseen,
    /// Greatest sum of squared errors from what no sample met.
    hidden: f64,
    /// Upper limit of the sum of squared errors.
    squares: f64,
}

impl Present {
    fn of(allocation: &Allocation) -> Present {
        let (noise, unseen) = (allocation.noise(), allocation.unseen());
        let confidence = allocation.goal.confidence;
        let (_, factor) = noise.factor(allocation.gathered.replicates, confidence);
        let hidden = if allocation.refused { 0.0 } else { unseen.squares(confidence) };
        Present { noise, factor, hidden, squares: joined(noise.variance(), factor, hidden), unseen }
    }
}

/// What a class would gain by doubling the rest of it.
struct Candidate {
    class: usize,
    pixels: usize,
    samples: u32,
    /// Fall of the squared error.
    drop: f64,
    /// Rays.
    cost: f64,
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
            refused: false,
            caps,
        }
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
        self.gathered.samples.iter().map(|&n| u64::from(n)).sum()
    }

    /// Rays traced.
    pub fn rays(&self) -> u64 {
        self.gathered.marks.iter().map(|m| u64::from(m.rays)).sum()
    }

    /// Whether there is more to do.
    pub fn outcome(&self) -> Outcome {
        let seen = |bound: SamplingBound| match self.refused {
            true => self.noise().bound(self.gathered.replicates, self.goal.confidence, 0.0),
            false => bound,
        };
        match self.bound().map(seen) {
            Some(b) if self.goal.target.is_some_and(|target| b.bound <= target) => Outcome::Reached,
            Some(_) if !self.classes.iter().any(|c| self.can_double(c)) => Outcome::Capped,
            _ => Outcome::Unfinished,
        }
    }

    /// What to trace next with at most `budget` rays, as far as they can be foretold from those traced
    /// (`f64::INFINITY` for no limit). `None` at the end ([`Allocation::outcome`]), or where the
    /// budget is too small for any sample. A step that was cut short is completed first, at any cost.
    pub fn next_step(&self, budget: f64) -> Option<Step> {
        if let Some(open) = &self.open {
            return Some(open.clone());
        }
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
            let wanted = (share * c.pixels as f64).ceil().min((budget / each).floor()) as usize;
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

    fn pilot_step(&self, budget: f64) -> Option<Step> {
        let left = self.gathered.samples.len() - self.piloted;
        let rays = if self.samples() > 0 { self.rays() as f64 / self.samples() as f64 } else { 1.0 };
        let samples = if self.round == 0 { 0..self.goal.first } else { self.round..2 * self.round };
        let each = f64::from(samples.end - samples.start);
        let wanted = (budget / (rays * each)).floor().min(left as f64) as usize;
        let order = pixel_order::order(self.gathered.width, self.height);
        let pixels = order[self.piloted..self.piloted + wanted].to_vec();
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
                if self.round >= self.goal.pilot {
                    self.classify();
                }
            }
            return;
        }
        if there < step.pixels.len() {
            self.open = Some(Step { pixels: step.pixels[there..].to_vec(), ..step.clone() });
            return;
        }
        self.open = None;
        for &(class, pixels) in &step.parts {
            self.advance(class, pixels);
        }
    }

    fn advance(&mut self, class: usize, pixels: usize) {
        let mut c = self.classes[class].clone();
        let before = c.noise[1].squares;
        c.ahead += pixels;
        if c.ahead == c.pixels.len() {
            let whole = c.noise[0].squares + before;
            // The part that was ahead before had doubled already: compare like with like.
            let fresh = c.ahead == pixels;
            (c.ahead, c.samples) = (0, 2 * c.samples);
            self.measure(&mut c);
            if fresh && whole > 0.0 {
                c.doubled = (c.noise[1].squares / whole).clamp(0.15, 0.7);
            }
        } else {
            self.measure(&mut c);
        }
        self.classes[class] = c;
    }

    /// Noise and cost of a class from what its pixels have.
    fn measure(&self, class: &mut Class) {
        let parts = [&class.pixels[..class.ahead], &class.pixels[class.ahead..]];
        class.noise = parts.map(|pixels| pixels.iter().map(|p| self.gathered.noise_of(*p as usize)).sum());
        class.unseen = parts.map(|pixels| {
            let mut unseen = Unseen::default();
            for p in pixels.iter().map(|p| *p as usize) {
                let known = self.gathered.known_of(p);
                unseen.add(self.gathered.samples[p], self.caps.of(p), known);
            }
            unseen
        });
        let rays: u64 = class.pixels.iter().map(|&p| u64::from(self.gathered.marks[p as usize].rays)).sum();
        let samples: u64 = class.pixels.iter().map(|&p| u64::from(self.gathered.samples[p as usize])).sum();
        class.rays = rays as f64 / samples as f64;
    }

    fn noise(&self) -> Noise {
        self.classes.iter().flat_map(|c| c.noise).sum()
    }

    fn unseen(&self) -> Unseen {
        let mut all = Unseen::default();
        self.classes.iter().flat_map(|c| &c.unseen).for_each(|part| all.join(part));
        all
    }

    /// Upper limit of the sum of squared errors if the rest of each of `classes`, in ascending order, is doubled.
    fn after(&self, present: &Present, classes: &[usize]) -> f64 {
        let variance = present.noise.variance();
        let share = variance / present.noise.squares.max(f64::MIN_POSITIVE);
        let (mut unseen, mut fall) = (present.unseen.clone(), 0.0);
        for c in classes.iter().map(|class| &self.classes[*class]) {
            unseen = unseen.with_doubled(&c.unseen[1]);
            fall += c.noise[1].squares * (1.0 - c.doubled);
        }
        let hidden = if self.refused { 0.0 } else { unseen.squares(self.goal.confidence) };
        joined(variance - share * fall, present.factor, hidden)
    }

    /// True if the promise was refused for what no sample met.
    pub fn is_refused(&self) -> bool {
        self.refused
    }

    fn can_double(&self, class: &Class) -> bool {
        class.samples <= self.goal.most / 2
    }

    /// Classes that can be doubled, most gain per ray first.
    fn candidates(&self, present: &Present) -> Vec<Candidate> {
        let mut all: Vec<Candidate> = (self.classes.iter().enumerate())
            .filter(|(_, c)| self.can_double(c))
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
    /// weighs most: all of the fewest samples, or those of them that may hold something bright.
    fn lift(&self, present: &Present, candidates: &[Candidate]) -> Option<Vec<usize>> {
        if self.refused {
            return None;
        }
        let mut best: Option<(f64, Vec<usize>)> = None;
        for bright in [true, false] {
            let able = || candidates.iter().filter(|c| !bright || self.classes[c.class].is_bright());
            let Some(least) = able().map(|c| c.samples).min() else { continue };
            let low: Vec<&Candidate> = able().filter(|c| c.samples == least).collect();
            let mut classes: Vec<usize> = low.iter().map(|c| c.class).collect();
            classes.sort_unstable();
            let cost: f64 = low.iter().map(|c| c.cost).sum();
            let gain = (present.squares - self.after(present, &classes)) / cost;
            if best.as_ref().is_none_or(|b| gain > b.0) {
                best = Some((gain, classes));
            }
        }
        let alone = candidates.first().map_or(0.0, |c| c.drop / c.cost);
        best.filter(|(gain, _)| *gain > alone).map(|(_, classes)| classes)
    }

    /// True if samples that exclude enough of what is brighter than white cost more than [`PRICE`].
    fn is_too_dear(&self) -> bool {
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
        let (all, some) =
            (self.rays() as f64, bright.iter().map(|c| c.rays * c.pixels.len() as f64).sum::<f64>());
        some * f64::from(samples) > PRICE * all / f64::from(self.goal.pilot)
    }

    /// Sorts the pixels into classes by their neighbours.
    fn classify(&mut self) {
        self.gathered.fix_brightest();
        let noise: Vec<f64> =
            (0..self.gathered.samples.len()).map(|p| self.gathered.noise_of(p).squares).collect();
        let image: Vec<[f64; 3]> = (0..noise.len()).map(|p| self.gathered.mean(p)).collect();
        let mut groups: BTreeMap<(bool, u8, i32), Vec<u32>> = BTreeMap::new();
        for p in 0..self.gathered.samples.len() as u32 {
            let (kind, level) = self.look_around(p, &noise, &image);
            let cap = self.caps.of(p as usize).given(self.gathered.known_of(p as usize));
            let bright = cap.radiance > 1.0;
            groups.entry((bright, kind, level)).or_default().push(p);
        }
        // Small groups join the next, the last the one before it.
        let mut merged: Vec<Vec<u32>> = Vec::new();
        for group in groups.into_values() {
            match merged.last_mut() {
                Some(last) if last.len() < LEAST_CLASS => last.extend(group),
                _ => merged.push(group),
            }
        }
        if merged.len() > 1 && merged[merged.len() - 1].len() < LEAST_CLASS {
            let last = merged.pop().unwrap_or_default();
            let end = merged.len() - 1;
            merged[end].extend(last);
        }
        self.classes = merged
            .into_iter()
            .map(|mut pixels| {
                pixels.sort_by_key(|&p| (pcg4d([p, 0x0a11, 0x0ca7, 0xe000])[0], p));
                let samples = self.goal.pilot;
                let (noise, unseen) = ([Noise::default(); 2], Default::default());
                let mut class =
                    Class { pixels, ahead: 0, samples, noise, unseen, doubled: DOUBLED, rays: 1.0 };
                self.measure(&mut class);
                class
            })
            .collect();
        self.refused = self.is_too_dear();
        if self.refused {
            self.goal.most = self.goal.most.min(REFUSED_MOST).max(self.goal.pilot);
        }
    }

    /// What the neighbours of pixel `p` say of it: whether they are of one path tree (0), of several
    /// (1) or some of them mixed (2); and the base-4 logarithm of the squared error to expect.
    fn look_around(&self, p: u32, noise: &[f64], image: &[[f64; 3]]) -> (u8, i32) {
        let (x, y) = (p % self.gathered.width, p / self.gathered.width);
        let columns = x.saturating_sub(1)..(x + 2).min(self.gathered.width);
        let around: Vec<usize> = (y.saturating_sub(1)..(y + 2).min(self.height))
            .flat_map(|v| columns.clone().map(move |u| (u, v)))
            .filter(|&at| at != (x, y))
            .map(|(u, v)| (v * self.gathered.width + u) as usize)
            .collect();
        let Some(&first) = around.first() else { return (0, i32::MIN) };
        let count = around.len() as f64;
        let mark = |q: usize| &self.gathered.marks[q];
        let mixed = around.iter().any(|&q| mark(q).hash_least != mark(q).hash_most);
        let alike = around.iter().all(|&q| mark(q).hash_least == mark(first).hash_least);
        let kind = if mixed { 2 } else { u8::from(!alike) };
        let mut expected = around.iter().map(|&q| noise[q]).sum::<f64>() / count;
        if kind > 0 {
            // An edge between neighbours of different colour: all or nothing over that difference.
            for c in 0..3 {
                let shown = |q: usize| image[q][c].clamp(0.0, 1.0);
                let mean = around.iter().map(|&q| shown(q)).sum::<f64>() / count;
                let spread = around.iter().map(|&q| (shown(q) - mean).powi(2)).sum::<f64>() / count;
                expected += spread / (12.0 * f64::from(self.goal.pilot));
            }
        }
        let level = if expected > 0.0 { (expected.log2() / 2.0).floor() as i32 } else { i32::MIN };
        (kind, level)
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

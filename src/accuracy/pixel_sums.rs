//! The samples of an image so far, and what its pixels say of their errors.

use super::interval::{self, Interval};
use super::pieces;
use super::pixel_interval;
use super::radiance_bound::RadianceLimit;
use super::sampling::Noise;
use super::truncation::{self, TruncationBound};
use super::unseen::{Caps, Known, Unseen};
use crate::render::samples::{Mark, Traced, quarters, sets};
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Pixels to each side in which a bright thing is taken to show.
const NEAR: usize = 3;

/// The samples of an image so far, pixel by pixel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PixelSums {
    /// Pixels.
    pub width: u32,
    /// Replicates of a pixel; 1 for one sequence, whose quarters are kept apart.
    pub replicates: usize,
    /// Samples of each pixel.
    pub samples: Vec<u32>,
    /// Sums of the sets of samples, `sets(replicates)` a pixel.
    pub sums: Vec<[f64; 3]>,
    /// What the samples did.
    pub marks: Vec<Mark>,
    /// The brightest that large things are taken to show in each pixel, as it was when
    /// [`PixelSums::fix_brightest`] was called; empty before.
    brightest: Vec<f32>,
}

impl PixelSums {
    /// No samples yet.
    pub fn new(width: u32, height: u32, replicates: usize) -> PixelSums {
        let pixels = width as usize * height as usize;
        PixelSums {
            width,
            replicates,
            samples: vec![0; pixels],
            sums: vec![[0.0; 3]; pixels * sets(replicates)],
            marks: vec![Mark::default(); pixels],
            brightest: Vec::new(),
        }
    }

    /// The samples of some pixels as an image of rows of `width`; what does not fill a row is left out.
    pub fn of_some(&self, pixels: &[u32], width: u32) -> PixelSums {
        let height = pixels.len() as u32 / width.max(1);
        let mut some = PixelSums::new(width, height, self.replicates);
        let s = sets(self.replicates);
        let pixels = pixels.iter().map(|p| *p as usize);
        for ((to, sums), at) in some.sums.chunks_mut(s).enumerate().zip(pixels) {
            (some.samples[to], some.marks[to]) = (self.samples[at], self.marks[at]);
            sums.copy_from_slice(self.sums_of(at));
        }
        some
    }

    /// Adds `samples` samples of each of `pixels`; of the first of them if fewer were traced. A pixel of one
    /// sequence that has samples gets as many again, so that old and new quarters join to quarters of the whole.
    pub fn add(&mut self, pixels: &[u32], samples: u32, traced: &Traced) {
        let s = sets(self.replicates);
        for ((at, more), sums) in pixels.iter().zip(&traced.marks).zip(traced.sums.chunks(s)) {
            let at = *at as usize;
            let (mark, before) = (&mut self.marks[at], self.samples[at]);
            *mark = if before == 0 { *more } else { mark.and(more) };
            self.samples[at] += samples;
            let own = &mut self.sums[at * s..(at + 1) * s];
            if self.replicates > 1 {
                own.iter_mut().zip(sums).for_each(|(sum, more)| *sum = plus(*sum, *more));
            } else if before == 0 {
                own.copy_from_slice(sums);
            } else {
                debug_assert_eq!(before, samples, "quarters join only where samples double");
                let halves = [plus(own[0], own[1]), plus(own[2], own[3])];
                own.copy_from_slice(&[halves[0], halves[1], plus(sums[0], sums[1]), plus(sums[2], sums[3])]);
            }
        }
    }

    /// As [`PixelSums::add`] for any number of samples, but the sets are lost: only means are right.
    pub fn add_means(&mut self, pixels: &[u32], samples: u32, traced: &Traced) {
        let s = sets(self.replicates);
        for ((at, more), sums) in pixels.iter().zip(&traced.marks).zip(traced.sums.chunks(s)) {
            let at = *at as usize;
            self.marks[at] = if self.samples[at] == 0 { *more } else { self.marks[at].and(more) };
            self.samples[at] += samples;
            self.sums[at * s] = sums.iter().fold(self.sums[at * s], |sum, more| plus(sum, *more));
        }
    }

    /// Appends everything, as little-endian numbers.
    pub(super) fn put(&self, to: &mut Vec<u8>) {
        let mut word = |n: u32| to.extend(n.to_le_bytes());
        [self.width, self.replicates as u32, self.samples.len() as u32].into_iter().for_each(&mut word);
        self.samples.iter().for_each(|n| word(*n));
        for m in &self.marks {
            [m.hash_least, m.hash_most, m.rays, m.depth].into_iter().for_each(&mut word);
        }
        word(self.brightest.len() as u32);
        self.brightest.iter().for_each(|b| word(b.to_bits()));
        let cuts = self.marks.iter().map(|m| &m.cut);
        self.sums.as_flattened().iter().chain(cuts).for_each(|x| to.extend(x.to_le_bytes()));
    }

    /// Takes what [`PixelSums::put`] wrote from the front of `from`; `None` if that is too short.
    pub(super) fn take(from: &mut &[u8]) -> Option<PixelSums> {
        let (width, replicates, pixels) = (word(from)?, word(from)? as usize, word(from)? as usize);
        let samples = (0..pixels).map(|_| word(from)).collect::<Option<_>>()?;
        let mut mark = || {
            let (hash_least, hash_most, rays, depth) = (word(from)?, word(from)?, word(from)?, word(from)?);
            Some(Mark { hash_least, hash_most, rays, depth, cut: 0.0 })
        };
        let mut marks = (0..pixels).map(|_| mark()).collect::<Option<Vec<Mark>>>()?;
        let fixed = word(from).filter(|n| *n == 0 || *n as usize == pixels)?;
        let brightest = (0..fixed).map(|_| word(from).map(f32::from_bits)).collect::<Option<_>>()?;
        let mut sum = || Some([number(from)?, number(from)?, number(from)?]);
        let sums = (0..pixels.checked_mul(sets(replicates))?).map(|_| sum()).collect::<Option<_>>()?;
        for m in &mut marks {
            m.cut = number(from)?;
        }
        Some(PixelSums { width, replicates, samples, sums, marks, brightest })
    }

    /// Sums of the sets of pixel `at`.
    pub fn sums_of(&self, at: usize) -> &[[f64; 3]] {
        let s = sets(self.replicates);
        &self.sums[at * s..(at + 1) * s]
    }

    /// The sets of pixel `at` that have samples: sum, and samples.
    fn sets_of(&self, at: usize) -> impl Iterator<Item = (&[f64; 3], f64)> {
        let (samples, r) = (self.samples[at], self.replicates);
        let quarters = quarters(samples);
        let count = move |set: usize| if r > 1 { samples / r as u32 } else { quarters[set] };
        let sets = self.sums_of(at).iter().enumerate().map(move |(set, sum)| (sum, f64::from(count(set))));
        sets.filter(|(_, count)| *count > 0.0)
    }

    /// Samples of all pixels.
    pub fn total(&self) -> u64 {
        pieces::total(self.samples.len(), |at| u64::from(self.samples[at]))
    }

    /// Rows of the image.
    pub fn height(&self) -> u32 {
        self.samples.len() as u32 / self.width.max(1)
    }

    /// What pixel `at` says of its sampling error; it has samples.
    pub fn noise_of(&self, at: usize) -> Noise {
        match self.sums_of(at) {
            _ if self.samples[at] == 1 => self.noise_of_one(at),
            &[a, b, c, d] if self.replicates == 1 => Noise::of_quarters([a, b, c, d], self.samples[at]),
            sums => Noise::of_replicates(sums, self.samples[at]),
        }
    }

    /// The same of a pixel of one sample, from that of its pair; if it has none, as much as a pixel can err.
    fn noise_of_one(&self, at: usize) -> Noise {
        let Some(other) = self.pair_of(at) else { return Noise::of_one([0.0; 3], [1.0; 3], 1.0) };
        let mutual = self.samples[other] == 1 && self.pair_of(other) == Some(at);
        Noise::of_one(self.mean(at), self.mean(other), if mutual { 0.5 } else { 1.0 })
    }

    /// The pixels of its row, or of an only column, whose samples decide together on pixel `at` as long as they have one each:
    /// it and its pair, and the last of an odd row with the two before it.
    pub fn compared_with(&self, at: usize) -> Range<usize> {
        let (along, end) = self.along(at);
        match along & !1 {
            start if start + 3 >= end => end.saturating_sub(2 + end % 2)..end,
            start => start..start + 2,
        }
    }

    /// The place of pixel `at` in its row, or in an only column, and the length of that.
    fn along(&self, at: usize) -> (usize, usize) {
        match self.width {
            1 => (at, self.samples.len()),
            width => (at % width as usize, width as usize),
        }
    }

    /// The neighbour that pixel `at` is compared with as long as it has one sample: pixels 2k and 2k + 1 of a row are a pair;
    /// the last of an odd row has the one before it. In one column, the same along it.
    pub fn pair_of(&self, at: usize) -> Option<usize> {
        let (along, end) = self.along(at);
        let other = if along ^ 1 < end { along ^ 1 } else { along.checked_sub(1)? };
        let other = at - along + other;
        (self.samples[other] > 0).then_some(other)
    }

    /// True if every set of samples of pixel `at` puts all channels at white or more.
    pub fn is_white(&self, at: usize) -> bool {
        self.sets_of(at).all(|(sum, count)| sum.iter().all(|channel| *channel >= count))
    }

    /// Greatest radiance that a set of samples saw in each pixel or up to `NEAR` from it, at least 1; 1 where all
    /// samples of the pixel and its neighbours took one path.
    fn brightest_around(&self) -> Vec<f32> {
        let (width, height) = (self.width as usize, self.height() as usize);
        let own = |at: usize| {
            self.sets_of(at).flat_map(|(sum, count)| sum.map(|c| (c / count) as f32)).fold(1.0, f32::max)
        };
        let own = pieces::map(self.samples.len(), own);
        let near = |middle: usize, end: usize, reach: usize| {
            middle.saturating_sub(reach)..(middle + reach + 1).min(end)
        };
        let row =
            |at: usize| near(at % width, width, NEAR).map(|x| own[at - at % width + x]).fold(1.0, f32::max);
        let rows = pieces::map(own.len(), row);
        let one_path = |at: usize| {
            let path = self.marks[at].hash_least;
            let columns = near(at % width, width, 1);
            let mut window =
                near(at / width, height, 1).flat_map(|y| columns.clone().map(move |x| y * width + x));
            window.all(|q| (self.marks[q].hash_least, self.marks[q].hash_most) == (path, path))
        };
        let around = |at: usize| match one_path(at) {
            true => 1.0,
            false => near(at / width, height, NEAR).map(|y| rows[y * width + at % width]).fold(1.0, f32::max),
        };
        pieces::map(own.len(), around)
    }

    /// Decides now what large things are taken to show: later samples find more paths, but pixels are not sampled anew
    /// for that.
    pub fn fix_brightest(&mut self) {
        self.brightest = self.brightest_around();
    }

    /// What the samples of pixel `at` and its neighbours tell of what else it may hold, once that is fixed.
    pub fn known_of(&self, at: usize) -> Known {
        let brightest = self.brightest.get(at).copied().unwrap_or(f32::INFINITY);
        self.known_with(at, brightest)
    }

    fn known_with(&self, at: usize, brightest: f32) -> Known {
        let (mut low, mut high) = ([f32::INFINITY; 3], [0.0f32; 3]);
        // One sample tells less of the rest of its pixel than two.
        let other = self.pair_of(at).filter(|_| self.samples[at] == 1);
        for (sum, count) in self.sets_of(at).chain(other.into_iter().flat_map(|q| self.sets_of(q))) {
            for c in 0..3 {
                let mean = (sum[c] / count) as f32;
                (low[c], high[c]) = (low[c].min(mean), high[c].max(mean));
            }
        }
        Known { white: self.samples[at] > 1 && self.is_white(at), brightest, low, high }
    }

    /// What the pixels may hold unseen; those without samples hold nothing.
    pub fn unseen(&self, caps: &Caps) -> Unseen {
        let now = if self.brightest.is_empty() { self.brightest_around() } else { Vec::new() };
        let brightest = if now.is_empty() { &self.brightest } else { &now };
        self.unseen_by(caps, |at| self.known_with(at, brightest[at]))
    }

    /// The same without any assumption on what is not in the caps.
    pub fn not_excluded(&self, caps: &Caps) -> Unseen {
        self.unseen_by(caps, |at| self.known_with(at, f32::INFINITY))
    }

    fn unseen_by(&self, caps: &Caps, known: impl Fn(usize) -> Known + Sync + Send) -> Unseen {
        let add = |unseen: &mut Unseen, at: usize| match self.samples[at] {
            0 => (),
            samples => unseen.add(samples, caps.of(at), known(at)),
        };
        pieces::fold(self.samples.len(), add, Unseen::joined)
    }

    /// Mean of pixel `at`, linear RGB, unclamped.
    pub fn mean(&self, at: usize) -> [f64; 3] {
        let total = self.sums_of(at).iter().fold([0.0; 3], |a, b| plus(a, *b));
        total.map(|channel| channel / f64::from(self.samples[at].max(1)))
    }

    /// The image, linear RGB; pixels without samples are black.
    pub fn linear(&self) -> Vec<[f32; 3]> {
        pieces::map(self.samples.len(), |at| self.mean(at).map(|channel| channel as f32))
    }

    /// The image with pixels that have no samples as the nearest that have; it must have been sampled from
    /// [coarse to fine](super::pixel_order).
    pub fn filled(&self) -> Vec<[f32; 3]> {
        let linear = self.linear();
        if self.done() == 1.0 {
            return linear;
        }
        let stand_in = super::pixel_order::stand_in(self.width, &self.samples);
        pieces::map(linear.len(), |at| linear[stand_in(at as u32) as usize])
    }

    /// Share of pixels that have samples.
    pub fn done(&self) -> f64 {
        let there = pieces::total(self.samples.len(), |at| u64::from(self.samples[at] > 0));
        there as f64 / self.samples.len().max(1) as f64
    }

    /// What the pixels say of their sampling error; those without samples say nothing.
    pub fn noise(&self) -> Noise {
        let add = |noise: &mut Noise, at: usize| match self.samples[at] {
            0 => (),
            _ => *noise = noise.plus(self.noise_of(at)),
        };
        pieces::fold(self.samples.len(), add, Noise::plus)
    }

    /// The intervals of pixel `at` of several replicates, one a channel; it has samples.
    pub fn intervals(&self, at: usize, confidence: f64) -> [Interval; 3] {
        let n = self.samples[at];
        let each = f64::from(n) / self.replicates as f64;
        let brightest = self.sums_of(at).iter().flatten().fold(1.0, |m: f64, sum| m.max(sum / each));
        std::array::from_fn(|c| {
            let sums: Vec<f64> = self.sums_of(at).iter().map(|s| s[c]).collect();
            interval::pixel(&sums, n, &self.marks[at], (0.0, brightest), confidence)
        })
    }

    /// Half the width of each pixel's interval, of its widest channel; NaN without samples.
    pub fn half_widths(&self, confidence: f64) -> Vec<f64> {
        if self.replicates == 1 {
            return pixel_interval::half_widths(self, confidence);
        }
        let half = |at: usize| match self.samples[at] {
            0 => f64::NAN,
            _ => self.intervals(at, confidence).iter().fold(0.0, |m: f64, i| m.max((i.high - i.low) / 2.0)),
        };
        pieces::map(self.samples.len(), half)
    }

    /// Mean throughput that the image lost to the cut.
    pub fn mean_cut(&self) -> f64 {
        pieces::sum(self.samples.len(), |at| self.cut(at)) / self.samples.len().max(1) as f64
    }

    /// What hidden light can add to each pixel as shown, of its worst channel: never less than nothing, no more
    /// than the throughput that was cut times the greatest radiance, nor than what is missing to white.
    pub fn hidden(&self, limit: &RadianceLimit) -> Vec<f64> {
        pieces::map(self.samples.len(), |at| self.hidden_of(at, limit).into_iter().fold(0.0, f64::max))
    }

    /// The same of pixel `at`, channel by channel.
    pub fn hidden_of(&self, at: usize, limit: &RadianceLimit) -> [f64; 3] {
        truncation::hidden(self.mean(at), self.cut(at), limit)
    }

    /// Mean throughput that a sample of pixel `at` lost to the cut.
    pub fn cut(&self, at: usize) -> f64 {
        self.marks[at].cut / f64::from(self.samples[at].max(1))
    }

    /// What hidden light can add to the image as shown.
    pub fn truncation(&self, limit: &RadianceLimit) -> TruncationBound {
        truncation::truncation_of(self.samples.len(), |at| (self.mean(at), self.cut(at)), limit)
    }
}

/// A number from the front of `from`.
fn word(from: &mut &[u8]) -> Option<u32> {
    let (n, rest) = from.split_first_chunk()?;
    *from = rest;
    Some(u32::from_le_bytes(*n))
}

/// As [`word`], of 64 bits.
fn number(from: &mut &[u8]) -> Option<f64> {
    let (x, rest) = from.split_first_chunk()?;
    *from = rest;
    Some(f64::from_le_bytes(*x))
}

fn plus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|c| a[c] + b[c])
}

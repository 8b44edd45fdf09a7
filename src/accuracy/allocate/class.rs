//! Pixels that are sampled alike.

use super::goal::Goal;
use crate::accuracy::pieces;
use crate::accuracy::pixel_sums::PixelSums;
use crate::accuracy::sampling::Noise;
use crate::accuracy::unseen::{Caps, Known, Unseen};
use crate::settings::sampler::pcg4d;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ops::Range;

/// Fewest pixels of a class, so that one pixel's samples weigh little in its class's.
const LEAST_CLASS: usize = 64;

/// What doubling leaves of a class's squared error, before it was seen to: between 1/2 (random) and 2^-1.5
/// (stratified, edges; Mitchell, SIGGRAPH 1996).
const DOUBLED: f64 = 0.42;

/// Pixels whose neighbourhoods look alike.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Class {
    /// In the order they are taken.
    pub(super) pixels: Vec<u32>,
    /// The first `ahead` of them have `2 * samples`, the rest `samples`.
    pub(super) ahead: usize,
    pub(super) samples: u32,
    /// Noise of those ahead, and of the rest.
    pub(super) noise: [Noise; 2],
    /// The same pixels by what they may hold unseen.
    pub(super) unseen: [Unseen; 2],
    /// What doubling leaves of the squared error.
    pub(super) doubled: f64,
    /// Rays of one sample.
    pub(super) rays: f64,
}

impl Class {
    /// True if a pixel of the rest may hold something brighter than white.
    pub(super) fn is_bright(&self) -> bool {
        self.unseen[1].is_bright()
    }

    /// The greatest radiance that a pixel of the rest may hold unseen.
    pub(super) fn brightest(&self) -> f32 {
        self.unseen[1].brightest()
    }

    /// True if its pixels may have twice as many samples.
    pub(super) fn can_double(&self, goal: &Goal) -> bool {
        self.samples <= goal.most / 2
    }

    /// Noise and cost from what its pixels have.
    pub(super) fn measure(&mut self, gathered: &PixelSums, caps: &Caps) {
        let of = |pixels: &[u32]| {
            let add = |all: &mut Seen, at: usize| {
                let p = pixels[at] as usize;
                all.noise = all.noise.plus(gathered.noise_of(p));
                all.unseen.add(gathered.samples[p], caps.of(p), gathered.known_of(p));
                all.rays += u64::from(gathered.marks[p].rays);
                all.samples += u64::from(gathered.samples[p]);
            };
            pieces::fold(pixels.len(), add, Seen::joined)
        };
        let (ahead, rest) = self.pixels.split_at(self.ahead);
        let (ahead, rest) = (of(ahead), of(rest));
        self.rays = (ahead.rays + rest.rays) as f64 / (ahead.samples + rest.samples) as f64;
        (self.noise, self.unseen) = ([ahead.noise, rest.noise], [ahead.unseen, rest.unseen]);
    }
}

/// What some pixels say together.
#[derive(Default)]
struct Seen {
    noise: Noise,
    unseen: Unseen,
    rays: u64,
    samples: u64,
}

impl Seen {
    fn joined(self, other: Seen) -> Seen {
        Seen {
            noise: self.noise.plus(other.noise),
            unseen: self.unseen.joined(other.unseen),
            rays: self.rays + other.rays,
            samples: self.samples + other.samples,
        }
    }
}

/// Sorts the pixels into classes by their neighbours; all have `goal.pilot` samples.
pub(super) fn classify(gathered: &PixelSums, caps: &Caps, goal: &Goal) -> Vec<Class> {
    let count = gathered.samples.len();
    // What a pixel of one sample says of its error is its pair's sample, too: neighbours' values tell of it instead.
    let own = |p| if goal.pilot > 1 { gathered.noise_of(p).squares } else { 0.0 };
    let noise = pieces::map(count, own);
    let image = pieces::map(count, |p| gathered.mean(p));
    let keys = pieces::map(count, |p| {
        let around = Around::new(gathered, goal, p as u32);
        let (kind, level) = around.look(gathered, goal, &noise, &image);
        let radiance = caps.of(p).given(gathered.known_of(p)).radiance;
        // Factors of 2 below white, as if the pixel were like those around: its own samples do not choose its class.
        let dim = (-around.known(&image).contrast(radiance).log2()).clamp(0.0, 7.0) as u8;
        (radiance > 1.0, std::cmp::Reverse(dim), kind, level)
    });
    let mut groups: BTreeMap<_, Vec<u32>> = BTreeMap::new();
    for (p, key) in keys.into_iter().enumerate() {
        groups.entry(key).or_default().push(p as u32);
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
    let class = |mut pixels: Vec<u32>| {
        pixels.par_sort_by_cached_key(|&p| (pcg4d([p, 0x0a11, 0x0ca7, 0xe000])[0], p));
        let (noise, unseen) = ([Noise::default(); 2], Default::default());
        let samples = goal.pilot;
        let mut class = Class { pixels, ahead: 0, samples, noise, unseen, doubled: DOUBLED, rays: 1.0 };
        class.measure(gathered, caps);
        class
    };
    merged.into_iter().map(class).collect()
}

/// The pixels around one: its class is read from these.
struct Around {
    /// On the stack: there is one for every pixel.
    list: [usize; 12],
    found: usize,
}

impl Around {
    /// The eight neighbours of pixel `p`; after a pilot of one sample those of the pixels that it is compared with, too, but
    /// none of these.
    fn new(gathered: &PixelSums, goal: &Goal, p: u32) -> Around {
        let (width, height) = (gathered.width, gathered.height());
        let (x, y) = (p % width, p / width);
        let (mut columns, mut rows) = (x..x + 1, y..y + 1);
        if goal.pilot == 1 {
            let compared = gathered.compared_with(p as usize);
            match width {
                1 => rows = compared.start as u32..compared.end as u32,
                _ => columns = compared.start as u32..compared.end as u32,
            }
        }
        let near = |own: &Range<u32>, end: u32| own.start.saturating_sub(1)..(own.end + 1).min(end);
        let mut around = Around { list: [0; 12], found: 0 };
        for v in near(&rows, height) {
            for u in near(&columns, width) {
                if !(rows.contains(&v) && columns.contains(&u)) {
                    around.list[around.found] = (v * width + u) as usize;
                    around.found += 1;
                }
            }
        }
        around
    }

    fn list(&self) -> &[usize] {
        &self.list[..self.found]
    }

    /// What they would say of a pixel like them.
    fn known(&self, image: &[[f64; 3]]) -> Known {
        let Some(&first) = self.list().first() else { return Known::NOTHING };
        let level = |choose: fn(f64, f64) -> f64| -> [f32; 3] {
            std::array::from_fn(|c| {
                self.list().iter().fold(image[first][c], |level, q| choose(level, image[*q][c])) as f32
            })
        };
        Known { low: level(f64::min), high: level(f64::max), ..Known::NOTHING }
    }

    /// Whether they are of one path tree (0), of several (1) or some of them mixed (2); and the base-4 logarithm of the
    /// squared error to expect.
    fn look(&self, gathered: &PixelSums, goal: &Goal, noise: &[f64], image: &[[f64; 3]]) -> (u8, i32) {
        let around = self.list();
        let Some(&first) = around.first() else { return (0, i32::MIN) };
        let count = around.len() as f64;
        let mark = |q: usize| &gathered.marks[q];
        let mixed = around.iter().any(|&q| mark(q).hash_least != mark(q).hash_most);
        let alike = around.iter().all(|&q| mark(q).hash_least == mark(first).hash_least);
        let kind = if mixed { 2 } else { u8::from(!alike) };
        let mut expected = around.iter().map(|&q| noise[q]).sum::<f64>() / count;
        if kind > 0 || goal.pilot == 1 {
            // An edge between neighbours of different colour: all or nothing over that difference.
            for c in 0..3 {
                let shown = |q: usize| image[q][c].clamp(0.0, 1.0);
                let mean = around.iter().map(|&q| shown(q)).sum::<f64>() / count;
                let spread = around.iter().map(|&q| (shown(q) - mean).powi(2)).sum::<f64>() / count;
                expected += spread / (12.0 * f64::from(goal.pilot));
            }
        }
        let level = if expected > 0.0 { (expected.log2() / 2.0).floor() as i32 } else { i32::MIN };
        (kind, level)
    }
}

//! Images whose exact pixel means are known, and points to sample them with: what the estimates are
//! calibrated against.

use crate::render::samples::{Mark, Source, Traced, quarters};
use crate::settings::sampler::pcg4d;
use std::ops::Range;

/// How one replicate's points lie in the pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Points {
    /// Independent.
    Random,
    /// One in each cell of a square grid; the number of points asked for at once is a square.
    Stratified,
    /// Owen-scrambled Sobol points: every power of two of them is a (0, 2)-net.
    Owen,
}

fn unit(h: u32) -> f64 {
    (f64::from(h) + 0.5) / 4_294_967_296.0
}

/// Nested uniform scrambling by hash: Burley, "Practical Hash-based Owen Scrambling", JCGT 9(4), 2020.
fn owen(x: u32, seed: u32) -> u32 {
    let mut x = x.reverse_bits();
    x = x.wrapping_add(seed);
    x ^= x.wrapping_mul(0x6c50_b47c);
    x ^= x.wrapping_mul(0xb82f_1e52);
    x ^= x.wrapping_mul(0xc7af_e638);
    x ^= x.wrapping_mul(0x8d22_f6e6);
    x.reverse_bits()
}

/// Second Sobol coordinate of point `i`.
fn sobol_y(i: u32) -> u32 {
    let (mut v, mut y, mut i) = (1u32 << 31, 0, i);
    while i != 0 {
        if i & 1 == 1 {
            y ^= v;
        }
        v ^= v >> 1;
        i >>= 1;
    }
    y
}

impl Points {
    /// Points `which` of replicate `r` of the pixel that `seed` names.
    pub fn replicate(self, seed: u32, r: u32, which: Range<u32>) -> Vec<[f64; 2]> {
        let [a, b, c, _] = pcg4d([seed, r, 0x51ed, 77]);
        let side = f64::from(which.len() as u32).sqrt().round() as u32;
        if self == Points::Stratified {
            assert_eq!(side * side, which.len() as u32, "not a square");
        }
        which
            .map(|k| match self {
                Points::Random => {
                    let h = pcg4d([a, b, c, k]);
                    [unit(h[0]), unit(h[1])]
                }
                Points::Stratified => {
                    let h = pcg4d([a, b, c, k]);
                    let cell = [k % side, k / side % side];
                    [0, 1].map(|i| (f64::from(cell[i]) + unit(h[i])) / f64::from(side))
                }
                Points::Owen => [unit(owen(k.reverse_bits(), a)), unit(owen(sobol_y(k), b))],
            })
            .collect()
    }
}

/// Area of the unit square where `nx x + ny y < offset`.
pub fn edge_area(nx: f64, ny: f64, offset: f64) -> f64 {
    // Mirrored so that both components are positive; then the integral of a ramp, by its second antiderivative.
    let offset = offset - nx.min(0.0) - ny.min(0.0);
    let (a, b) = (nx.abs().max(ny.abs()), nx.abs().min(ny.abs()));
    if b < 1e-9 * a {
        return (offset / a).clamp(0.0, 1.0);
    }
    let ramp = |t: f64| t.max(0.0).powi(2) / 2.0;
    (ramp(offset) - ramp(offset - a) - ramp(offset - b) + ramp(offset - a - b)) / (a * b)
}

/// Something of an even colour, added to what is there.
#[derive(Debug, Clone, Copy)]
pub enum Feature {
    /// Where `n . p < offset`.
    Edge { n: [f64; 2], offset: f64 },
    /// A strip of that width, in pixels.
    Line { n: [f64; 2], offset: f64, width: f64 },
    /// A disc within one pixel.
    Dot { center: [f64; 2], radius: f64 },
}

impl Feature {
    fn covers(&self, x: f64, y: f64) -> bool {
        match *self {
            Feature::Edge { n, offset } => n[0] * x + n[1] * y < offset,
            Feature::Line { n, offset, width } => {
                let d = n[0] * x + n[1] * y - offset;
                d < width && d >= 0.0
            }
            Feature::Dot { center, radius } => {
                (x - center[0]).powi(2) + (y - center[1]).powi(2) < radius * radius
            }
        }
    }

    fn area(&self, x: u32, y: u32) -> f64 {
        let (x, y) = (f64::from(x), f64::from(y));
        let below = |n: [f64; 2], offset: f64| edge_area(n[0], n[1], offset - n[0] * x - n[1] * y);
        match *self {
            Feature::Edge { n, offset } => below(n, offset),
            Feature::Line { n, offset, width } => below(n, offset + width) - below(n, offset),
            Feature::Dot { center, radius } => {
                let here = center[0].floor() == x && center[1].floor() == y;
                if here { std::f64::consts::PI * radius * radius } else { 0.0 }
            }
        }
    }
}

/// A square image: a gradient and features on it.
#[derive(Debug, Clone)]
pub struct Picture {
    /// Pixels along an edge.
    pub side: u32,
    /// Colour at the origin and its change along x and y, per pixel.
    pub ramp: [f64; 3],
    /// Features and what each adds to red; green gets 0.7 of it, blue 0.3.
    pub features: Vec<(Feature, f64)>,
    /// The features that cover part, not all, of each pixel, and what the others add.
    partial: Vec<(Vec<usize>, f64)>,
}

/// Shares of red, green and blue.
pub const TINT: [f64; 3] = [1.0, 0.7, 0.3];

impl Picture {
    pub fn new(side: u32, ramp: [f64; 3], features: Vec<(Feature, f64)>) -> Picture {
        let partial = (0..side * side)
            .map(|p| {
                let mut whole = 0.0;
                let mut cut = Vec::new();
                for (i, (feature, height)) in features.iter().enumerate() {
                    let area = feature.area(p % side, p / side);
                    if area > 1.0 - 1e-12 {
                        whole += height;
                    } else if area > 1e-12 {
                        cut.push(i);
                    }
                }
                (cut, whole)
            })
            .collect();
        Picture { side, ramp, features, partial }
    }

    /// Number `i` in [0, 1) of the run `seed`.
    pub fn random(seed: u32, i: u32) -> f64 {
        unit(pcg4d([seed, i, 99, 5])[0])
    }

    /// Exact mean of each pixel, unclamped.
    pub fn truth(&self) -> Vec<[f64; 3]> {
        (0..self.side * self.side)
            .map(|p| {
                let (x, y) = (p % self.side, p / self.side);
                let mut v = self.base(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let (cut, whole) = &self.partial[p as usize];
                v += whole;
                v += cut.iter().map(|&i| self.features[i].0.area(x, y) * self.features[i].1).sum::<f64>();
                TINT.map(|t| t * v)
            })
            .collect()
    }

    fn base(&self, x: f64, y: f64) -> f64 {
        self.ramp[0] + self.ramp[1] * x + self.ramp[2] * y
    }

    /// Value at a point of pixel `p`, and the bits of what is there.
    fn value(&self, p: u32, [dx, dy]: [f64; 2]) -> (f64, u32) {
        let (x, y) = (f64::from(p % self.side) + dx, f64::from(p / self.side) + dy);
        let (cut, whole) = &self.partial[p as usize];
        let (mut v, mut hash) = (self.base(x, y) + whole, whole.to_bits() as u32);
        for &i in cut {
            if self.features[i].0.covers(x, y) {
                v += self.features[i].1;
                hash = hash.wrapping_mul(31).wrapping_add(i as u32 + 1);
            }
        }
        (v, hash)
    }
}

/// Traces a [`Picture`]; every sample is one ray.
pub struct Painter<'a> {
    pub picture: &'a Picture,
    pub points: Points,
    pub replicates: u32,
    pub seed: u32,
    /// Samples traced so far.
    pub traced: u64,
}

impl Source for Painter<'_> {
    type Error = std::convert::Infallible;

    fn replicates(&self) -> usize {
        self.replicates as usize
    }

    fn trace(&mut self, pixels: &[u32], samples: Range<u32>) -> Result<Traced, Self::Error> {
        let r = self.replicates;
        // The points of each set, and the replicate they are of.
        let sets: Vec<(u32, Range<u32>)> = match r {
            1 => {
                let mut end = samples.start;
                let quarter = |count| {
                    end += count;
                    (0, end - count..end)
                };
                quarters(samples.end - samples.start).map(quarter).into()
            }
            _ => (0..r).map(|replicate| (replicate, samples.start / r..samples.end / r)).collect(),
        };
        let mut out = Traced { replicates: r as usize, ..Traced::default() };
        for &p in pixels {
            let mut mark = Mark { hash_least: u32::MAX, depth: 1, ..Mark::default() };
            let flat = self.picture.ramp[1..] == [0.0; 2] && self.picture.partial[p as usize].0.is_empty();
            for (replicate, which) in &sets {
                let mut sum = 0.0;
                if flat {
                    // All samples are one: the first stands for all.
                    let (v, hash) = self.picture.value(p, [0.5; 2]);
                    let each = which.len() as u32;
                    out.sums.push(TINT.map(|t| t * v * f64::from(each)));
                    (mark.hash_least, mark.hash_most) = (hash, hash);
                    mark.rays += each;
                    continue;
                }
                for at in self.points.replicate(pcg4d([self.seed, p, 3, 4])[0], *replicate, which.clone()) {
                    let (v, hash) = self.picture.value(p, at);
                    sum += v;
                    mark.hash_least = mark.hash_least.min(hash);
                    mark.hash_most = mark.hash_most.max(hash);
                    mark.rays += 1;
                }
                out.sums.push(TINT.map(|t| t * sum));
            }
            self.traced += u64::from(mark.rays);
            out.marks.push(mark);
        }
        Ok(out)
    }
}

/// Sum over pixels of the squared error, mean over channels, in [0, 1] as shown.
pub fn squared_error(image: &[[f64; 3]], truth: &[[f64; 3]]) -> f64 {
    let shown = |v: f64| v.clamp(0.0, 1.0);
    let pixel = |(a, b): (&[f64; 3], &[f64; 3])| {
        (0..3).map(|c| (shown(a[c]) - shown(b[c])).powi(2)).sum::<f64>() / 3.0
    };
    image.iter().zip(truth).map(pixel).sum()
}

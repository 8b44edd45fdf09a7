//! Where in its pixel a sample lies: counter-based, the same bits here and in `glsl/lib/base/sampler.glsl`
//! (numerics.md, Samplers). Sample k of pixel (x, y) depends on (seed, x, y, k, replicates) alone, so the
//! first N samples of 2N are the N samples. One sample per pixel is the exception: it is the centre.

use crate::kernel::abi::{SAMPLER_OWEN, SAMPLER_RANDOM, SAMPLER_STRATIFIED};

/// How the samples of a pixel are spread over it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, PartialOrd, Ord)]
pub enum Sampler {
    /// Independent and uniform.
    Random,
    /// Jittered, and that progressively: of the first 4^m samples one lies in each cell of a 2^m x 2^m grid.
    Stratified,
    /// The first two dimensions of Sobol's sequence under Owen's nested uniform scrambling: of the first
    /// 2^m samples one lies in each rectangle of 2^-a x 2^-(m - a), for every a.
    #[default]
    Owen,
}

impl Sampler {
    /// All of them.
    pub const ALL: [Sampler; 3] = [Sampler::Random, Sampler::Stratified, Sampler::Owen];

    /// As the command line and the report spell it.
    pub fn name(self) -> &'static str {
        match self {
            Sampler::Random => "random",
            Sampler::Stratified => "stratified",
            Sampler::Owen => "owen",
        }
    }

    /// Value of the specialisation constant `sampler_kind`.
    pub fn word(self) -> u32 {
        match self {
            Sampler::Random => SAMPLER_RANDOM,
            Sampler::Stratified => SAMPLER_STRATIFIED,
            Sampler::Owen => SAMPLER_OWEN,
        }
    }

    /// The sampler that a kernel takes for `word`.
    pub fn of_word(word: u32) -> Sampler {
        match word {
            SAMPLER_RANDOM => Sampler::Random,
            SAMPLER_STRATIFIED => Sampler::Stratified,
            _ => Sampler::Owen,
        }
    }
}

impl std::str::FromStr for Sampler {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let known = Sampler::ALL.into_iter().find(|s| s.name() == text);
        known.ok_or_else(|| "write random, stratified or owen".into())
    }
}

/// The four-dimensional PCG hash of Jarzynski and Olano, "Hash Functions for GPU Rendering",
/// JCGT 9(3), 2020, listing `pcg4d`, with a third round and a last xorshift. As published, the low bits of the first
/// word depend on the third input through one product, whose lowest bit is 1 with probability 1/4; scrambling takes
/// the top bits of a coordinate from them, so that replicates were correlated (variance of the mean of 16 first points
/// 4.7 times that of independent ones; with two rounds and a last xorshift 1.04 in the second bit; now 1.00).
pub fn pcg4d(v: [u32; 4]) -> [u32; 4] {
    let mut v = v.map(|c| c.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    let mix = |v: &mut [u32; 4]| {
        v[0] = v[0].wrapping_add(v[1].wrapping_mul(v[3]));
        v[1] = v[1].wrapping_add(v[2].wrapping_mul(v[0]));
        v[2] = v[2].wrapping_add(v[0].wrapping_mul(v[1]));
        v[3] = v[3].wrapping_add(v[1].wrapping_mul(v[2]));
    };
    for _ in 0..3 {
        mix(&mut v);
        v = v.map(|c| c ^ (c >> 16));
    }
    v
}

/// Nested uniform scrambling of a number whose bits are reversed: bit i of the result is bit i of `v`
/// flipped by a hash of `seed` and the bits below it. Sums, products and x ^= x * even carry from low
/// bits to high ones only. Laine and Karras, "Stratified Sampling for Stochastic Transparency", CGF 30(4),
/// 2011; Burley, "Practical Hash-based Owen Scrambling", JCGT 9(4), 2020; the constants are Vegdahl's,
/// "Building a Better LK Hash", 2021.
fn scramble_reversed(v: u32, seed: u32) -> u32 {
    let mut v = v;
    v ^= v.wrapping_mul(0x3d20_adea);
    v = v.wrapping_add(seed);
    v = v.wrapping_mul((seed >> 16) | 1);
    v ^= v.wrapping_mul(0x0552_6c56);
    v ^ v.wrapping_mul(0x53a2_2864)
}

/// The second dimension of Sobol's sequence, bits reversed: the index times Pascal's triangle modulo 2.
/// C(i, j) is odd where the bits of j are among those of i (Lucas), so the product is a sum over supersets,
/// one bit at a time: Ahmed, "An Implementation Algorithm of 2D Sobol Sequence Fast, Elegant, and Compact",
/// EGSR 2024.
fn sobol_1_reversed(index: u32) -> u32 {
    let mut v = index;
    v ^= (v >> 1) & 0x5555_5555;
    v ^= (v >> 2) & 0x3333_3333;
    v ^= (v >> 4) & 0x0f0f_0f0f;
    v ^= (v >> 8) & 0x00ff_00ff;
    v ^ ((v >> 16) & 0x0000_ffff)
}

/// Bits 0, 2, 4, ... of `v`, side by side: 16 of them.
fn even_bits(v: u32) -> u32 {
    let mut v = v & 0x5555_5555;
    v = (v | (v >> 1)) & 0x3333_3333;
    v = (v | (v >> 2)) & 0x0f0f_0f0f;
    v = (v | (v >> 4)) & 0x00ff_00ff;
    (v | (v >> 8)) & 0x0000_ffff
}

/// Point `index` of a scrambled Sobol sequence, 32 bits per axis.
fn owen(index: u32, hash: [u32; 4]) -> [u32; 2] {
    [
        scramble_reversed(index, hash[0]).reverse_bits(),
        scramble_reversed(sobol_1_reversed(index), hash[1]).reverse_bits(),
    ]
}

/// Point `index` of a progressive jittered sequence, 32 bits per axis of which 24 are filled: a scrambled
/// van der Corput sequence along Morton's curve (the Z sampler of Ahmed and Wonka, "Screen-Space
/// Blue-Noise Diffusion of Monte Carlo Sampling Error via Hierarchical Ordering of Pixels", TOG 39(6),
/// 2020; that each cell's sample is jittered in it, Christensen, Kensler and Kilpatrick, "Progressive
/// Multi-Jittered Sample Sequences", CGF 37(4), 2018). It has 16 bits per axis; `low` gives 8 more.
fn stratified(index: u32, hash: [u32; 4], low: [u32; 4]) -> [u32; 2] {
    let curve = scramble_reversed(index, hash[0]).reverse_bits();
    [(even_bits(curve >> 1) << 16) | ((low[2] >> 24) << 8), (even_bits(curve) << 16) | ((low[3] >> 24) << 8)]
}

/// Position of sample `k` of `samples` inside pixel (x, y), each coordinate in [0, 1) and a multiple
/// of 2^-24 (so exact in `f32`). With one sample it is the pixel's centre.
///
/// Sample `k` is point `k / replicates` of replicate `k % replicates`. Each replicate (at least 1) is a
/// sequence of its own, scrambled independently of the others; independent samples know no difference.
pub fn offset(
    sampler: Sampler,
    replicates: u32,
    seed: u32,
    x: u32,
    y: u32,
    k: u32,
    samples: u32,
) -> [f32; 2] {
    if samples == 1 {
        return [0.5, 0.5];
    }
    let replicates = replicates.max(1);
    let own = pcg4d([x, y, k, seed]);
    let shared = || pcg4d([x, y, k % replicates, seed]);
    let point = match sampler {
        Sampler::Random => [own[0], own[1]],
        Sampler::Stratified => stratified(k / replicates, shared(), own),
        Sampler::Owen => owen(k / replicates, shared()),
    };
    point.map(|c| (c >> 8) as f32 * (1.0 / 16_777_216.0))
}

#[cfg(test)]
mod tests;

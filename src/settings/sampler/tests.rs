use super::*;
use std::f64::consts::TAU;

/// Samples of the whole picture; any number but 1.
const MANY: u32 = 1 << 20;

/// Points of one replicate as integers of 24 bits.
fn points(sampler: Sampler, pixel: u32, count: u32) -> Vec<[u32; 2]> {
    (0..count).map(|k| offset(sampler, 1, 7, pixel, 3, k, MANY).map(|c| (c * 16_777_216.0) as u32)).collect()
}

/// True if the first 2^m points put one into each rectangle of 2^-a by 2^-(m - a).
fn one_in_each(points: &[[u32; 2]], m: u32, a: u32) -> bool {
    let mut seen = vec![false; 1 << m];
    points[..1 << m].iter().for_each(|[x, y]| {
        let column = u64::from(*x) >> (24 - a);
        let row = u64::from(*y) >> (24 - (m - a));
        seen[((column << (m - a)) | row) as usize] = true;
    });
    seen.into_iter().all(|s| s)
}

#[test]
fn names_and_words_come_back() {
    for sampler in Sampler::ALL {
        assert_eq!(sampler.name().parse(), Ok(sampler));
        assert_eq!(Sampler::of_word(sampler.word()), sampler);
    }
    assert!("sobol".parse::<Sampler>().is_err());
}

#[test]
fn offsets_fill_the_pixel_evenly() {
    // 64 cells, 65,536 samples: chi-square with 63 degrees of freedom stays below its 1 - 1e-6
    // quantile (131) for a sound hash; a constant or striped one scores thousands.
    for (sampler, most) in [(Sampler::Random, 131.0), (Sampler::Stratified, 0.0), (Sampler::Owen, 0.0)] {
        let mut cells = [0u32; 64];
        for k in 0..65_536 {
            let [u, v] = offset(sampler, 1, 7, 3, 5, k, 65_536);
            assert!((0.0..1.0).contains(&u) && (0.0..1.0).contains(&v));
            assert!([u, v].iter().all(|c| (c * 16_777_216.0).fract() == 0.0), "a multiple of 2^-24");
            cells[(u * 8.0) as usize * 8 + (v * 8.0) as usize] += 1;
        }
        let chi2: f64 = cells.iter().map(|&c| (f64::from(c) - 1024.0).powi(2) / 1024.0).sum();
        assert!(chi2 <= most, "{}: chi-square {chi2}", sampler.name());
    }
}

#[test]
fn one_sample_of_all_pixels_fills_the_pixel_evenly() {
    // Scrambling is uniform: sample 5 alone, over pixels and seeds, is spread like a random one.
    for sampler in Sampler::ALL {
        let mut cells = [0u32; 64];
        for i in 0..65_536u32 {
            let [u, v] = offset(sampler, 1, i >> 12, i & 63, (i >> 6) & 63, 5, 16);
            cells[(u * 8.0) as usize * 8 + (v * 8.0) as usize] += 1;
        }
        let chi2: f64 = cells.iter().map(|&c| (f64::from(c) - 1024.0).powi(2) / 1024.0).sum();
        assert!(chi2 < 131.0, "{}: chi-square {chi2}", sampler.name());
    }
}

#[test]
fn neighbours_and_seeds_differ() {
    for sampler in Sampler::ALL {
        let a = offset(sampler, 1, 0, 1, 2, 3, 4);
        for [seed, x, y, k] in [[1, 1, 2, 3], [0, 2, 2, 3], [0, 1, 3, 3], [0, 1, 2, 2]] {
            assert_ne!(a, offset(sampler, 1, seed, x, y, k, 4));
        }
        assert_eq!(offset(sampler, 4, 9, 1, 2, 0, 1), [0.5, 0.5]);
    }
}

#[test]
fn fewer_samples_are_the_first_of_more() {
    for sampler in Sampler::ALL {
        for replicates in [1, 3, 16] {
            let of =
                |samples: u32| (0..samples).map(move |k| offset(sampler, replicates, 5, 70, 9, k, samples));
            for n in [2, 3, 16, 50, 256] {
                assert!(of(n).eq(of(2 * n).take(n as usize)), "{} {n}", sampler.name());
            }
        }
    }
}

#[test]
fn replicates_are_sequences_of_their_own() {
    let of = |sampler, replicates, k| offset(sampler, replicates, 5, 70, 9, k, MANY);
    for k in 0..64 {
        assert_eq!(of(Sampler::Random, 1, k), of(Sampler::Random, 8, k), "independent samples have none");
        // The first replicate of 8 is the only one of 1.
        assert_eq!(of(Sampler::Owen, 1, k), of(Sampler::Owen, 8, 8 * k));
    }
    for replicate in 0..4 {
        let points: Vec<_> = (0..256)
            .map(|i| of(Sampler::Owen, 4, 4 * i + replicate).map(|c| (c * 16_777_216.0) as u32))
            .collect();
        assert!((0..=8).all(|a| one_in_each(&points, 8, a)), "replicate {replicate}");
    }
    // Means over replicates of a smooth function are independent: their covariance, over pixels, is zero
    // within four deviations, 4 / sqrt(2000) of the variance.
    for sampler in [Sampler::Stratified, Sampler::Owen] {
        let mean = |pixel: u32, replicate: u32| {
            (0..16)
                .map(|i| offset(sampler, 2, 5, pixel, 9, 2 * i + replicate, MANY))
                .map(|[x, y]| f64::from(x) * f64::from(y) - 0.25)
                .sum::<f64>()
        };
        let pairs: Vec<_> = (0..2000).map(|pixel| (mean(pixel, 0), mean(pixel, 1))).collect();
        let sum = |f: &dyn Fn(&(f64, f64)) -> f64| pairs.iter().map(f).sum::<f64>();
        let correlation = sum(&|p| p.0 * p.1) / (sum(&|p| p.0 * p.0) * sum(&|p| p.1 * p.1)).sqrt();
        assert!(correlation.abs() < 4.0 / 2000f64.sqrt(), "{}: {correlation}", sampler.name());
    }
}

#[test]
fn the_second_dimension_is_sobols() {
    // Kollig and Keller, "Efficient Multidimensional Sampling", CGF 21(3), 2002: direction numbers by
    // recurrence.
    for index in (0..5000).chain([u32::MAX, 0x8000_0000, 0xdead_beef]) {
        let (mut i, mut v, mut r) = (index, 1u32 << 31, 0);
        while i != 0 {
            r ^= if i & 1 == 1 { v } else { 0 };
            (i, v) = (i >> 1, v ^ (v >> 1));
        }
        assert_eq!(sobol_1_reversed(index).reverse_bits(), r, "{index}");
    }
}

#[test]
fn scrambling_is_nested() {
    // Low bits depend on low bits alone, and no two numbers meet.
    for seed in [0, 1, 0x8000_0000, 0xdead_beef, u32::MAX] {
        for bits in 1..12 {
            let mask = (1u32 << bits) - 1;
            let mut seen = vec![false; 1 << bits];
            for v in 0..=mask {
                let low = scramble_reversed(v, seed) & mask;
                assert_eq!(low, scramble_reversed(v | 0xabcd_e000, seed) & mask);
                seen[low as usize] = true;
            }
            assert!(seen.into_iter().all(|s| s), "{bits} bits, seed {seed}");
        }
    }
}

#[test]
fn owen_points_fill_every_elementary_interval() {
    for pixel in 0..20 {
        let points = points(Sampler::Owen, pixel, 1 << 12);
        for m in 0..=12 {
            assert!((0..=m).all(|a| one_in_each(&points, m, a)), "pixel {pixel}, 2^{m} points");
        }
    }
    // The others do not.
    for sampler in [Sampler::Random, Sampler::Stratified] {
        assert!((0..=8).any(|a| !one_in_each(&points(sampler, 0, 256), 8, a)));
    }
}

#[test]
fn stratified_points_fill_every_cell() {
    for pixel in 0..20 {
        let points = points(Sampler::Stratified, pixel, 1 << 14);
        assert!((0..=7).all(|m| one_in_each(&points, 2 * m, m)), "pixel {pixel}");
    }
    assert!(!one_in_each(&points(Sampler::Random, 0, 256), 8, 4));
}

/// An integrand over the unit square with its exact mean.
struct Pixel {
    value: Box<dyn Fn(f64, f64) -> f64>,
    mean: f64,
}

fn units(count: u32) -> impl Iterator<Item = [f64; 4]> {
    (0..count).map(|i| pcg4d([i, 1, 2, 3]).map(|h| (f64::from(h) + 0.5) / 4_294_967_296.0))
}

/// Half planes through a random point in a random direction: pixels on an edge. The share of the unit
/// square in p x + q y < c, for p, q > 0 (mirrored otherwise), is a sum of the triangles that the line
/// cuts off.
fn edges(count: u32) -> Vec<Pixel> {
    units(count)
        .map(|[x, y, angle, _]| {
            let (q, p) = (TAU * angle).sin_cos();
            let c = p * x + q * y;
            // Mirrored to positive coefficients.
            let d = c - p.min(0.0) - q.min(0.0);
            let corner = |z: f64| z.max(0.0).powi(2);
            let (a, b) = (p.abs(), q.abs());
            let mean = (corner(d) - corner(d - a) - corner(d - b) + corner(d - a - b)) / (2.0 * a * b);
            Pixel { value: Box::new(move |x, y| f64::from(u8::from(p * x + q * y < c))), mean }
        })
        .collect()
}

/// exp(p x + q y), scaled to a mean of 1: smooth pixels.
fn smooth(count: u32) -> Vec<Pixel> {
    units(count)
        .map(|[u, v, ..]| {
            let (p, q) = (1.0 + 2.0 * u, 1.0 + 2.0 * v);
            let mean = (p.exp() - 1.0) / p * (q.exp() - 1.0) / q;
            Pixel { value: Box::new(move |x, y| (p * x + q * y).exp() / mean), mean: 1.0 }
        })
        .collect()
}

/// Slope of log RMSE over log N, for N = 4, 8, ... 1024, by least squares.
fn slope(pixels: &[Pixel], points: impl Fn(u32, u32) -> [f64; 2]) -> f64 {
    let mut squares = [0.0; 9];
    for (i, pixel) in pixels.iter().enumerate() {
        let mut sum = 0.0;
        for k in 0..1024u32 {
            let [x, y] = points(i as u32, k);
            sum += (pixel.value)(x, y);
            let n = k + 1;
            if n >= 4 && n.is_power_of_two() {
                squares[n.trailing_zeros() as usize - 2] += (sum / f64::from(n) - pixel.mean).powi(2);
            }
        }
    }
    let ys = squares.map(|s| 0.5 * s.log2());
    let mean = ys.iter().sum::<f64>() / 9.0;
    // Abscissae -4 to 4: their squares add up to 60.
    ys.iter().zip(-4i32..).map(|(y, x)| f64::from(x) * (y - mean)).sum::<f64>() / 60.0
}

const TOLERANCE: f64 = 0.06;

#[test]
fn errors_fall_as_fast_as_they_must() {
    let (edges, smooth) = (edges(400), smooth(400));
    let points =
        |sampler| move |pixel, k| offset(sampler, 1, 11, pixel % 20, pixel / 20, k, 1024).map(f64::from);
    for (sampler, at_edges, in_smooth) in
        [(Sampler::Random, -0.50, -0.50), (Sampler::Stratified, -0.76, -0.98), (Sampler::Owen, -0.76, -1.37)]
    {
        let found = [slope(&edges, points(sampler)), slope(&smooth, points(sampler))];
        println!("{}: edge {:.3}, smooth {:.3}", sampler.name(), found[0], found[1]);
        for (found, want) in found.into_iter().zip([at_edges, in_smooth]) {
            assert!((found - want).abs() < TOLERANCE, "{}: {found} for {want}", sampler.name());
        }
    }

    // What is not scrambled, or has strata in one dimension only, falls short.
    let unscrambled =
        |_, k: u32| [k, sobol_1_reversed(k)].map(|c| f64::from(c.reverse_bits()) / 4_294_967_296.0);
    let found = slope(&smooth, unscrambled);
    println!("unscrambled: smooth {found:.3}");
    assert!(found > -1.37 + TOLERANCE, "{found}");
    let same_strata = |pixel, k| {
        let [x, _] = offset(Sampler::Stratified, 1, 11, pixel, 0, k, 1024);
        [x, offset(Sampler::Random, 1, 11, pixel, 0, k, 1024)[1]].map(f64::from)
    };
    let found = [slope(&edges, same_strata), slope(&smooth, same_strata)];
    println!("strata in x alone: edge {:.3}, smooth {:.3}", found[0], found[1]);
    assert!(found[0] > -0.76 + TOLERANCE && found[1] > -0.98 + TOLERANCE, "{found:?}");
}

/// Sums that a hash whose low bits are poor makes wrong: the scramble takes the top bit of a coordinate from them.
/// For a pixel of which the left half is lit, the number of lit ones among `sets` first points of `sets` replicates is
/// binomial; with the hash as published its variance was twice that. 4 sigma of the chi-square over 40,000 pixels.
#[test]
fn the_first_points_of_replicates_are_independent() {
    for sampler in [Sampler::Stratified, Sampler::Owen] {
        for sets in [4u32, 8, 16] {
            let pixels = 40_000u32;
            let points = |pixel: u32| {
                (0..sets).map(move |k| offset(sampler, sets, 7, pixel % 200, pixel / 200, k, MANY))
            };
            for bit in 1..=3 {
                for axis in 0..2 {
                    let lit = |p: &[f32; 2]| (p[axis] * f32::exp2(bit as f32)) as u32 & 1 == 1;
                    // Pairs of sets that agree, per pair: half of all.
                    let mut agree = vec![0u32; (sets * sets) as usize];
                    let mut counts = vec![0.0; sets as usize + 1];
                    for pixel in 0..pixels {
                        let bits: Vec<bool> = points(pixel).map(|p| lit(&p)).collect();
                        counts[bits.iter().filter(|b| **b).count()] += 1.0;
                        for i in 0..sets as usize {
                            for j in 0..i {
                                agree[i * sets as usize + j] += u32::from(bits[i] == bits[j]);
                            }
                        }
                    }
                    let n = f64::from(pixels);
                    for i in 0..sets as usize {
                        for j in 0..i {
                            let share = f64::from(agree[i * sets as usize + j]) / n;
                            // 5 sigma: there are 2 * 3 * 148 * 2 such pairs.
                            let off = (share - 0.5).abs() * 2.0 * n.sqrt();
                            assert!(
                                off < 5.0,
                                "{} sets {i}, {j} of {sets}, bit {bit}, axis {axis}: {share}",
                                sampler.name()
                            );
                        }
                    }
                    // The variance of the mean over sets is that of independent ones; its relative deviation is
                    // sqrt(2 / pixels), less a little for the binomial's kurtosis.
                    let s = f64::from(sets);
                    let variance: f64 =
                        counts.iter().enumerate().map(|(k, c)| c * (k as f64 - s / 2.0).powi(2)).sum::<f64>()
                            / n;
                    let ratio = variance / (s / 4.0);
                    assert!(
                        (ratio - 1.0).abs() < 5.0 * (2.0 / n).sqrt(),
                        "{} {sets}: {ratio}",
                        sampler.name()
                    );
                }
            }
        }
    }
}

/// The variance that independent replicates state, tr(S)/R, is that of their mean: at 4, 8 and 16 samples in 2 and 4
/// sets, for an edge, over 20,000 pixels.
#[test]
fn replicates_state_the_variance_of_their_mean() {
    for sampler in Sampler::ALL {
        for (samples, sets) in [(4u32, 2u32), (4, 4), (8, 2), (8, 4), (16, 4), (16, 16)] {
            let (mut stated, mut squares, pixels) = (0.0, 0.0, 20_000u32);
            for pixel in 0..pixels {
                // An edge through the pixel at an angle and a place of its own.
                let a = f64::from(pixel) * 2.399_963;
                let (nx, ny) = (a.cos(), a.sin());
                let cut = 0.5 * (nx + ny) + 0.6 * ((f64::from(pixel) * 0.618_034).fract() - 0.5);
                let mut sums = vec![0.0; sets as usize];
                for k in 0..samples {
                    let [x, y] = offset(sampler, sets, 3, pixel % 200, pixel / 200, k, MANY).map(f64::from);
                    sums[(k % sets) as usize] += f64::from(u8::from(nx * x + ny * y < cut));
                }
                let (r, each) = (f64::from(sets), f64::from(samples / sets));
                let mean = sums.iter().sum::<f64>() / f64::from(samples);
                stated += sums.iter().map(|s| (s / each - mean).powi(2)).sum::<f64>() / (r * (r - 1.0));
                squares += (mean - crate::accuracy::synthetic::edge_area(nx, ny, cut)).powi(2);
            }
            let ratio = stated / squares;
            println!("{} {samples} in {sets}: stated / true variance {ratio:.3}", sampler.name());
            assert!((0.93..1.07).contains(&ratio), "{} {samples} in {sets}: {ratio}", sampler.name());
        }
    }
}

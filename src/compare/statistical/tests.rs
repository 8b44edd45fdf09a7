//! Synthetic noise with fixed seeds: how often the test raises a false alarm, and what it catches.

use super::*;

const WIDTH: usize = 64;
const HEIGHT: usize = 48;

/// splitmix64 (Steele, Lea and Flood, OOPSLA 2014): uniform numbers in (0, 1).
struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 11) as f64 / (1u64 << 53) as f64 + 1e-17
    }

    /// Box and Muller, 1958.
    fn normal(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (2.0 * PI * self.uniform()).cos()
    }
}

/// A kind of noise: the value of a channel at a place.
type Noise = fn(&mut Random, usize, usize) -> f64;

/// Normal, of a standard deviation that differs from place to place.
fn uneven(random: &mut Random, x: usize, y: usize) -> f64 {
    0.5 + (0.002 + 0.05 * ((x * y) % 7) as f64 / 7.0) * random.normal()
}

/// Very skewed: mostly dark, at times bright, as of few samples of a small light.
fn skewed(random: &mut Random, _: usize, _: usize) -> f64 {
    if random.uniform() < 0.05 { 0.8 } else { 0.1 }
}

/// Noise on one column in eight, as at edges; elsewhere equal.
fn edges(random: &mut Random, x: usize, _: usize) -> f64 {
    if x.is_multiple_of(8) { (random.uniform() * 4.0).floor() / 4.0 } else { 0.3 }
}

fn picture(noise: Noise, seed: u64) -> Vec<[f32; 3]> {
    let mut random = Random(seed << 32);
    (0..WIDTH * HEIGHT)
        .map(|i| std::array::from_fn(|_| noise(&mut random, i % WIDTH, i / WIDTH) as f32))
        .collect()
}

fn statistics(a: &[[f32; 3]], b: &[[f32; 3]], significance: f64) -> Statistics {
    test(a, b, WIDTH, significance).unwrap().statistics
}

/// False alarms in `trials` pairs of pictures that agree.
fn alarms(noise: Noise, trials: u64, significance: f64) -> u64 {
    (0..trials)
        .filter(|k| {
            let s = statistics(&picture(noise, 2 * k + 1), &picture(noise, 2 * k + 2), significance);
            assert!(!s.exact);
            s.significant
        })
        .count() as u64
}

#[test]
fn false_alarms_are_as_rare_as_asked_for() {
    let trials = 400;
    for (name, noise) in [("uneven", uneven as Noise), ("skewed", skewed), ("edges", edges)] {
        for significance in [0.01, 0.2] {
            let count = alarms(noise, trials, significance) as f64;
            // Expected at most alpha trials; three standard deviations of that count above it.
            let most = significance * trials as f64;
            assert!(count <= most + 3.0 * most.sqrt(), "{name}, {significance}: {count} of {trials}");
        }
    }
    // The test is not blind: the factor c of about 3.18 leaves about half of an alpha of 0.9.
    let count = alarms(uneven, 100, 0.9);
    assert!(count > 15, "{count} of 100");
}

#[test]
fn a_test_without_the_correction_is_noticed() {
    // Planted: every block tested at alpha itself.
    let raised = (0..40u64).filter(|k| {
        let s = statistics(&picture(uneven, 2 * k + 1), &picture(uneven, 2 * k + 2), 0.2);
        s.worst.unwrap().p < 0.2
    });
    assert!(raised.count() > 30);
}

#[test]
fn a_bias_in_one_place_is_caught_there() {
    // As much as the mean noise of a pixel; half as much as that of an edge.
    for (noise, bias) in [(uneven as Noise, 0.04), (edges, 0.2)] {
        let (a, mut b) = (picture(noise, 1), picture(noise, 2));
        assert!(!statistics(&a, &b, 0.01).significant);
        // 16 x 16 pixels.
        for (x, y) in (20..36).flat_map(|x| (10..26).map(move |y| (x, y))) {
            b[y * WIDTH + x][1] += bias;
        }
        let tested = test(&a, &b, WIDTH, 0.01).unwrap();
        let s = &tested.statistics;
        let worst = s.worst.as_ref().unwrap();
        assert!(s.significant && !s.exact && worst.channel == "green" && worst.z < -s.threshold, "{s:?}");
        let [x0, y0, x1, y1] = worst.region;
        assert!(x0 < 36 && x1 > 20 && y0 < 26 && y1 > 10, "{worst:?}");
        assert!(tested.map[18 * WIDTH + 28] > s.threshold && tested.map[0] < s.threshold);
    }
}

#[test]
fn a_small_bias_everywhere_is_caught_by_the_whole_picture() {
    let (a, mut b) = (picture(uneven, 1), picture(uneven, 2));
    b.iter_mut().for_each(|p| p[0] += 0.008);
    let s = statistics(&a, &b, 0.01);
    let worst = s.worst.unwrap();
    assert!(s.significant && worst.channel == "red", "{worst:?}");
    assert_eq!(worst.region, [0, 0, WIDTH as u32, HEIGHT as u32]);
    assert!(
        test(&a, &b, WIDTH, 0.01).unwrap().map.iter().all(|z| *z < s.threshold),
        "no small block sees it"
    );
}

#[test]
fn pictures_without_noise_are_compared_exactly() {
    let plain = vec![[0.5f32; 3]; WIDTH * HEIGHT];
    let s = statistics(&plain, &plain, 0.01);
    assert!(s.exact && !s.significant && s.worst.is_none() && s.differing_pixels == 0);
    let mut wrong = plain.clone();
    wrong[77][2] += 1e-3;
    let s = statistics(&plain, &wrong, 0.01);
    assert!(s.exact && s.significant && s.differing_pixels == 1, "{s:?}");
    // The same offset everywhere has no variance about its mean: z is the greatest there is.
    let offset: Vec<[f32; 3]> = plain.iter().map(|p| p.map(|c| c + 1e-4)).collect();
    let s = statistics(&plain, &offset, 0.01);
    assert!(s.significant && !s.exact);
    assert!((s.worst.unwrap().z.abs() - ((WIDTH * HEIGHT) as f64).sqrt()).abs() < 1e-6);
}

#[test]
fn what_cannot_be_tested_says_why() {
    let plain = [[0.5f32; 3]; 12];
    assert!(matches!(test(&plain, &plain[1..], 4, 0.01), Err(CannotTest::Size(_))));
    assert!(matches!(test(&plain, &plain, 5, 0.01), Err(CannotTest::Size(_))));
    let error = test(&plain[..8], &plain[..8], 4, 0.01).err().unwrap().to_string();
    assert!(error.contains("8 pixels") && error.contains("at least 11 pixels"), "{error}");
    let nan = [[f32::NAN; 3]; 64];
    assert_eq!(test(&nan, &nan, 8, 0.01).unwrap().statistics.differing_pixels, 64);
}

#[test]
fn blocks_cover_the_picture_once_per_size() {
    for (width, height, sizes) in [(64, 48, 3), (7, 3, 1), (100, 75, 3), (9, 200, 3), (31, 31, 2)] {
        let blocks = blocks(width, height);
        let mut covered = vec![0; width * height];
        for [x0, y0, x1, y1] in &blocks {
            assert!(x1 - x0 >= SIDES[0].min(width) && y1 - y0 >= SIDES[0].min(height));
            (*y0..*y1).for_each(|y| covered[y * width + x0..y * width + x1].iter_mut().for_each(|c| *c += 1));
        }
        assert!(covered.iter().all(|c| *c == sizes), "{width}x{height}: {blocks:?}");
        assert_eq!(blocks.last(), Some(&[0, 0, width, height]));
    }
}

#[test]
fn tails_and_corrections_are_those_of_the_tables() {
    // Abramowitz and Stegun, tables 26.1 and 26.2.
    for (x, q) in [(0.0, 0.5), (1.0, 0.158_655_253_9), (3.0, 1.349_898_03e-3), (5.0, 2.866_515_7e-7)] {
        assert!((normal_above(x) / q - 1.0).abs() < 1e-7, "{x}: {}", normal_above(x));
    }
    assert!((normal_above(3.0_f64.next_down()) / normal_above(3.0) - 1.0).abs() < 1e-10);
    assert!((corrected(0.01, 1) - 0.01).abs() < 1e-15);
    assert!((corrected(0.05, 10) - 0.005_116_196_891).abs() < 1e-11);
    for p in [0.2, 1e-3, 1e-9] {
        assert!((bound(threshold(p)) / p - 1.0).abs() < 1e-9);
    }
}

/// The bound of Bentkus and Dzindzalieta, against all signs of short sums with unequal weights.
#[test]
fn the_bound_holds_for_every_sum_of_signs() {
    for shape in 0..4u32 {
        let weights: Vec<f64> = (1..=14).map(|k| f64::from(k).powf(-f64::from(shape) / 2.0)).collect();
        let norm = weights.iter().map(|w| w * w).sum::<f64>().sqrt();
        let mut sums: Vec<f64> = (0..1u32 << 14)
            .map(|signs| {
                let signed =
                    weights.iter().enumerate().map(|(i, w)| if signs >> i & 1 == 0 { *w } else { -w });
                signed.sum::<f64>().abs() / norm
            })
            .collect();
        sums.sort_by(f64::total_cmp);
        for (rank, x) in sums.iter().enumerate() {
            let share = (sums.len() - rank) as f64 / sums.len() as f64;
            assert!(share <= bound(x - 1e-9), "shape {shape}: P(|z| >= {x}) = {share}");
        }
    }
}

use super::*;
use crate::render::samples::Mark;
use crate::settings::sampler::pcg4d;
use std::convert::Infallible;
use std::ops::Range;

/// Pixel p is p / 8 plus independent noise of standard deviation `noise(p)`.
struct Noisy {
    noise: fn(u32) -> f64,
    traced: u64,
}

impl Source for Noisy {
    type Error = Infallible;

    fn replicates(&self) -> usize {
        REPLICATES as usize
    }

    fn trace(&mut self, pixels: &[u32], samples: Range<u32>) -> Result<Traced, Infallible> {
        self.traced += pixels.len() as u64 * u64::from(samples.end - samples.start);
        let mut traced = Traced { replicates: REPLICATES as usize, ..Traced::default() };
        for pixel in pixels {
            let mut sums = [[0.0; 3]; REPLICATES as usize];
            for k in samples.clone() {
                let word = pcg4d([*pixel, k, 17, 4])[0];
                // Uniform of unit variance: (u - 1/2) sqrt 12.
                let noise = (f64::from(word) / 2f64.powi(32) - 0.5) * 12f64.sqrt() * (self.noise)(*pixel);
                sums[(k % REPLICATES) as usize][0] += f64::from(*pixel) / 8.0 + noise;
            }
            traced.sums.extend(sums);
            traced.marks.push(Mark::default());
        }
        Ok(traced)
    }
}

fn identity() -> Identity {
    Identity { width: 4, height: 2, depth: 3, scene: "s".into(), ..Identity::default() }
}

fn noisy_half(pixel: u32) -> f64 {
    if pixel.is_multiple_of(2) { 0.1 } else { 0.0 }
}

#[test]
fn it_stops_at_the_target_and_spends_samples_where_the_noise_is() {
    let mut truth = Truth::new(identity(), None);
    let mut source = Noisy { noise: noisy_half, traced: 0 };
    truth.refine(&mut source, 1e-3, 1 << 20, &mut |_, _, _, _| ()).unwrap();
    let info = truth.info(0.02);
    // Half of the pixels, one channel of three: sigma^2 / n / 6 = target^2 wants n = 1667, so 2048, or twice that where
    // chance makes the estimate too high.
    let most = info.samples_most;
    assert!(info.standard_error <= 1e-3 && info.converged && [2048, 4096].contains(&most), "{info:?}");
    assert!(!truth.info(0.002).converged);
    assert_eq!(source.traced, 4 * u64::from(most) + 4 * 64);
    // The estimate of its own error is right: pixels 0, 2, 4, 6 lie within five of it.
    for (p, colour) in truth.linear().iter().enumerate() {
        assert!((colour.x - p as f64 / 8.0).abs() <= 5.0 * 0.1 / 2048f64.sqrt(), "{p}: {colour}");
    }
}

#[test]
fn the_cap_holds_and_a_later_run_goes_on() {
    let mut truth = Truth::new(identity(), None);
    let mut source = Noisy { noise: noisy_half, traced: 0 };
    truth.refine(&mut source, 1e-9, 300, &mut |_, _, _, _| ()).unwrap();
    assert_eq!(truth.info(1.0).samples_most, 288);
    truth.refine(&mut source, 1e-9, 1024, &mut |_, _, _, _| ()).unwrap();
    let mut whole = Truth::new(identity(), None);
    whole.refine(&mut Noisy { noise: noisy_half, traced: 0 }, 1e-9, 1024, &mut |_, _, _, _| ()).unwrap();
    assert_eq!(truth.info(1.0).samples_most, whole.info(1.0).samples_most);
    for (a, b) in truth.linear().iter().zip(whole.linear()) {
        assert!(a.distance(b) < 1e-12);
    }
}

#[test]
fn what_is_saved_comes_back_and_another_or_a_damaged_one_does_not() {
    let mut truth = Truth::new(
        identity(),
        Some(truncation(&[([0.5; 3], 0.25)], &RadianceLimit { rgb: [1.0; 3], unbounded: None })),
    );
    truth.refine(&mut Noisy { noise: noisy_half, traced: 0 }, 1e-3, 256, &mut |_, _, _, _| ()).unwrap();
    let mut bytes = Vec::new();
    truth.save(&mut bytes).unwrap();
    let load = |bytes: &[u8], identity: &Identity| Truth::load(&mut &bytes[..], identity).unwrap();
    assert_eq!(load(&bytes, &identity()), Some(truth));
    assert_eq!(load(&bytes, &Identity { depth: 4, ..identity() }), None);
    assert_eq!(load(&bytes[..bytes.len() - 1], &identity()), None);
    let last = bytes.len() - 9;
    bytes[last] ^= 1;
    assert_eq!(load(&bytes, &identity()), None);
    assert_eq!(load(b"\xff\xfe", &identity()), None);
}

#[test]
fn the_limit_of_two_ways_is_their_bias_without_their_noise() {
    let trace = |noise| Noisy { noise, traced: 0 }.trace(&[1, 2, 3], 0..64).unwrap();
    let a = trace(|_| 0.1);
    let mut b = a.clone();
    assert_eq!(limit_error(&a, &b, 64), 0.0);
    // Green lighter by 0.01 everywhere: over three channels that is 0.01 / sqrt 3.
    b.sums.iter_mut().for_each(|s| s[1] += 0.01 * 4.0);
    assert!((limit_error(&b, &a, 64) - 0.01 / 3f64.sqrt()).abs() < 1e-12);
    // Noise of its own, without bias: what is left is well under the noise of the means, 0.1 / 8.
    let c = trace(|p| if p > 5 { 0.0 } else { -0.1 });
    assert!(limit_error(&a, &c, 64) < 0.02);
}

#[test]
fn white_beyond_doubt_has_no_error() {
    let sums = |level: f64| std::array::from_fn::<_, 16, _>(|r| [level + 0.01 * (r % 2) as f64, 0.0, 0.0]);
    assert!(variance_shown(&sums(0.5), 16) > 0.0);
    assert_eq!(variance_shown(&sums(1.5), 16), 0.0);
    assert_eq!(variance_shown(&sums(0.5), 0), f64::INFINITY);
}

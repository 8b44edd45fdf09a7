//! Against the authors' own code (crate `nv-flip`, C++ in f32), and against what the definition says.

use super::*;
use crate::settings::sampler::pcg4d;

const WIDTH: usize = 64;
const HEIGHT: usize = 48;

/// 8-bit sRGB codes of a picture with edges, ramps and saturated colours.
fn codes() -> Vec<[u8; 3]> {
    (0..WIDTH * HEIGHT)
        .map(|i| {
            let (x, y) = (i % WIDTH, i / WIDTH);
            match (x / 16, y / 16) {
                (0, _) => [(4 * y) as u8, 128, 30],
                (1, 0) => [255, 0, 0],
                (1, 1) => [0, 255, 0],
                (2, 0) => [0, 0, 255],
                (2, 1) => [255; 3],
                (3, _) => [((x * y) % 256) as u8, (3 * x) as u8, (5 * y) as u8],
                _ => [20, 20, (8 * (x % 32)) as u8],
            }
        })
        .collect()
}

fn noisy(amplitude: u32) -> Vec<[u8; 3]> {
    let noise = |i: usize, c: usize| pcg4d([i as u32, c as u32, 7, 11])[0] % (2 * amplitude + 1);
    (0..)
        .zip(codes())
        .map(|(i, p)| {
            std::array::from_fn(|c| (u32::from(p[c]) + noise(i, c)).saturating_sub(amplitude).min(255) as u8)
        })
        .collect()
}

fn decoded(codes: &[[u8; 3]]) -> Vec<DVec3> {
    codes.iter().map(|p| DVec3::from_array(p.map(|c| crate::image::linear8(c).into()))).collect()
}

fn map(a: &[[u8; 3]], b: &[[u8; 3]]) -> Vec<f64> {
    flip(&decoded(a), &decoded(b), WIDTH, PIXELS_PER_DEGREE).unwrap()
}

fn authors(a: &[[u8; 3]], b: &[[u8; 3]]) -> Vec<f32> {
    let image = |codes: &[[u8; 3]]| {
        nv_flip::FlipImageRgb8::with_data(WIDTH as u32, HEIGHT as u32, codes.as_flattened())
    };
    nv_flip::flip(image(a), image(b), PIXELS_PER_DEGREE as f32).to_vec()
}

fn farthest(ours: &[f64], theirs: &[f32]) -> f64 {
    ours.iter().zip(theirs).map(|(a, b)| (a - f64::from(*b)).abs()).fold(0.0, f64::max)
}

#[test]
fn every_pixel_is_that_of_the_authors_code() {
    let picture = codes();
    let mut shifted = picture.clone();
    shifted.rotate_right(1);
    let mut swapped = picture.clone();
    swapped.iter_mut().for_each(|p| p.swap(0, 2));
    let mut dot = picture.clone();
    dot[24 * WIDTH + 5] = [255, 0, 255];
    for (name, other) in [("shift", shifted), ("swap", swapped), ("dot", dot), ("noise", noisy(40))] {
        let (ours, theirs) = (map(&picture, &other), authors(&picture, &other));
        // The other code is f32 throughout, and takes a square root of differences of features.
        let worst = farthest(&ours, &theirs);
        assert!(worst < 1e-4, "{name}: {worst}");
        let average = theirs.iter().map(|e| f64::from(*e)).sum::<f64>() / theirs.len() as f64;
        assert!((mean(&ours) - average).abs() < 1e-5, "{name}: {} and {average}", mean(&ours));
        assert!(mean(&ours) > 1e-4, "{name} is not noticed");
        // Planted defect: the picture read with another number of pixels per degree.
        let wrong = flip(&decoded(&picture), &decoded(&other), WIDTH, 0.8 * PIXELS_PER_DEGREE).unwrap();
        assert!(farthest(&wrong, &theirs) > 5e-3, "{name}: the comparison notices nothing");
    }
}

#[test]
fn equal_pictures_differ_nowhere() {
    assert!(map(&codes(), &codes()).iter().all(|e| *e == 0.0));
    assert_eq!(mean(&[]), 0.0);
}

#[test]
fn the_scale_ends_where_the_definition_says() {
    let flat = |color: DVec3| vec![color; WIDTH * HEIGHT];
    let worst = flip(&flat(DVec3::Y), &flat(DVec3::Z), WIDTH, PIXELS_PER_DEGREE).unwrap();
    assert!(worst.iter().all(|e| (e - 1.0).abs() < 1e-12), "green and blue are farthest apart: {}", worst[0]);
    // Black and white: HyAB is 100, the difference in lightness alone.
    let largest = distance(hunt_lab(DVec3::Y), hunt_lab(DVec3::Z)).powf(COLOR_EXPONENT);
    let expected = redistributed(100f64.powf(COLOR_EXPONENT), largest);
    let grey = flip(&flat(DVec3::ZERO), &flat(DVec3::ONE), WIDTH, PIXELS_PER_DEGREE).unwrap();
    assert!(grey.iter().all(|e| (e - expected).abs() < 1e-9), "{} and {expected}", grey[0]);
    assert!(expected > 0.95 && expected < 1.0);
}

#[test]
fn either_picture_may_be_the_reference() {
    assert_eq!(map(&codes(), &noisy(25)), map(&noisy(25), &codes()));
}

#[test]
fn more_noise_looks_more_different() {
    let means = [0, 2, 8, 32, 100].map(|amplitude| mean(&map(&codes(), &noisy(amplitude))));
    assert!(means.is_sorted_by(|a, b| a < b), "{means:?}");
}

#[test]
fn filters_keep_a_flat_picture_and_detectors_ignore_it() {
    for terms in SENSITIVITY {
        let parts = sensitivity(terms, 10, PIXELS_PER_DEGREE);
        let total: f64 = parts.iter().map(|(weight, taps)| weight * taps.iter().sum::<f64>().powi(2)).sum();
        assert!((total - 1.0).abs() < 1e-12);
    }
    let detectors = Detectors::new(PIXELS_PER_DEGREE);
    for taps in [&detectors.edge, &detectors.point] {
        assert!(taps.iter().sum::<f64>().abs() < 1e-12);
    }
    for color in [DVec3::new(0.2, 0.5, 0.9), DVec3::X] {
        assert!((linear(ycxcz(color)) - color).length() < 1e-12);
    }
}

#[test]
fn pictures_of_other_sizes_are_refused() {
    let p = [DVec3::ZERO; 6];
    assert!(flip(&p, &p[..5], 1, 60.0).is_err());
    assert!(flip(&p, &p, 4, 60.0).is_err() && flip(&p, &p, 0, 60.0).is_err());
    assert!(flip(&p, &p, 6, 60.0).is_ok() && flip(&p[..0], &p[..0], 6, 60.0).is_ok());
}

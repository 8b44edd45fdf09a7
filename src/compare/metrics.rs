//! How far one image is from another.

use crate::image::code8;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A linear RGB pixel of any precision.
pub trait Rgb {
    /// Red, green and blue.
    fn rgb(&self) -> [f64; 3];
}

impl Rgb for DVec3 {
    fn rgb(&self) -> [f64; 3] {
        self.to_array()
    }
}

impl Rgb for [f64; 3] {
    fn rgb(&self) -> [f64; 3] {
        *self
    }
}

impl Rgb for [f32; 3] {
    fn rgb(&self) -> [f64; 3] {
        self.map(f64::from)
    }
}

/// The images cannot be laid over each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("images of {0} and {1} pixels cannot be compared; render both at the same size")]
pub struct SizeMismatch(pub usize, pub usize);

/// Difference of two images in linear light clamped to [0, 1], as it will be shown. A pixel's error is
/// that of its worst channel; a channel that is not a number counts as wholly wrong (error 1, 255 codes).
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Metrics {
    /// Root mean square over all channels.
    pub rmse: f64,
    /// Mean over all channels.
    pub mean_abs: f64,
    /// Largest pixel error.
    pub max_abs: f64,
    /// 99.9th percentile of the pixel errors (nearest rank).
    pub p999: f64,
    /// Decibels below full scale: `-20 log10(rmse)`; `None` where the images are equal.
    pub psnr: Option<f64>,
    /// Pixels that differ at all after clamping.
    pub differing_pixels: u64,
    /// Pixels with a channel that is not a number, in either image.
    pub nan_pixels: u64,
    /// Mean over all channels in 8-bit sRGB codes.
    pub code_mean: f64,
    /// Largest difference in 8-bit sRGB codes.
    pub code_max: u8,
    /// Pixels whose 8-bit sRGB codes differ.
    pub code_differing_pixels: u64,
}

/// Compares two images pixel by pixel.
///
/// # Errors
/// If they differ in length.
pub fn compare<A: Rgb, B: Rgb>(a: &[A], b: &[B]) -> Result<Metrics, SizeMismatch> {
    check_sizes(a.len(), b.len())?;
    let mut m = Metrics::default();
    let mut errors = Vec::with_capacity(a.len());
    let (mut squares, mut sum, mut codes) = (0.0, 0.0, 0u64);
    for (a, b) in a.iter().zip(b) {
        let (mut worst, mut worst_code, mut nan) = (0.0f64, 0u8, false);
        for (a, b) in a.rgb().into_iter().zip(b.rgb()) {
            nan |= a.is_nan() || b.is_nan();
            let (error, code) = difference(a, b);
            squares += error * error;
            sum += error;
            codes += u64::from(code);
            worst = worst.max(error);
            worst_code = worst_code.max(code);
        }
        m.nan_pixels += u64::from(nan);
        m.differing_pixels += u64::from(worst > 0.0);
        m.code_differing_pixels += u64::from(worst_code > 0);
        m.code_max = m.code_max.max(worst_code);
        errors.push(worst);
    }
    let Some(last) = errors.len().checked_sub(1) else { return Ok(m) };
    let channels = 3.0 * errors.len() as f64;
    m.rmse = (squares / channels).sqrt();
    m.mean_abs = sum / channels;
    m.code_mean = codes as f64 / channels;
    m.psnr = (m.rmse > 0.0).then(|| -20.0 * m.rmse.log10());
    errors.sort_by(f64::total_cmp);
    m.max_abs = errors[last];
    m.p999 = errors[((0.999 * errors.len() as f64).ceil() as usize).saturating_sub(1).min(last)];
    Ok(m)
}

/// [`Metrics::rmse`] alone, which takes much less time.
///
/// # Errors
/// If the images differ in length.
pub fn rmse<A: Rgb, B: Rgb>(a: &[A], b: &[B]) -> Result<f64, SizeMismatch> {
    check_sizes(a.len(), b.len())?;
    let channels = a.iter().zip(b).flat_map(|(a, b)| a.rgb().into_iter().zip(b.rgb()));
    let squares: f64 = channels.map(|(a, b)| clamped_difference(a, b).powi(2)).sum();
    Ok((squares / (3.0 * a.len().max(1) as f64)).sqrt())
}

/// Difference of one channel, 1 if either is not a number.
fn clamped_difference(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { 1.0 } else { (a.clamp(0.0, 1.0) - b.clamp(0.0, 1.0)).abs() }
}

/// Difference of one channel, and the same in 8-bit sRGB codes.
fn difference(a: f64, b: f64) -> (f64, u8) {
    if a.is_nan() || b.is_nan() {
        return (1.0, u8::MAX);
    }
    (clamped_difference(a, b), code8(a as f32).abs_diff(code8(b as f32)))
}

/// A pixel's error, that of its worst channel, and the same in 8-bit sRGB codes; as in [`Metrics`].
pub fn pixel_error<A: Rgb, B: Rgb>(a: &A, b: &B) -> (f64, u8) {
    let channels = a.rgb().into_iter().zip(b.rgb()).map(|(a, b)| difference(a, b));
    channels.fold((0.0, 0), |worst, d| (worst.0.max(d.0), worst.1.max(d.1)))
}

fn check_sizes(a: usize, b: usize) -> Result<(), SizeMismatch> {
    if a == b { Ok(()) } else { Err(SizeMismatch(a, b)) }
}

/// Samples whose first hit is another primitive.
///
/// # Errors
/// If the maps differ in length.
pub fn hit_mismatches(a: &[Option<u32>], b: &[Option<u32>]) -> Result<u64, SizeMismatch> {
    check_sizes(a.len(), b.len())?;
    Ok(a.iter().zip(b).filter(|(a, b)| a != b).count() as u64)
}

/// Length of all edges in a map of first hits with one entry per pixel, in pixels: sides between
/// neighbours that see different primitives. A slanted edge counts up to sqrt 2 times its length, so a
/// bound made from it is on the safe side. `None` if `width` does not divide the map.
pub fn edge_length(first_hit: &[Option<u32>], width: usize) -> Option<u64> {
    if width == 0 || !first_hit.len().is_multiple_of(width) {
        return None;
    }
    let across = first_hit.chunks(width).flat_map(|row| row.windows(2)).filter(|p| p[0] != p[1]).count();
    let down = first_hit.iter().zip(first_hit.iter().skip(width)).filter(|(a, b)| a != b).count();
    Some((across + down) as u64)
}

/// Samples whose first hit may differ between two renderers that place a sample `delta_px` pixels apart:
/// of the `samples` in each pixel those within `delta_px` on either side of `edge_length` pixels of edge,
/// M = 2 `delta_px` `edge_length` `samples`, and three standard deviations of that count: M + 3 sqrt M + 3.
pub fn mismatch_bound(delta_px: f64, edge_length: u64, samples: u32) -> f64 {
    let expected = 2.0 * delta_px * edge_length as f64 * f64::from(samples);
    expected + 3.0 * expected.sqrt() + 3.0
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 40;

    fn picture() -> Vec<[f32; 3]> {
        (0..WIDTH * 50)
            .map(|i| {
                let (x, y) = ((i % WIDTH) as f32 / 40.0, (i / WIDTH) as f32 / 50.0);
                [x, y, if x > y { 0.9 } else { 0.1 }]
            })
            .collect()
    }

    fn against(defect: impl Fn(&mut Vec<[f32; 3]>)) -> Metrics {
        let truth: Vec<DVec3> = picture().iter().map(|p| DVec3::from_array(p.rgb())).collect();
        let mut image = picture();
        defect(&mut image);
        compare(&image, &truth).unwrap()
    }

    #[test]
    fn equal_images_differ_nowhere() {
        assert_eq!(against(|_| ()), Metrics::default());
        assert_eq!(compare::<DVec3, DVec3>(&[], &[]).unwrap(), Metrics::default());
    }

    #[test]
    fn swapped_channels_are_caught() {
        let m = against(|image| image.iter_mut().for_each(|p| p.swap(0, 2)));
        assert!(m.rmse > 0.2 && m.differing_pixels > 1900 && m.code_max > 100, "{m:?}");
    }

    #[test]
    fn a_shift_by_one_pixel_is_caught() {
        let m = against(|image| image.rotate_right(1));
        assert!(m.differing_pixels == 2000 && m.max_abs > 0.7 && m.p999 > 0.7, "{m:?}");
    }

    #[test]
    fn one_wrong_pixel_is_caught() {
        let m = against(|image| image[777][1] += 0.25);
        assert_eq!((m.differing_pixels, m.code_differing_pixels, m.nan_pixels), (1, 1, 0));
        assert!((m.max_abs - 0.25).abs() < 1e-7 && m.p999 == 0.0, "{m:?}");
        assert!((m.rmse - (0.0625f64 / 6000.0).sqrt()).abs() < 1e-9);
        assert!((m.psnr.unwrap() + 20.0 * m.rmse.log10()).abs() < 1e-12);
    }

    #[test]
    fn a_pixel_that_is_no_number_is_caught_even_in_both_images() {
        let m = against(|image| image[5][0] = f32::NAN);
        assert_eq!((m.nan_pixels, m.differing_pixels, m.max_abs, m.code_max), (1, 1, 1.0, 255));
        let nan = [DVec3::new(0.0, f64::NAN, 0.0)];
        assert_eq!(compare(&nan, &nan).unwrap().nan_pixels, 1);
        assert_eq!(against(|image| image[5][0] = f32::INFINITY).nan_pixels, 0);
    }

    #[test]
    fn a_pixels_error_is_that_of_its_worst_channel() {
        assert_eq!(pixel_error(&[0.0f32, 0.5, 1.0], &DVec3::new(0.0, 0.25, 1.0)).0, 0.25);
        assert_eq!(pixel_error(&[0.0f32, 0.0, 9.0], &[0.0f32, 0.0, 0.0]), (1.0, 255));
        assert_eq!(pixel_error(&[f32::NAN; 3], &[f32::NAN; 3]), (1.0, 255));
        let image = picture();
        let errors = image.iter().zip(image[1..].iter().chain(&image[..1])).map(|(a, b)| pixel_error(a, b));
        let m = against(|image| image.rotate_left(1));
        assert_eq!(errors.fold((0.0f64, 0), |w, e| (w.0.max(e.0), w.1.max(e.1))), (m.max_abs, m.code_max));
    }

    #[test]
    fn what_is_clamped_away_is_not_an_error() {
        let pair = ([DVec3::splat(1.0), DVec3::ZERO], [DVec3::splat(7.0), DVec3::splat(-1.0)]);
        assert_eq!(compare(&pair.0, &pair.1).unwrap(), Metrics::default());
    }

    #[test]
    fn percentile_is_the_nearest_rank() {
        let truth = vec![DVec3::ZERO; 2000];
        let mut image = truth.clone();
        image[0].x = 0.5;
        image[1].x = 0.25;
        assert_eq!(compare(&image, &truth).unwrap().p999, 0.0);
        image[2].x = 0.125;
        assert_eq!(compare(&image, &truth).unwrap().p999, 0.125);
    }

    #[test]
    fn unequal_sizes_are_refused() {
        assert_eq!(compare(&[DVec3::ZERO], &[[0.0f32; 3]; 2]), Err(SizeMismatch(1, 2)));
        assert_eq!(hit_mismatches(&[None], &[]), Err(SizeMismatch(1, 0)));
    }

    #[test]
    fn wrong_hits_are_counted() {
        let a = [Some(1), None, Some(2), Some(3)];
        assert_eq!(hit_mismatches(&a, &a), Ok(0));
        assert_eq!(hit_mismatches(&a, &[Some(1), Some(0), Some(2), None]), Ok(2));
        assert_eq!(hit_mismatches(&a, &[a[1], a[2], a[3], a[0]]), Ok(4));
    }

    #[test]
    fn edges_and_their_bound() {
        // Three by two pixels: a vertical edge of length 2 and one pixel of a horizontal one.
        let ids = [Some(1), Some(2), Some(2), Some(1), Some(2), None];
        assert_eq!(edge_length(&ids, 3), Some(4));
        assert_eq!(edge_length(&ids, 4), None);
        assert_eq!(edge_length(&[Some(1); 6], 3), Some(0));
        assert_eq!(mismatch_bound(1e-3, 0, 16), 3.0);
        assert_eq!(mismatch_bound(0.125, 100, 4), 100.0 + 30.0 + 3.0);
    }
}

//! Textures, until they are drawn: the mean of each stands for it.

use glam::DVec3;
use image::{DynamicImage, ImageReader};
use std::path::Path;

/// Mean colour of an image file, linear RGB. Whole numbers are taken as sRGB (IEC 61966-2-1) and decoded exactly, 8 and 16
/// bits each with their own codes; floating-point numbers (EXR, HDR) are linear. Transparency is not looked at.
///
/// # Errors
/// Why the file cannot be read.
pub(super) fn mean_linear_color(path: &Path) -> Result<DVec3, String> {
    let reader = ImageReader::open(path).and_then(ImageReader::with_guessed_format);
    let image = reader.map_err(|e| e.to_string())?.decode().map_err(|e| e.to_string())?;
    Ok(match image {
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => {
            let image = image.into_rgb32f();
            let count = f64::from(image.width()) * f64::from(image.height());
            let sum: DVec3 = image.pixels().map(|p| DVec3::from_array(p.0.map(f64::from))).sum();
            sum / count
        }
        DynamicImage::ImageLuma16(_)
        | DynamicImage::ImageLumaA16(_)
        | DynamicImage::ImageRgb16(_)
        | DynamicImage::ImageRgba16(_) => of_codes(image.into_rgb16().as_raw().iter().copied(), u16::MAX),
        _ => of_codes(image.into_rgb8().as_raw().iter().map(|c| u16::from(*c)), u8::MAX.into()),
    })
}

/// Mean of sRGB codes from 0 to `max`, red, green, blue in turn: each code is counted, so that the order does not matter.
fn of_codes(codes: impl Iterator<Item = u16>, max: u16) -> DVec3 {
    let mut counts = vec![[0u64; 3]; usize::from(max) + 1];
    codes.enumerate().for_each(|(i, code)| counts[usize::from(code)][i % 3] += 1);
    let mut sums = [0.0; 3];
    let mut total = 0;
    for (code, count) in counts.iter().enumerate() {
        let linear = decode(code as f64 / f64::from(max));
        (0..3).for_each(|i| sums[i] += linear * count[i] as f64);
        total += count[0];
    }
    DVec3::from_array(sums) / total as f64
}

/// IEC 61966-2-1, encoded to linear.
fn decode(code: f64) -> f64 {
    if code <= 0.040_45 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{ImageBuffer, Luma, Rgb};

    #[test]
    fn codes_are_decoded_before_the_mean() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        // Half black, half white: 0.5 of the light, not the light of code 0.5.
        let halves = |x: u32, _| if x == 0 { Rgb([0u8; 3]) } else { Rgb([255, 0, 255]) };
        for name in ["a.png", "a.ppm", "a.bmp", "a.tga"] {
            ImageBuffer::from_fn(2, 3, halves).save(at(name)).unwrap();
            assert_eq!(mean_linear_color(&at(name)), Ok(DVec3::new(0.5, 0.0, 0.5)), "{name}");
        }
        // Code 188 of 255 is 0.5029 of white by the standard's table; grey has one channel.
        ImageBuffer::from_pixel(1, 1, Luma([188u8])).save(at("grey.png")).unwrap();
        assert!((mean_linear_color(&at("grey.png")).unwrap() - DVec3::splat(0.502_886)).length() < 1e-5);
        // A step of 16 bits is not lost.
        ImageBuffer::from_pixel(1, 1, Rgb([1u16, 2, 3])).save(at("deep.png")).unwrap();
        let deep = DVec3::new(1.0, 2.0, 3.0) / (65535.0 * 12.92);
        assert!((mean_linear_color(&at("deep.png")).unwrap() - deep).length() < 1e-12);
        ImageBuffer::from_pixel(1, 1, Rgb([0.25f32, 2.0, 8.0])).save(at("a.exr")).unwrap();
        assert_eq!(mean_linear_color(&at("a.exr")), Ok(DVec3::new(0.25, 2.0, 8.0)));
        assert!(mean_linear_color(&at("none.png")).is_err());
        std::fs::write(at("bad.png"), "no picture").unwrap();
        assert!(mean_linear_color(&at("bad.png")).is_err());
    }
}

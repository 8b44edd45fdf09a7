//! Means of pictures: what stands for a texture that is not drawn.

use glam::DVec3;
use image::{DynamicImage, ImageFormat, ImageReader};
use std::io::{BufRead, Cursor, Seek};
use std::path::Path;

/// Means over all pixels of a picture; each channel in [0, 1], unless the file holds floating-point numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TextureMean {
    /// Red, green, blue as stored: for data such as roughness.
    pub stored: DVec3,
    /// Linear colour.
    pub color: DVec3,
    /// Linear colour of what is opaque: each pixel counts by its alpha. As `color` where all alpha is 0.
    pub covered: DVec3,
    /// Alpha.
    pub alpha: f64,
}

/// Decodes a PNG or JPEG file's bytes and takes its means. Errors say why it cannot be decoded.
pub(super) fn of(bytes: &[u8]) -> Result<TextureMean, String> {
    let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|e| e.to_string())?;
    if !matches!(reader.format(), Some(ImageFormat::Png | ImageFormat::Jpeg)) {
        return Err("neither PNG nor JPEG".to_owned());
    }
    decoded(reader)
}

/// Decodes a picture file of any format and takes its means. Errors say why it cannot be read or decoded.
pub(super) fn of_file(path: &Path) -> Result<TextureMean, String> {
    let reader = ImageReader::open(path).and_then(ImageReader::with_guessed_format);
    decoded(reader.map_err(|e| e.to_string())?)
}

fn decoded<R: BufRead + Seek>(reader: ImageReader<R>) -> Result<TextureMean, String> {
    // The decoder's default limits refuse pictures of more than half a gigabyte before they are allocated.
    Ok(mean(reader.decode().map_err(|e| e.to_string())?))
}

fn mean(picture: DynamicImage) -> TextureMean {
    if let DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) = picture {
        // EXR and HDR hold linear light.
        let mut sums = Sums::default();
        for pixel in picture.into_rgba32f().pixels() {
            let values = pixel.0.map(f64::from);
            sums.add(values, |i| values[i]);
        }
        return sums.means();
    }
    let wide = picture.color().bytes_per_pixel() > picture.color().channel_count();
    let mut sums = Sums::default();
    if wide {
        let table: Vec<f64> = (0..=u16::MAX).map(|v| srgb_to_linear(f64::from(v) / 65_535.0)).collect();
        for pixel in picture.into_rgba16().pixels() {
            sums.add(pixel.0.map(|v| f64::from(v) / 65_535.0), |i| table[usize::from(pixel.0[i])]);
        }
    } else {
        let table: Vec<f64> = (0..=u8::MAX).map(|v| srgb_to_linear(f64::from(v) / 255.0)).collect();
        for pixel in picture.into_rgba8().pixels() {
            sums.add(pixel.0.map(|v| f64::from(v) / 255.0), |i| table[usize::from(pixel.0[i])]);
        }
    }
    sums.means()
}

#[derive(Default)]
struct Sums {
    stored: DVec3,
    color: DVec3,
    covered: DVec3,
    alpha: f64,
    count: f64,
}

impl Sums {
    fn add(&mut self, [r, g, b, a]: [f64; 4], linear: impl Fn(usize) -> f64) {
        let color = DVec3::new(linear(0), linear(1), linear(2));
        self.stored += DVec3::new(r, g, b);
        self.color += color;
        self.covered += a * color;
        self.alpha += a;
        self.count += 1.0;
    }

    fn means(&self) -> TextureMean {
        let count = self.count.max(1.0);
        let color = self.color / count;
        let covered = if self.alpha > 0.0 { self.covered / self.alpha } else { color };
        TextureMean { stored: self.stored / count, color, covered, alpha: self.alpha / count }
    }
}

/// Decodes sRGB (IEC 61966-2-1): 0 to 1 in, 0 to 1 out.
pub(super) fn srgb_to_linear(v: f64) -> f64 {
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{ImageBuffer, Luma, Rgb, Rgba, RgbaImage};

    #[test]
    fn a_pictures_means_are_linear_and_weighted_by_alpha() {
        let mut picture = RgbaImage::new(2, 1);
        picture.put_pixel(0, 0, Rgba([255, 0, 188, 255]));
        picture.put_pixel(1, 0, Rgba([0, 255, 188, 0]));
        let mut png = Cursor::new(Vec::new());
        picture.write_to(&mut png, ImageFormat::Png).unwrap();
        let mean = of(png.get_ref()).unwrap();
        // sRGB 188 is 0.5029 (IEC 61966-2-1).
        assert!((mean.color - DVec3::new(0.5, 0.5, 0.5029)).abs().max_element() < 1e-4, "{mean:?}");
        assert!((mean.covered - DVec3::new(1.0, 0.0, 0.5029)).abs().max_element() < 1e-4, "{mean:?}");
        assert!((mean.stored - DVec3::new(0.5, 0.5, 188.0 / 255.0)).abs().max_element() < 1e-12);
        assert_eq!(mean.alpha, 0.5);
        assert!(of(b"no picture").is_err());
    }

    #[test]
    fn codes_are_decoded_before_the_mean() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let color = |name: &str| of_file(&at(name)).map(|mean| mean.color);
        // Half black, half white: 0.5 of the light, not the light of code 0.5.
        let halves = |x: u32, _| if x == 0 { Rgb([0u8; 3]) } else { Rgb([255, 0, 255]) };
        for name in ["a.png", "a.ppm", "a.bmp", "a.tga"] {
            ImageBuffer::from_fn(2, 3, halves).save(at(name)).unwrap();
            assert_eq!(color(name), Ok(DVec3::new(0.5, 0.0, 0.5)), "{name}");
        }
        // Code 188 of 255 is 0.5029 of white by the standard's table; grey has one channel.
        ImageBuffer::from_pixel(1, 1, Luma([188u8])).save(at("grey.png")).unwrap();
        assert!((color("grey.png").unwrap() - DVec3::splat(0.502_886)).length() < 1e-5);
        // A step of 16 bits is not lost.
        ImageBuffer::from_pixel(1, 1, Rgb([1u16, 2, 3])).save(at("deep.png")).unwrap();
        let deep = DVec3::new(1.0, 2.0, 3.0) / (65535.0 * 12.92);
        assert!((color("deep.png").unwrap() - deep).length() < 1e-12);
        ImageBuffer::from_pixel(1, 1, Rgb([0.25f32, 2.0, 8.0])).save(at("a.exr")).unwrap();
        assert_eq!(color("a.exr"), Ok(DVec3::new(0.25, 2.0, 8.0)));
        assert!(color("none.png").is_err());
        std::fs::write(at("bad.png"), "no picture").unwrap();
        assert!(color("bad.png").is_err());
    }
}

//! Pictures of a page as 8-bit PNG, shrunk if they are wide, and differences in false colours.

use crate::compare::metrics::{Rgb, pixel_error};
use crate::image::heat::heat;
use crate::image::{Metadata, code8, png8};
use std::io;

/// The false colours of a difference span the decades from here to 1.
pub(crate) const LEAST: f64 = 1e-4;

/// The whole factor by which a picture is shrunk to at most `widest` pixels, and its size then.
pub(crate) fn fitted([width, height]: [u32; 2], widest: u32) -> (u32, [u32; 2]) {
    let factor = width.div_ceil(widest).max(1);
    (factor, [width.div_ceil(factor), height.div_ceil(factor)])
}

/// A picture, linear RGB, of which each pixel is the mean of a block.
///
/// # Errors
/// If the PNG cannot be encoded.
pub(crate) fn picture<P: Rgb>(image: &[P], size: [u32; 2], widest: u32) -> io::Result<Vec<u8>> {
    let (factor, small) = fitted(size, widest);
    png(&shrunk(image, size[0], factor, mean), small)
}

/// The difference of two pictures in false colours, each pixel the largest of a block.
///
/// # Errors
/// If the PNG cannot be encoded.
pub(crate) fn difference<A: Rgb, B: Rgb>(
    a: &[A],
    b: &[B],
    size: [u32; 2],
    widest: u32,
) -> io::Result<Vec<u8>> {
    let (factor, small) = fitted(size, widest);
    let apart: Vec<[f64; 3]> = a.iter().zip(b).map(|(a, b)| [pixel_error(a, b).0; 3]).collect();
    png(&shrunk(&apart, size[0], factor, largest), small)
}

/// The scale of [`difference`] (HTML).
pub(crate) fn scale() -> String {
    let stops: Vec<String> =
        (0..=8u32).map(|i| heat(f64::from(i) / 8.0)).map(|[r, g, b]| format!("rgb({r},{g},{b})")).collect();
    format!(
        "<span class=\"scale\"><i style=\"background:linear-gradient(90deg,{})\"></i><span><span>{LEAST} or \
         less</span><span>0.001</span><span>0.01</span><span>0.1</span><span>1</span></span></span>",
        stops.join(",")
    )
}

/// 8-bit codes of the mean of a block.
fn mean(block: &[[f64; 3]]) -> [u8; 3] {
    let n = block.len() as f64;
    std::array::from_fn(|c| code8((block.iter().map(|p| p[c].clamp(0.0, 1.0)).sum::<f64>() / n) as f32))
}

/// The false colour of the largest of a block: shrinking must not hide it.
fn largest(block: &[[f64; 3]]) -> [u8; 3] {
    false_color(block.iter().map(|p| p[0]).fold(0.0, f64::max))
}

/// Decades from [`LEAST`] to 1; black below.
fn false_color(error: f64) -> [u8; 3] {
    heat(1.0 - error.log10() / LEAST.log10())
}

/// Blocks of `factor` by `factor` pixels, fewer at the far edges, each through `to_code`.
fn shrunk<P: Rgb>(image: &[P], width: u32, factor: u32, to_code: fn(&[[f64; 3]]) -> [u8; 3]) -> Vec<u8> {
    let (width, factor) = (width as usize, factor as usize);
    let rows: Vec<&[P]> = image.chunks(width).collect();
    let mut rgb = Vec::new();
    for band in rows.chunks(factor) {
        for x in (0..width).step_by(factor) {
            let end = (x + factor).min(width);
            let block: Vec<[f64; 3]> = band.iter().flat_map(|row| row[x..end].iter().map(P::rgb)).collect();
            rgb.extend(to_code(&block));
        }
    }
    rgb
}

/// sRGB codes as a PNG.
///
/// # Errors
/// If the PNG cannot be encoded.
pub(crate) fn png(rgb: &[u8], [width, height]: [u32; 2]) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    png8(width, height, rgb, &Metadata::default(), &mut bytes)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn false_colours_span_the_decades() {
        assert_eq!((false_color(0.0), false_color(LEAST)), (heat(0.0), heat(0.0)));
        assert_eq!(
            (false_color(1e-2), false_color(1.0), false_color(7.0)),
            (heat(0.5), heat(1.0), heat(1.0))
        );
    }

    #[test]
    fn one_wrong_pixel_survives_the_shrinking() {
        let mut apart = vec![[0.0; 3]; 12];
        apart[5] = [1.0; 3];
        let rgb = shrunk(&apart, 4, 2, largest);
        assert_eq!((&rgb[..3], &rgb[3..6]), (&heat(1.0)[..], &heat(0.0)[..]));
        assert_eq!(rgb.len(), 2 * 2 * 3, "the last band is half as high");
        let png = difference(&apart, &[[0.0; 3]; 12], [4, 3], 2).unwrap();
        assert_eq!(::image::load_from_memory(&png).unwrap().into_rgb8().into_raw(), rgb);
    }

    #[test]
    fn wide_pictures_are_shrunk_by_a_whole_factor() {
        assert_eq!(fitted([1024, 7], 1024), (1, [1024, 7]));
        assert_eq!(fitted([1025, 7], 1024), (2, [513, 4]));
        assert_eq!(fitted([0, 0], 1024).0, 1);
    }
}

//! Radiance RGBE.

use super::{Metadata, View};
use ::image::codecs::hdr::HdrEncoder;
use ::image::{ImageError, Rgb};
use std::io::{self, Write};

const SIGNATURE: &[u8] = b"#?RADIANCE\n";
/// 2^126: the exponent byte of its binade is 255.
pub(super) const LARGEST: f32 = f32::from_bits((126 + 127) << 23);
/// 2^-126: the exponent byte of its binade is 3; below, the encoder's would wrap round.
pub(super) const SMALLEST: f32 = f32::MIN_POSITIVE;

/// RGBE holds no sign, infinity or NaN, and its exponent byte ends near 2^127 and 2^-127.
fn sane(x: f32) -> f32 {
    if x >= SMALLEST { x.min(LARGEST) } else { 0.0 }
}

/// What a reader finds of a pixel: mantissas of 8 bits, rounded to nearest (halves up), and the exponent of the
/// greatest channel.
pub(super) fn stored(pixel: [f32; 3]) -> [f32; 3] {
    let pixel = pixel.map(sane);
    let most = pixel.iter().fold(0.0, |m: f32, x| m.max(*x));
    if most <= 0.0 {
        return [0.0; 3];
    }
    let step = f64::exp2(f64::from(most).log2().floor() + 1.0 - 8.0);
    let nearest = |x: f32, step: f64| (f64::from(x) / step + 0.5).floor();
    // A mantissa of 256 takes the next exponent.
    let step = if nearest(most, step) < 256.0 { step } else { 2.0 * step };
    pixel.map(|x| (nearest(x, step) * step) as f32)
}

pub(super) fn encode(view: View<'_>, metadata: &Metadata, out: &mut dyn Write) -> io::Result<()> {
    // The encoder cuts mantissas off: of rounded ones nothing is left to cut.
    let pixels: Vec<Rgb<f32>> = view.linear.iter().map(|p| Rgb(stored(*p))).collect();
    let mut bytes = Vec::new();
    HdrEncoder::new(&mut bytes).encode(&pixels, view.width as usize, view.height as usize).map_err(
        |error| match error {
            ImageError::IoError(error) => error,
            other => io::Error::other(other),
        },
    )?;
    // Comments may follow the first line.
    let body = bytes.strip_prefix(SIGNATURE).ok_or_else(|| io::Error::other("unexpected Radiance header"))?;
    out.write_all(SIGNATURE)?;
    for line in metadata.lines() {
        writeln!(out, "# {line}")?;
    }
    out.write_all(body)
}

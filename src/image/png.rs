//! PNG with an sRGB chunk and the metadata as text chunks.

use super::{Bits, Metadata, View, code8, code16};
use ::png::{BitDepth, ColorType, Encoder, EncodingError, SrgbRenderingIntent};
use std::io::{self, Write};

/// Codes of the colours; where there is alpha, of those that are behind it: the format does not multiply them. Alpha itself
/// is linear.
pub(super) fn encode(
    view: View<'_>,
    alpha: Option<&[f32]>,
    bits: Bits,
    metadata: &Metadata,
    out: &mut dyn Write,
) -> io::Result<()> {
    let (color, channels): (_, Vec<(f32, bool)>) = match alpha {
        None => (ColorType::Rgb, view.linear.as_flattened().iter().map(|x| (*x, true)).collect()),
        Some(alpha) => {
            let pixel = |(pixel, a): (&[f32; 3], &f32)| {
                let own = pixel.map(|x| (if *a > 0.0 { x / a } else { 0.0 }, true));
                [own[0], own[1], own[2], (*a, false)]
            };
            (ColorType::Rgba, view.linear.iter().zip(alpha).flat_map(pixel).collect())
        }
    };
    let level = |x: f32, most: f32| (x.clamp(0.0, 1.0) * most).round();
    let eight = |(x, encoded): &(f32, bool)| if *encoded { code8(*x) } else { level(*x, 255.0) as u8 };
    let sixteen = |(x, encoded): &(f32, bool)| if *encoded { code16(*x) } else { level(*x, 65_535.0) as u16 };
    let (depth, data): (_, Vec<u8>) = match bits {
        Bits::Eight => (BitDepth::Eight, channels.iter().map(eight).collect()),
        Bits::Sixteen => {
            (BitDepth::Sixteen, channels.iter().flat_map(|x| sixteen(x).to_be_bytes()).collect())
        }
    };
    write([view.width, view.height], color, depth, &data, metadata, out)
}

/// Writes 8-bit sRGB codes, three a pixel, rows from the top, as a PNG.
pub fn png8(width: u32, height: u32, rgb: &[u8], metadata: &Metadata, out: &mut dyn Write) -> io::Result<()> {
    write([width, height], ColorType::Rgb, BitDepth::Eight, rgb, metadata, out)
}

fn write(
    [width, height]: [u32; 2],
    color: ColorType,
    depth: BitDepth,
    data: &[u8],
    metadata: &Metadata,
    out: &mut dyn Write,
) -> io::Result<()> {
    let mut encoder = Encoder::new(out, width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    let mut fill = || {
        for (keyword, text) in metadata.iter() {
            // tEXt holds Latin-1 only; iTXt is UTF-8 but fewer tools read it.
            if text.is_ascii() {
                encoder.add_text_chunk(keyword.to_owned(), text.to_owned())?;
            } else {
                encoder.add_itxt_chunk(keyword.to_owned(), text.to_owned())?;
            }
        }
        Ok(())
    };
    fill()
        .and_then(|()| {
            let mut writer = encoder.write_header()?;
            writer.write_image_data(data)?;
            writer.finish()
        })
        .map_err(|error| match error {
            EncodingError::IoError(error) => error,
            other => io::Error::other(other),
        })
}

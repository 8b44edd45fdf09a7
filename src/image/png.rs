//! PNG with an sRGB chunk and the metadata as text chunks.

use super::{Bits, Metadata, PIECE, View, code8, code16};
use ::png::{BitDepth, ColorType, Encoder, EncodingError, SrgbRenderingIntent};
use rayon::prelude::*;
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
    let level = |x: f32, most: f32| (x.clamp(0.0, 1.0) * most).round();
    // The bytes of a channel; of alpha if it is not `encoded`.
    let put = |to: &mut Vec<u8>, x: f32, encoded: bool| match (bits, encoded) {
        (Bits::Eight, true) => to.push(code8(x)),
        (Bits::Eight, false) => to.push(level(x, 255.0) as u8),
        (Bits::Sixteen, true) => to.extend(code16(x).to_be_bytes()),
        (Bits::Sixteen, false) => to.extend((level(x, 65_535.0) as u16).to_be_bytes()),
    };
    let piece = |(piece, pixels): (usize, &[[f32; 3]])| {
        let mut to = Vec::with_capacity(8 * pixels.len());
        for (at, pixel) in pixels.iter().enumerate() {
            match alpha.map(|alpha| alpha[piece * PIECE + at]) {
                None => pixel.iter().for_each(|x| put(&mut to, *x, true)),
                Some(a) => {
                    pixel.iter().for_each(|x| put(&mut to, if a > 0.0 { x / a } else { 0.0 }, true));
                    put(&mut to, a, false);
                }
            }
        }
        to
    };
    let data = view.linear.par_chunks(PIECE).enumerate().map(piece).collect::<Vec<_>>().concat();
    let color = if alpha.is_some() { ColorType::Rgba } else { ColorType::Rgb };
    let depth = match bits {
        Bits::Eight => BitDepth::Eight,
        Bits::Sixteen => BitDepth::Sixteen,
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

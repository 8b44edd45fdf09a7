//! PNG with an sRGB chunk and the metadata as text chunks.

use super::{Bits, Metadata, View, code8, code16};
use ::png::{BitDepth, ColorType, Encoder, EncodingError, SrgbRenderingIntent};
use std::io::{self, Write};

pub(super) fn encode(view: View<'_>, bits: Bits, metadata: &Metadata, out: &mut dyn Write) -> io::Result<()> {
    let channels = view.linear.as_flattened().iter();
    let (depth, data): (_, Vec<u8>) = match bits {
        Bits::Eight => (BitDepth::Eight, channels.map(|&x| code8(x)).collect()),
        Bits::Sixteen => (BitDepth::Sixteen, channels.flat_map(|&x| code16(x).to_be_bytes()).collect()),
    };
    write([view.width, view.height], depth, &data, metadata, out)
}

/// Writes 8-bit sRGB codes, three a pixel, rows from the top, as a PNG.
pub fn png8(width: u32, height: u32, rgb: &[u8], metadata: &Metadata, out: &mut dyn Write) -> io::Result<()> {
    write([width, height], BitDepth::Eight, rgb, metadata, out)
}

fn write(
    [width, height]: [u32; 2],
    depth: BitDepth,
    data: &[u8],
    metadata: &Metadata,
    out: &mut dyn Write,
) -> io::Result<()> {
    let mut encoder = Encoder::new(out, width, height);
    encoder.set_color(ColorType::Rgb);
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

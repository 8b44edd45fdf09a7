//! Images: from linear `f32` RGB to PNG, EXR, Radiance HDR, PPM or PFM and back, and numbers as colours.

pub(crate) mod canvas;
mod described;
mod exr;
mod hdr;
pub mod heat;
mod metadata;
mod pfm;
mod png;
mod ppm;
mod read;
mod read_metadata;
mod save;
mod srgb;
pub(crate) mod text;

pub use described::described;
pub use metadata::{Metadata, Window};
pub use png::png8;
pub use read::{Picture, ReadError, is_picture};
pub use read_metadata::read_metadata;
pub use save::SaveError;
pub(crate) use save::save;
pub use srgb::{code8, code16, linear8, linear16};

use rayon::prelude::*;
use sha2::{Digest, Sha256};
use std::io::{self, Write};
use std::path::Path;

/// Pixels that are worked on at a time.
const PIECE: usize = 4096;

/// A picture to encode: rows from the top, linear RGB, `linear.len() == width * height`.
#[derive(Debug, Clone, Copy)]
pub struct View<'a> {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Linear RGB, unclamped.
    pub linear: &'a [[f32; 3]],
}

/// What some formats hold besides colour, rows from the top.
#[derive(Debug, Clone, Default)]
pub struct More<'a> {
    /// Share of a pixel that is covered, in [0, 1]; the colours of the view are then multiplied by it.
    pub alpha: Option<&'a [f32]>,
    /// Channels of one number a pixel, by their names in an OpenEXR file.
    pub channels: Vec<(String, Vec<f32>)>,
}

/// A file format, with what only it needs to know.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// sRGB codes, clamped to [0, 1]; metadata as text chunks.
    Png(Bits),
    /// Linear `f32`, unclamped; metadata as the `comments` attribute.
    Exr,
    /// Radiance RGBE, linear, negative values as 0; metadata as header comments.
    Hdr,
    /// Binary Netpbm of sRGB codes, clamped to [0, 1]; metadata as comments.
    Ppm(Bits),
    /// Linear `f32`, unclamped, without metadata.
    Pfm,
}

/// Bits per channel of a PNG or PPM.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Bits {
    /// 8 bits.
    #[default]
    Eight,
    /// 16 bits.
    Sixteen,
}

impl Format {
    /// The extensions [`Format::of`] knows.
    pub const EXTENSIONS: &str = ".png, .exr, .hdr, .ppm or .pfm";

    /// The format a path's extension asks for, case ignored; PNG and PPM in 8 bits unless changed.
    pub fn of(path: &Path) -> Option<Format> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "png" => Some(Format::Png(Bits::default())),
            "exr" => Some(Format::Exr),
            "hdr" => Some(Format::Hdr),
            "ppm" => Some(Format::Ppm(Bits::default())),
            "pfm" => Some(Format::Pfm),
            _ => None,
        }
    }

    /// The same format with `bits` per channel, if it holds codes.
    pub fn with_bits(self, bits: Bits) -> Option<Format> {
        match self {
            Format::Png(_) => Some(Format::Png(bits)),
            Format::Ppm(_) => Some(Format::Ppm(bits)),
            Format::Exr | Format::Hdr | Format::Pfm => None,
        }
    }

    /// True if the format holds alpha.
    pub fn holds_alpha(self) -> bool {
        matches!(self, Format::Png(_) | Format::Exr)
    }

    /// Encodes `view` with `more`; formats that have no room for it leave it out.
    pub fn encode_with(
        self,
        view: View<'_>,
        more: &More<'_>,
        metadata: &Metadata,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        match self {
            Format::Png(bits) => png::encode(view, more.alpha, bits, metadata, out),
            Format::Exr => exr::encode(view, more, metadata, out),
            Format::Hdr => hdr::encode(view, metadata, out),
            Format::Ppm(bits) => ppm::encode(view, bits, metadata, out),
            Format::Pfm => pfm::encode(view, out),
        }
    }

    /// What a reader finds in the file of a pixel: linear RGB.
    pub fn stored(self, pixel: [f32; 3]) -> [f32; 3] {
        match self {
            Format::Png(Bits::Eight) | Format::Ppm(Bits::Eight) => pixel.map(|x| linear8(code8(x))),
            Format::Png(Bits::Sixteen) | Format::Ppm(Bits::Sixteen) => pixel.map(|x| linear16(code16(x))),
            Format::Exr | Format::Pfm => pixel,
            Format::Hdr => hdr::stored(pixel),
        }
    }

    /// RMSE, in linear light clamped to [0, 1], between the image and what the file holds of it.
    pub fn encoding_error(self, view: View<'_>) -> f64 {
        let of = |read: &(dyn Fn([f32; 3]) -> [f32; 3] + Sync)| {
            let squares = |pixel: &[f32; 3]| -> f64 {
                let shown = |x: f32| if x.is_nan() { 0.0 } else { f64::from(x.clamp(0.0, 1.0)) };
                pixel.iter().zip(read(*pixel)).map(|(a, b)| (shown(*a) - shown(b)).powi(2)).sum()
            };
            // In pieces, so that the sum has the same bits on any number of cores.
            let pieces: Vec<f64> =
                view.linear.par_chunks(PIECE).map(|p| p.iter().map(squares).sum()).collect();
            let sum: f64 = pieces.iter().sum();
            (sum / (3 * view.linear.len().max(1)) as f64).sqrt()
        };
        match self {
            Format::Exr | Format::Pfm => 0.0,
            _ => of(&|p| self.stored(p)),
        }
    }

    /// Encodes `view` into `out`.
    pub fn encode(self, view: View<'_>, metadata: &Metadata, out: &mut dyn Write) -> io::Result<()> {
        self.encode_with(view, &More::default(), metadata, out)
    }
}

/// SHA-256 over the rows as little-endian `f32`, in hexadecimal: equal hashes mean equal images.
pub fn linear_sha256(linear: &[[f32; 3]]) -> String {
    let mut hash = Sha256::new();
    let mut bytes = Vec::with_capacity(12 * PIECE);
    for pixels in linear.chunks(PIECE) {
        bytes.clear();
        pixels.as_flattened().iter().for_each(|channel| bytes.extend(channel.to_le_bytes()));
        hash.update(&bytes);
    }
    format!("{:x}", hash.finalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    const PIXELS: [[f32; 3]; 6] = [
        [0.0, 0.5, 1.0],
        [-1.0, 2.0, f32::NAN],
        [1e-3, 1e3, f32::INFINITY],
        [0.25, 0.125, 0.0625],
        [1e-40, -0.0, 0.0],
        [1.0, 1.0, 1.0],
    ];

    fn encode(format: Format) -> Vec<u8> {
        let mut out = Vec::new();
        let metadata = Metadata::new([("Scene", "scenes/ö.toml"), ("Seed", "7")]);
        let view = View { width: 3, height: 2, linear: &PIXELS };
        format.encode(view, &metadata, &mut out).unwrap();
        out
    }

    fn contains(bytes: &[u8], text: &str) -> bool {
        bytes.windows(text.len()).any(|w| w == text.as_bytes())
    }

    #[test]
    fn extensions_choose_the_format() {
        assert_eq!(Format::of(Path::new("a/b.PNG")), Some(Format::Png(Bits::Eight)));
        assert_eq!(Format::of(Path::new("b.exr")), Some(Format::Exr));
        assert_eq!(Format::of(Path::new("b.hdr")), Some(Format::Hdr));
        assert_eq!(Format::of(Path::new("b.ppm")), Some(Format::Ppm(Bits::Eight)));
        assert_eq!(Format::of(Path::new("b.pfm")), Some(Format::Pfm));
        for bad in ["b.jpg", "b", ".png", "png", ""] {
            assert_eq!(Format::of(Path::new(bad)), None, "{bad}");
        }
    }

    #[test]
    fn png_holds_the_codes_and_the_metadata() {
        let bytes = encode(Format::Png(Bits::Eight));
        let image = ::image::load_from_memory(&bytes).unwrap().into_rgb8();
        assert_eq!(image.dimensions(), (3, 2));
        let want = PIXELS.map(|p| p.map(code8));
        assert_eq!(image.as_raw(), want.as_flattened());
        assert!(contains(&bytes, "sRGB") && contains(&bytes, "Seed\x007"));
        assert!(contains(&bytes, "scenes/ö.toml"), "UTF-8 goes to an iTXt chunk");

        let deep = ::image::load_from_memory(&encode(Format::Png(Bits::Sixteen))).unwrap();
        assert_eq!(deep.as_rgb16().unwrap().as_raw(), PIXELS.map(|p| p.map(code16)).as_flattened());
    }

    #[test]
    fn exr_holds_every_bit() {
        let bytes = encode(Format::Exr);
        assert!(contains(&bytes, "Scene: scenes/ö.toml"));
        let image = ::image::load_from_memory(&bytes).unwrap().into_rgb32f();
        let bits = |values: &[f32]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(image.as_raw()), bits(PIXELS.as_flattened()));
    }

    #[test]
    fn hdr_is_within_half_a_step_of_its_mantissa() {
        let bytes = encode(Format::Hdr);
        assert!(contains(&bytes, "# Seed: 7\n"));
        let image = ::image::load_from_memory(&bytes).unwrap().into_rgb32f();
        for (got, want) in image.pixels().zip(PIXELS) {
            let sane = want.map(|v| if v >= hdr::SMALLEST { v.min(hdr::LARGEST) } else { 0.0 });
            // The least mantissa of the greatest channel is 128.
            let step = sane.iter().fold(0.0f32, |a, &b| a.max(b)) / 128.0;
            for (g, w) in got.0.iter().zip(sane) {
                assert!((g - w).abs() <= step / 2.0, "{:?} for {want:?}", got.0);
            }
        }
    }

    /// Cut off, mantissas would be half a step low.
    #[test]
    fn hdr_is_right_on_average() {
        let share = |x: f64| x.fract() as f32;
        let pixel = |i: u32| [1.0, share(f64::from(i) * 0.618_033_99), share(f64::from(i) * 0.414_213_56)];
        let linear: Vec<[f32; 3]> = (0..12_000).map(pixel).collect();
        let mut bytes = Vec::new();
        let view = View { width: 120, height: 100, linear: &linear };
        Format::Hdr.encode(view, &Metadata::default(), &mut bytes).unwrap();
        let image = ::image::load_from_memory(&bytes).unwrap().into_rgb32f();
        let lack = |(got, want): (&f32, &f32)| f64::from(*want - *got);
        let mean: f64 = image.iter().zip(linear.as_flattened()).map(lack).sum::<f64>() / 24_000.0;
        // Errors are even within half a step of 2^-7 either way: three deviations of the mean of 24,000.
        assert!(mean.abs() < 3.0 * (2f64.powi(-7) / 12f64.sqrt()) / 24_000f64.sqrt(), "{mean}");
        // All that a channel may round to, the next exponent included.
        for x in [0.998_046_9f32, 0.999, 0.501, 255.6, 1.0e-30] {
            let [stored, ..] = hdr::stored([x, 0.0, 0.0]);
            assert!((stored - x).abs() <= x / 256.0, "{stored} for {x}");
        }
        assert_eq!(hdr::stored([0.999, 0.0, 0.003]), [1.0, 0.0, 0.0]);
    }

    /// Against what a reader finds in the file itself.
    #[test]
    fn the_encoding_error_is_that_of_the_file() {
        let linear: Vec<[f32; 3]> = (0..600)
            .map(|i| [0.37, 0.11, 0.73].map(|k| (i as f32 * k).fract().powi(3) * 1.1 - 0.01))
            .collect();
        let view = View { width: 30, height: 20, linear: &linear };
        for format in [Format::Png(Bits::Eight), Format::Png(Bits::Sixteen), Format::Exr, Format::Hdr] {
            let mut bytes = Vec::new();
            format.encode(view, &Metadata::default(), &mut bytes).unwrap();
            let file = ::image::load_from_memory(&bytes).unwrap();
            let read: Vec<f32> = match format {
                Format::Png(Bits::Eight) => file.into_rgb8().iter().map(|c| linear8(*c)).collect(),
                Format::Png(Bits::Sixteen) => file.into_rgb16().iter().map(|c| linear16(*c)).collect(),
                Format::Exr | Format::Hdr => file.into_rgb32f().iter().copied().collect(),
                Format::Ppm(_) | Format::Pfm => unreachable!("not among the formats above"),
            };
            let shown = |x: f32| f64::from(x.clamp(0.0, 1.0));
            let squares: f64 =
                linear.as_flattened().iter().zip(&read).map(|(a, b)| (shown(*a) - shown(*b)).powi(2)).sum();
            let found = (squares / read.len() as f64).sqrt();
            let stated = format.encoding_error(view);
            assert!((stated - found).abs() <= 1e-6 * found, "{format:?}: {stated} {found}");
            assert_eq!(stated > 0.0, format != Format::Exr, "{format:?}");
        }
    }

    #[test]
    fn encoding_is_repeatable() {
        for format in [Format::Png(Bits::Eight), Format::Png(Bits::Sixteen), Format::Exr, Format::Hdr] {
            assert_eq!(encode(format), encode(format), "{format:?}");
        }
    }

    #[test]
    fn the_hash_is_over_little_endian_rows() {
        // sha256sum of the twelve bytes 00 00 80 3f, 00 00 00 00, 00 00 00 c0.
        let hash = linear_sha256(&[[1.0, 0.0, -2.0]]);
        let bytes = [0, 0, 0x80, 0x3f, 0, 0, 0, 0, 0, 0, 0, 0xc0];
        assert_eq!(hash, format!("{:x}", Sha256::digest(bytes)));
        assert_ne!(hash, linear_sha256(&[[1.0, -0.0, -2.0]]), "a sign of zero is a different image");
    }
}

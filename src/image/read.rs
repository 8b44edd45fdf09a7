//! Pictures read back: PNG, OpenEXR and Radiance HDR to linear `f32` RGB.

use super::{Window, exr, linear8, linear16};
use ::image::{DynamicImage, ImageReader};
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

/// A picture read from a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Rows from the top, linear RGB as the file has it: EXR is not clamped.
    pub linear: Vec<[f32; 3]>,
    /// How the file holds it, in plain words.
    pub encoding: &'static str,
    /// Where it lies in a larger image, if the file says so: a crop as OpenEXR.
    pub window: Option<Window>,
}

impl Picture {
    /// Reads a picture; the content decides the format, not the name. PNG codes (8 or 16 bits, grey, colour
    /// or palette) are taken as sRGB; other colour profiles are not looked at.
    ///
    /// # Errors
    /// If the file cannot be opened or decoded, or has pixels that are not opaque.
    pub fn read(path: impl AsRef<Path>) -> Result<Picture, ReadError> {
        read(path.as_ref())
    }
}

/// Why a picture cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// It cannot be opened.
    #[error("cannot read {}", path.display())]
    Open {
        /// Of the file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// It is damaged, or of another format.
    #[error("cannot read {} as a PNG, OpenEXR or Radiance HDR picture", path.display())]
    Decode {
        /// Of the file.
        path: PathBuf,
        /// What the decoder says.
        source: ::image::ImageError,
    },
    /// It lets through what is behind it.
    #[error(
        "{} has {count} transparent pixels, the first at ({x}, {y}): their colour depends on what is behind; \
         flatten it first",
        path.display()
    )]
    Transparent {
        /// Of the file.
        path: PathBuf,
        /// How many.
        count: usize,
        /// Column of the first.
        x: usize,
        /// Row of the first.
        y: usize,
    },
}

impl Picture {
    /// The same part of this picture as `other` is of its larger image, if that has this picture's size; else all of it.
    #[must_use]
    pub fn cut_like(self, other: &Picture) -> Picture {
        match other.window.filter(|window| window.full == [self.width, self.height] && self.window.is_none())
        {
            Some(window) => {
                let [width, height] = window.size;
                Picture { width, height, linear: window.cut(&self.linear), window: Some(window), ..self }
            }
            None => self,
        }
    }
}

fn read(path: &Path) -> Result<Picture, ReadError> {
    let open = |source| ReadError::Open { path: path.to_owned(), source };
    let file = File::open(path).map_err(open)?;
    if file.metadata().map_err(open)?.is_dir() {
        return Err(open(std::io::ErrorKind::IsADirectory.into()));
    }
    let image = ImageReader::new(BufReader::new(file))
        .with_guessed_format()
        .map_err(open)?
        .decode()
        .map_err(|source| ReadError::Decode { path: path.to_owned(), source })?;
    let (width, height) = (image.width(), image.height());
    let (pixels, encoding): (Vec<[f32; 4]>, _) = match &image {
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => {
            (image.into_rgba32f().pixels().map(|p| p.0).collect(), "linear")
        }
        DynamicImage::ImageLuma16(_)
        | DynamicImage::ImageLumaA16(_)
        | DynamicImage::ImageRgb16(_)
        | DynamicImage::ImageRgba16(_) => {
            let table: Vec<f32> = (0..=u16::MAX).map(linear16).collect();
            let pixel = |[r, g, b, a]: [u16; 4]| {
                let [r, g, b] = [r, g, b].map(|c| table[usize::from(c)]);
                [r, g, b, if a == u16::MAX { 1.0 } else { 0.0 }]
            };
            (image.into_rgba16().pixels().map(|p| pixel(p.0)).collect(), "16-bit sRGB")
        }
        _ => {
            let table: [f32; 256] = std::array::from_fn(|c| linear8(c as u8));
            let pixel = |[r, g, b, a]: [u8; 4]| {
                let [r, g, b] = [r, g, b].map(|c| table[usize::from(c)]);
                [r, g, b, if a == u8::MAX { 1.0 } else { 0.0 }]
            };
            (image.into_rgba8().pixels().map(|p| pixel(p.0)).collect(), "8-bit sRGB")
        }
    };
    let clear = |p: &[f32; 4]| p[3] != 1.0;
    if let Some(first) = pixels.iter().position(clear) {
        let count = pixels.iter().filter(|p| clear(p)).count();
        let (x, y) = (first % width as usize, first / width as usize);
        return Err(ReadError::Transparent { path: path.to_owned(), count, x, y });
    }
    let linear: Vec<[f32; 3]> = pixels.iter().map(|[r, g, b, _]| [*r, *g, *b]).collect();
    let window = File::open(path).ok().and_then(|file| exr::window(BufReader::new(file)));
    Ok(match window.filter(|window| window.full == [width, height]) {
        // The decoder fills the rest of the larger image with black.
        Some(window) => {
            let [width, height] = window.size;
            Picture { width, height, linear: window.cut(&linear), encoding, window: Some(window) }
        }
        None => Picture { width, height, linear, encoding, window: None },
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{Bits, Format, Metadata, View, code8, code16};
    use ::image::{GrayImage, Rgba, RgbaImage};
    use std::fs;

    const PIXELS: [[f32; 3]; 6] =
        [[0.0, 0.5, 1.0], [2.0, 0.25, 0.0], [1e-3, 0.9, 7.5], [0.3, 0.2, 0.1], [0.5; 3], [1.0; 3]];

    /// Written by this program, read back.
    fn round(format: Format, name: &str) -> Picture {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        let view = View { width: 3, height: 2, linear: &PIXELS };
        format.encode(view, &Metadata::default(), &mut File::create(&path).unwrap()).unwrap();
        read(&path).unwrap()
    }

    #[test]
    fn what_was_written_comes_back() {
        // The name is of no account.
        let exr = round(Format::Exr, "a.png");
        assert_eq!(
            (exr.width, exr.height, exr.linear.as_slice(), exr.encoding),
            (3, 2, &PIXELS[..], "linear")
        );
        let codes = round(Format::Png(Bits::Eight), "a.exr");
        assert_eq!(codes.encoding, "8-bit sRGB");
        assert!(codes.linear.iter().zip(PIXELS).all(|(got, want)| got.map(code8) == want.map(code8)));
        let codes = round(Format::Png(Bits::Sixteen), "a");
        assert_eq!(codes.encoding, "16-bit sRGB");
        assert!(codes.linear.iter().zip(PIXELS).all(|(got, want)| got.map(code16) == want.map(code16)));
        let hdr = round(Format::Hdr, "a.hdr");
        assert!(hdr.linear.iter().zip(PIXELS).all(|(got, want)| {
            let step = want.iter().fold(0.0f32, |a, &b| a.max(b)) / 127.0;
            got.iter().zip(want).all(|(g, w)| (g - w).abs() <= step)
        }));
    }

    #[test]
    fn other_kinds_of_png_are_read_and_transparent_ones_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        GrayImage::from_pixel(2, 1, ::image::Luma([188])).save(&path).unwrap();
        assert_eq!(read(&path).unwrap().linear, [[linear8(188); 3]; 2]);
        let mut clear = RgbaImage::from_pixel(3, 2, Rgba([9, 8, 7, 255]));
        clear.save(&path).unwrap();
        assert_eq!(read(&path).unwrap().linear[5], [9, 8, 7].map(linear8));
        clear.put_pixel(1, 1, Rgba([9, 8, 7, 254]));
        clear.save(&path).unwrap();
        let error = read(&path).unwrap_err().to_string();
        assert!(error.contains("1 transparent") && error.contains("(1, 1)"), "{error}");
    }

    #[test]
    fn bad_files_are_told_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("none.png");
        assert!(read(&missing).unwrap_err().to_string().contains("none.png"));
        assert!(read(folder.path()).is_err());
        let bad = folder.path().join("bad.png");
        for bytes in [&b""[..], b"no picture", b"\x89PNG\r\n\x1a\n cut", b"#?RADIANCE\n", b"v/1\x01 cut"] {
            fs::write(&bad, bytes).unwrap();
            let error = read(&bad).unwrap_err().to_string();
            assert!(error.contains("bad.png") && error.contains("OpenEXR"), "{error}");
        }
    }
}

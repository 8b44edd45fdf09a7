//! Pictures read back: PNG, OpenEXR, Radiance HDR, PPM and PFM to linear `f32` RGB.

use super::{Window, exr, linear8, linear16, pfm, ppm};
use crate::host::memory;
use crate::units;
use ::exr::meta::MetaData;
use ::image::{ColorType, DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use std::fs::File;
use std::io::{BufReader, Read, Seek};
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
    #[error("cannot read {} as a PNG, OpenEXR, Radiance HDR, PPM or PFM picture", path.display())]
    Decode {
        /// Of the file.
        path: PathBuf,
        /// What the decoder says.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// Its header promises more pixels than a file of its length can hold, or none.
    #[error(
        "cannot read {}: its header says {width}x{height} pixels, which a file of {} cannot hold: it is damaged",
        path.display(),
        units::bytes(*bytes)
    )]
    Size {
        /// Of the file.
        path: PathBuf,
        /// Pixels, by the header.
        width: u32,
        /// Pixels, by the header.
        height: u32,
        /// Bytes of the file.
        bytes: u64,
    },
    /// It takes more memory than is free.
    #[error(
        "cannot read {}: its {width}x{height} pixels need {} of memory, and {} are free",
        path.display(),
        units::bytes(*bytes),
        units::bytes(*free)
    )]
    TooLarge {
        /// Of the file.
        path: PathBuf,
        /// Pixels, by the header.
        width: u32,
        /// Pixels, by the header.
        height: u32,
        /// Bytes needed.
        bytes: u64,
        /// Bytes that this process can still have.
        free: u64,
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

/// Most pixels that a byte of a file can stand for: eight to a byte, and DEFLATE, which PNG and EXR have, makes at most
/// 1032 bytes of one; the other compressions of EXR end before that.
const EXPANSION: u64 = 8 * 1032;
/// Bytes of a pixel as this program holds it.
const OWN: u64 = 12;

/// True if the file begins like a picture that can be read.
pub fn is_picture(path: &Path) -> bool {
    let mut start = Vec::new();
    let read = File::open(path).and_then(|file| file.take(START).read_to_end(&mut start));
    read.is_ok() && (ppm::is_ppm(&start) || pfm::is_pfm(&start) || ::image::guess_format(&start).is_ok())
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
    let decode = |source: Box<dyn std::error::Error + Send + Sync>| ReadError::Decode {
        path: path.to_owned(),
        source,
    };
    let mut file = File::open(path).map_err(open)?;
    let about = file.metadata().map_err(open)?;
    if about.is_dir() {
        return Err(open(std::io::ErrorKind::IsADirectory.into()));
    }
    let room = Room { path, file: about.is_file().then_some(about.len()), free: memory::free() };
    let mut start = Vec::new();
    if room.file.is_some() {
        file.by_ref().take(START).read_to_end(&mut start).and_then(|_| file.rewind()).map_err(open)?;
    }
    if ppm::is_ppm(&start) || pfm::is_pfm(&start) {
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(open)?;
        let (width, height, linear, encoding) = match ppm::is_ppm(&bytes) {
            true => ppm::decode(&bytes),
            false => pfm::decode(&bytes).map(|(width, height, linear)| (width, height, linear, "linear")),
        }
        .map_err(|why| decode(why.into()))?;
        return Ok(Picture { width, height, linear, encoding, window: None });
    }
    if start.starts_with(&EXR) {
        check_exr(&room, &mut file)?;
        file.rewind().map_err(open)?;
    }
    let mut reader = ImageReader::new(BufReader::new(file)).with_guessed_format().map_err(open)?;
    let format = reader.format();
    let mut limits = Limits::no_limits();
    // Of what decoders hold besides the pixels, which are checked below.
    limits.max_alloc = Some(room.free.unwrap_or(u64::MAX));
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(|e| decode(e.into()))?;
    let (width, height) = decoder.dimensions();
    let pixels = u64::from(width) * u64::from(height);
    if format == Some(ImageFormat::Hdr) {
        // A run may be as long as a row, but each row has one.
        room.holds([width, height], u64::from(height) * RUN)?;
    } else {
        room.holds([width, height], pixels / EXPANSION)?;
    }
    room.fits([width, height], decoder.total_bytes().saturating_add(OWN * pixels))?;
    if pixels == 0 {
        return Err(room.wrong([width, height]));
    }
    let whole = picture(path, &DynamicImage::from_decoder(decoder).map_err(|e| decode(e.into()))?)?;
    Ok(if start.starts_with(&EXR) { data_of(path, whole) } else { whole })
}

/// The part of an OpenEXR picture that the file has data of: the decoder fills the rest of a larger image with black.
fn data_of(path: &Path, whole: Picture) -> Picture {
    let window = File::open(path).ok().and_then(|file| exr::window(BufReader::new(file)));
    match window.filter(|window| window.full == [whole.width, whole.height]) {
        Some(window) => {
            let [width, height] = window.size;
            Picture { width, height, linear: window.cut(&whole.linear), window: Some(window), ..whole }
        }
        None => whole,
    }
}

/// Bytes that tell a format.
const START: u64 = 16;
/// First bytes of an OpenEXR file.
const EXR: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
/// Bytes of the shortest run of a Radiance file.
const RUN: u64 = 4;

/// Room for a picture: bytes of its file, and free memory; None where they are not known.
struct Room<'a> {
    path: &'a Path,
    file: Option<u64>,
    free: Option<u64>,
}

impl Room<'_> {
    /// Checks that the file can hold `least` bytes.
    fn holds(&self, size: [u32; 2], least: u64) -> Result<(), ReadError> {
        match self.file {
            Some(bytes) if bytes < least => Err(self.wrong(size)),
            _ => Ok(()),
        }
    }

    /// Checks that `bytes` of memory can be had.
    fn fits(&self, [width, height]: [u32; 2], bytes: u64) -> Result<(), ReadError> {
        match self.free {
            Some(free) if bytes > free => {
                Err(ReadError::TooLarge { path: self.path.to_owned(), width, height, bytes, free })
            }
            _ => Ok(()),
        }
    }

    fn wrong(&self, [width, height]: [u32; 2]) -> ReadError {
        let bytes = self.file.unwrap_or(0);
        ReadError::Size { path: self.path.to_owned(), width, height, bytes }
    }
}

/// Checks the sizes that the header of an OpenEXR file promises: its decoder takes memory for them before it reads a
/// pixel, for each part of the file.
fn check_exr(room: &Room<'_>, file: &mut File) -> Result<(), ReadError> {
    let Ok(meta) = MetaData::read_from_buffered(BufReader::new(file), false) else {
        // The decoder says what is wrong.
        return Ok(());
    };
    for header in &meta.headers {
        let shown = header.shared_attributes.display_window.size;
        for window in [header.layer_size, shown] {
            let side = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
            let size = [side(window.width()), side(window.height())];
            let pixels = (window.width() as u64).saturating_mul(window.height() as u64);
            // As f32, whatever they are in the file.
            let bytes = pixels.saturating_mul(4 * header.channels.list.len() as u64);
            // Pixels outside the data are shown black and take no place in the file.
            if window == header.layer_size {
                room.holds(size, pixels / EXPANSION)?;
            }
            room.fits(size, bytes.saturating_add(pixels.saturating_mul(OWN)))?;
        }
    }
    Ok(())
}

/// The pixels of a decoded image in linear light.
fn picture(path: &Path, image: &DynamicImage) -> Result<Picture, ReadError> {
    let table8: [f32; 256] = std::array::from_fn(|c| linear8(c as u8));
    let mut table16 = Vec::new();
    if matches!(image.color(), ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16) {
        table16.extend((0..=u16::MAX).map(linear16));
    }
    let (of8, of16) = (|c: u8| table8[usize::from(c)], |c: u16| table16[usize::from(c)]);
    let mut taken = Taken {
        linear: Vec::with_capacity(image.width() as usize * image.height() as usize),
        clear: None,
        count: 0,
    };
    let encoding = match image {
        DynamicImage::ImageRgb32F(i) => taken.all(i.pixels().map(|p| (p.0, true)), "linear"),
        DynamicImage::ImageRgba32F(i) => {
            taken.all(i.pixels().map(|p| ([p.0[0], p.0[1], p.0[2]], p.0[3] == 1.0)), "linear")
        }
        DynamicImage::ImageLuma16(i) => taken.all(i.pixels().map(|p| ([of16(p.0[0]); 3], true)), DEEP),
        DynamicImage::ImageLumaA16(i) => {
            taken.all(i.pixels().map(|p| ([of16(p.0[0]); 3], p.0[1] == u16::MAX)), DEEP)
        }
        DynamicImage::ImageRgb16(i) => taken.all(i.pixels().map(|p| (p.0.map(of16), true)), DEEP),
        DynamicImage::ImageRgba16(i) => {
            taken.all(i.pixels().map(|p| ([p.0[0], p.0[1], p.0[2]].map(of16), p.0[3] == u16::MAX)), DEEP)
        }
        DynamicImage::ImageLuma8(i) => taken.all(i.pixels().map(|p| ([of8(p.0[0]); 3], true)), PLAIN),
        DynamicImage::ImageLumaA8(i) => {
            taken.all(i.pixels().map(|p| ([of8(p.0[0]); 3], p.0[1] == u8::MAX)), PLAIN)
        }
        DynamicImage::ImageRgb8(i) => taken.all(i.pixels().map(|p| (p.0.map(of8), true)), PLAIN),
        other => {
            let i = other.to_rgba8();
            taken.all(i.pixels().map(|p| ([p.0[0], p.0[1], p.0[2]].map(of8), p.0[3] == u8::MAX)), PLAIN)
        }
    };
    let (width, height) = (image.width(), image.height());
    if let Some(first) = taken.clear {
        let (x, y) = (first % width as usize, first / width as usize);
        return Err(ReadError::Transparent { path: path.to_owned(), count: taken.count, x, y });
    }
    Ok(Picture { width, height, linear: taken.linear, encoding, window: None })
}

const PLAIN: &str = "8-bit sRGB";
const DEEP: &str = "16-bit sRGB";

/// Pixels taken over, and those that are not opaque.
struct Taken {
    linear: Vec<[f32; 3]>,
    /// Index of the first that is not opaque.
    clear: Option<usize>,
    /// How many are not.
    count: usize,
}

impl Taken {
    /// Takes colours, each with whether it is opaque; gives `encoding` back.
    fn all(
        &mut self,
        pixels: impl Iterator<Item = ([f32; 3], bool)>,
        encoding: &'static str,
    ) -> &'static str {
        for (at, (pixel, opaque)) in pixels.enumerate() {
            self.linear.push(pixel);
            if !opaque {
                self.clear.get_or_insert(at);
                self.count += 1;
            }
        }
        encoding
    }
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
    fn netpbm_and_pfm_come_back() {
        let pfm = round(Format::Pfm, "a.png");
        assert_eq!(
            (pfm.width, pfm.height, pfm.linear.as_slice(), pfm.encoding),
            (3, 2, &PIXELS[..], "linear")
        );
        for (bits, encoding) in [(Bits::Eight, "8-bit sRGB"), (Bits::Sixteen, "16-bit sRGB")] {
            // PNG holds the same codes.
            let ppm = round(Format::Ppm(bits), "a");
            assert_eq!(ppm, round(Format::Png(bits), "a"));
            assert_eq!(ppm.encoding, encoding);
        }
    }

    #[test]
    fn netpbm_of_other_programs_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let linear = |bytes: &[u8]| {
            fs::write(&path, bytes).unwrap();
            read(&path).map(|picture| picture.linear).map_err(|e| format!("{e:?}"))
        };
        assert_eq!(
            linear(b"P3 # a\n#b\n1 2 255\n255 0 188\n1 2 3\n").unwrap(),
            [[255, 0, 188], [1, 2, 3]].map(|p| p.map(linear8))
        );
        assert_eq!(linear(b"P2\n2 1\n15\n15 0").unwrap(), [[1.0; 3], [0.0; 3]]);
        assert_eq!(linear(b"P5 1 1 255\n\xbc").unwrap(), [[linear8(188); 3]]);
        // Big-endian and grey, the lowest row first.
        assert_eq!(linear(b"Pf\n1 2\n1.0\n\x3f\x80\0\0\x40\0\0\0").unwrap(), [[2.0; 3], [1.0; 3]]);
        for bad in [
            &b"P6 1 1 255\n\0\0"[..],
            b"P6 0 1 255\n",
            b"P6 4000000000 4000000000 255\n",
            b"P3 1 1 255 1 2",
            b"P2 1 1 15 16",
            b"P6 1 1 65536\n",
            b"P6 ",
            b"PF\n1 1\n",
            b"PF\n1 1\n-1.0\n\0",
            b"PF\nx 1\n-1.0\n",
        ] {
            assert!(linear(bad).unwrap_err().contains("Decode"), "{bad:?}");
        }
        assert!(is_picture(&path));
        fs::write(&path, b"[camera]").unwrap();
        assert!(!is_picture(&path));
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

    /// Small files whose headers promise much: each is refused by a message that names it, at once and without memory.
    #[test]
    fn headers_are_not_believed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bomb");
        let refused = |bytes: &[u8]| {
            fs::write(&path, bytes).unwrap();
            let error = read(&path).unwrap_err();
            assert!(error.to_string().contains("bomb"), "{error}");
            error
        };
        let encoded = |format: Format| {
            let mut bytes = Vec::new();
            let view = View { width: 3, height: 2, linear: &PIXELS };
            format.encode(view, &Metadata::default(), &mut bytes).unwrap();
            bytes
        };

        // Either window of an EXR, or both, at any size up to the format's.
        let exr = encoded(Format::Exr);
        let windows = [&b"dataWindow"[..], b"displayWindow"]
            .map(|name| exr.windows(name.len()).position(|w| w == name).unwrap() + name.len() + 1 + 6 + 4);
        for side in [60_000, 100_000, 1 << 20, i32::MAX / 2 - 1] {
            for which in [&windows[..1], &windows[1..], &windows[..]] {
                let mut bytes = exr.clone();
                for at in which {
                    for max in [at + 8, at + 12] {
                        bytes[max..max + 4].copy_from_slice(&(side - 1).to_le_bytes());
                    }
                }
                refused(&bytes);
            }
        }
        // A PNG with the checksum of its header made right.
        let png = encoded(Format::Png(Bits::Eight));
        for side in [60_000u32, 1 << 20, i32::MAX as u32] {
            let mut bytes = png.clone();
            for at in [16, 20] {
                bytes[at..at + 4].copy_from_slice(&side.to_be_bytes());
            }
            let crc = crc32(&bytes[12..29]);
            bytes[29..33].copy_from_slice(&crc.to_be_bytes());
            let error = refused(&bytes);
            assert!(side > 60_000 || matches!(error, ReadError::Size { width: 60_000, .. }), "{error:?}");
        }
        // A Radiance file of runs.
        for size in ["-Y 60000 +X 60000", "-Y 4000000000 +X 4000000000", "-Y 1 +X 4294967295", "-Y 0 +X 5"] {
            for runs in [&b""[..], &[2, 2, 0x40, 0, 255, 1, 255, 1], &[1, 1, 1, 255, 1, 1, 1, 255]] {
                let head = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{size}\n");
                refused(&[head.as_bytes(), runs].concat());
            }
        }
    }

    /// The checksum of PNG (its specification, annex D).
    fn crc32(bytes: &[u8]) -> u32 {
        let step = |c: u32, _| if c & 1 == 1 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 };
        !bytes.iter().fold(!0u32, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), step))
    }

    /// A blank page compresses best: no good file is taken for a bomb.
    #[test]
    fn the_best_compressed_files_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("blank");
        let linear = vec![[0.0; 3]; 3000 * 500];
        let view = View { width: 3000, height: 500, linear: &linear };
        for format in [Format::Png(Bits::Eight), Format::Png(Bits::Sixteen), Format::Exr, Format::Hdr] {
            format.encode(view, &Metadata::default(), &mut File::create(&path).unwrap()).unwrap();
            assert!(read(&path).unwrap().linear == linear, "{format:?}");
        }
        // One bit a pixel, in a palette.
        let mut bytes = Vec::new();
        let mut encoder = ::png::Encoder::new(&mut bytes, 4000, 4000);
        encoder.set_color(::png::ColorType::Indexed);
        encoder.set_depth(::png::BitDepth::One);
        encoder.set_palette(vec![0, 0, 0, 255, 255, 255]);
        encoder.set_compression(::png::Compression::High);
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(&vec![0; 4000 * 500]).unwrap();
        writer.finish().unwrap();
        fs::write(&path, &bytes).unwrap();
        assert_eq!(read(&path).unwrap().linear.len(), 4000 * 4000);
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

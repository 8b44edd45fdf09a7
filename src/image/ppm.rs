//! Netpbm: binary PPM (`P6`) of sRGB codes to write, and P2, P3, P5 and P6 of any maximum to read.

use super::{Bits, Metadata, View, code8, code16, linear16};
use std::io::{self, Write};

/// 8 or 16 bits, the larger byte first; metadata as comments.
pub(super) fn encode(view: View<'_>, bits: Bits, metadata: &Metadata, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "P6")?;
    for line in metadata.lines() {
        writeln!(out, "# {line}")?;
    }
    writeln!(out, "{} {}\n{}", view.width, view.height, if bits == Bits::Eight { 255 } else { 65_535 })?;
    let channels = view.linear.as_flattened().iter();
    let data: Vec<u8> = match bits {
        Bits::Eight => channels.map(|&x| code8(x)).collect(),
        Bits::Sixteen => channels.flat_map(|&x| code16(x).to_be_bytes()).collect(),
    };
    out.write_all(&data)
}

/// True if the bytes begin like one of the kinds that [`decode`] reads.
pub(super) fn is_ppm(bytes: &[u8]) -> bool {
    matches!(bytes, [b'P', b'2' | b'3' | b'5' | b'6', b, ..] if b.is_ascii_whitespace() || *b == b'#')
}

/// Width, height, linear pixels, and the encoding in plain words.
type Decoded = (u32, u32, Vec<[f32; 3]>, &'static str);

/// Decodes a whole file.
pub(super) fn decode(bytes: &[u8]) -> Result<Decoded, String> {
    let mut words = Words { bytes, at: 2 };
    let [width, height, max] = [words.number()?, words.number()?, words.number()?];
    let max =
        u16::try_from(max).ok().filter(|max| *max > 0).ok_or("the greatest code is not from 1 to 65535")?;
    let (grey, text) = (matches!(bytes[1], b'2' | b'5'), matches!(bytes[1], b'2' | b'3'));
    let channels = if grey { 1 } else { 3 };
    let count = (width as usize).checked_mul(height as usize).and_then(|n| n.checked_mul(channels));
    let count = count.filter(|n| *n > 0).ok_or("the size is 0, or too large")?;
    let codes: Vec<u16> = if text {
        // A count from the header alone must not claim memory.
        let mut codes = Vec::new();
        for _ in 0..count {
            codes.push(u16::try_from(words.number()?).map_err(|_| "a code above the greatest")?);
        }
        codes
    } else {
        // One blank follows the header.
        let data = bytes.get(words.at + 1..).unwrap_or_default();
        let size = if max < 256 { 1 } else { 2 };
        let data = data.get(..count.saturating_mul(size)).ok_or("the file ends too early")?;
        match size {
            1 => data.iter().map(|code| u16::from(*code)).collect(),
            _ => data.chunks_exact(2).map(|two| u16::from_be_bytes([two[0], two[1]])).collect(),
        }
    };
    if codes.iter().any(|code| *code > max) {
        return Err("a code above the greatest".into());
    }
    // Other maxima fall between the codes of 16 bits, by at most half of one.
    let full = |code: u16| (u32::from(code) * 65_535 + u32::from(max) / 2) / u32::from(max);
    let table: Vec<f32> = (0..=max).map(|code| linear16(full(code) as u16)).collect();
    let linear = |code: &u16| table[usize::from(*code)];
    let pixels = match channels {
        1 => codes.iter().map(|code| [linear(code); 3]).collect(),
        _ => codes.chunks_exact(3).map(|rgb| [linear(&rgb[0]), linear(&rgb[1]), linear(&rgb[2])]).collect(),
    };
    Ok((width, height, pixels, if max < 256 { "8-bit sRGB" } else { "16-bit sRGB" }))
}

/// The numbers of a header, or of a text's codes.
struct Words<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Words<'_> {
    /// The next number; comments from `#` to the line's end are passed over.
    fn number(&mut self) -> Result<u32, String> {
        loop {
            match self.bytes.get(self.at) {
                Some(b'#') => {
                    let rest = &self.bytes[self.at..];
                    self.at += rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(rest.len());
                }
                Some(b) if b.is_ascii_whitespace() => self.at += 1,
                _ => break,
            }
        }
        let rest = &self.bytes[self.at..];
        let length = rest.iter().take_while(|b| b.is_ascii_digit()).count();
        self.at += length;
        let digits = std::str::from_utf8(&rest[..length]).unwrap_or_default();
        digits.parse().map_err(|_| "a number is missing or too large".into())
    }
}

//! PFM (Debevec): linear `f32`, every bit kept, rows from the bottom. The format has no room for metadata.

use super::View;
use std::io::{self, Write};

/// Little-endian, which a negative scale says.
pub(super) fn encode(view: View<'_>, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "PF\n{} {}\n-1.0", view.width, view.height)?;
    for row in view.linear.chunks(view.width.max(1) as usize).rev() {
        let bytes: Vec<u8> = row.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
        out.write_all(&bytes)?;
    }
    Ok(())
}

/// True if the bytes begin like a PFM in colour or grey.
pub(super) fn is_pfm(bytes: &[u8]) -> bool {
    matches!(bytes, [b'P', b'F' | b'f', b, ..] if b.is_ascii_whitespace())
}

/// Width, height and pixels; either order of bytes. The size of the scale is ignored, as readers do.
pub(super) fn decode(bytes: &[u8]) -> Result<(u32, u32, Vec<[f32; 3]>), String> {
    let mut at = 2;
    let mut word = || {
        let rest = bytes.get(at..).unwrap_or_default();
        let start = rest.iter().take_while(|b| b.is_ascii_whitespace()).count();
        let length = rest[start..].iter().take_while(|b| !b.is_ascii_whitespace()).count();
        // Exactly one blank ends the header.
        at += start + length + 1;
        std::str::from_utf8(&rest[start..start + length]).unwrap_or_default()
    };
    let (width, height, scale) = (word().parse::<u32>(), word().parse::<u32>(), word().parse::<f32>());
    let (Ok(width), Ok(height), Ok(scale)) = (width, height, scale) else {
        return Err("the header is not `PF`, width, height and scale".into());
    };
    let channels = if bytes[1] == b'F' { 3 } else { 1 };
    let count = (width as usize).checked_mul(height as usize).and_then(|n| n.checked_mul(4 * channels));
    let count = count.filter(|n| *n > 0).ok_or("the size is 0, or too large")?;
    let data = bytes.get(at..).and_then(|data| data.get(..count)).ok_or("the file ends too early")?;
    let number = |four: &[u8]| {
        let four = [four[0], four[1], four[2], four[3]];
        if scale < 0.0 { f32::from_le_bytes(four) } else { f32::from_be_bytes(four) }
    };
    let numbers: Vec<f32> = data.chunks_exact(4).map(number).collect();
    let pixel = |p: &[f32]| if channels == 3 { [p[0], p[1], p[2]] } else { [p[0]; 3] };
    let rows = numbers.chunks_exact(channels * width as usize).rev();
    Ok((width, height, rows.flat_map(|row| row.chunks_exact(channels)).map(pixel).collect()))
}

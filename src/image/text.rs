//! Text as anti-aliased pixels, in the embedded font DejaVu Sans: no font file is needed at run time.
//!
//! A text's `size` is the height of its line in pixels, from the highest ascender to the lowest
//! descender; capitals are 0.63 of it.

use ab_glyph::{Font, FontRef, Glyph, PxScale, ScaleFont, point};
use std::sync::LazyLock;

/// The font's file; licence and origin: `src/image/font/LICENSE`.
pub(crate) const FONT_FILE: &[u8] = include_bytes!("font/DejaVuSans-subset.ttf");

static FONT: LazyLock<FontRef<'static>> =
    LazyLock::new(|| FontRef::try_from_slice(FONT_FILE).expect("the embedded file is a font"));

/// Pixels that a line of `text` takes from left to right, rounded up.
pub(crate) fn width(text: &str, size: u32) -> u32 {
    let font = FONT.as_scaled(PxScale::from(size as f32));
    let advance: f32 = text.chars().map(|letter| font.h_advance(font.glyph_id(known(letter)))).sum();
    advance.ceil() as u32
}

/// Calls `put(x, y, coverage)` for every pixel that a line of `text` touches: pixels from the line's top
/// left corner, and the covered part of the pixel in (0, 1]. A letter may reach a pixel to the left of
/// the line or below it. Characters that the font has no glyph for become `?`.
pub(crate) fn draw(text: &str, size: u32, mut put: impl FnMut(i32, i32, f32)) {
    let scale = PxScale::from(size as f32);
    let font = FONT.as_scaled(scale);
    // On whole pixels, so that all letters stand on the same row.
    let baseline = font.ascent().ceil();
    let mut pen = 0.0;
    for letter in text.chars() {
        let id = font.glyph_id(known(letter));
        let glyph = Glyph { id, scale, position: point(pen, baseline) };
        pen += font.h_advance(id);
        if let Some(outline) = font.outline_glyph(glyph) {
            let corner = outline.px_bounds().min;
            outline.draw(|x, y, coverage| {
                if coverage > 0.0 {
                    put(corner.x as i32 + x as i32, corner.y as i32 + y as i32, coverage.min(1.0));
                }
            });
        }
    }
}

fn known(letter: char) -> char {
    if FONT.glyph_id(letter).0 == 0 { '?' } else { letter }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Left, top, right and bottom of the ink, ends excluded.
    fn ink(text: &str, size: u32) -> [i32; 4] {
        let mut ends = [i32::MAX, i32::MAX, i32::MIN, i32::MIN];
        draw(text, size, |x, y, _| {
            ends = [ends[0].min(x), ends[1].min(y), ends[2].max(x + 1), ends[3].max(y + 1)];
        });
        ends
    }

    #[test]
    fn ink_stays_within_the_line() {
        for size in [10, 14, 24, 40] {
            let text = "Ångström: 4 µm × (x² ≤ 10⁻³), {ÄÇgjpqy|}";
            let [left, top, right, bottom] = ink(text, size);
            assert!(left >= -1 && top >= 0 && bottom <= size as i32 + 1, "{size}: {top} to {bottom}");
            let width = width(text, size) as i32;
            assert!(right <= width + 1 && right > width - size as i32 / 2, "{size}: {right} of {width}");
        }
    }

    #[test]
    fn every_sign_in_use_has_a_glyph() {
        for letter in (' '..='~').chain("éüß±×µ²Δθ–—‘’“”…←→−∞≈≠≤≥⁰⁻⁹".chars())
        {
            assert_eq!(known(letter), letter);
        }
        assert_eq!((known('\n'), known('漢')), ('?', '?'));
    }

    #[test]
    fn a_letter_is_upright_and_not_mirrored() {
        // The foot of an L points to the right of its stem.
        let (mut top, mut foot) = (0.0, 0.0);
        let [left, first, right, last] = ink("L", 40);
        draw("L", 40, |x, y, coverage| {
            if x > (left + right) / 2 {
                *(if y > (first + last) / 2 { &mut foot } else { &mut top }) += coverage;
            }
        });
        assert!(top == 0.0 && foot > 10.0, "{top} {foot}");
    }

    #[test]
    fn edges_are_smooth_and_the_inside_is_solid() {
        let (mut partial, mut full) = (0, 0);
        draw("O", 40, |_, _, coverage| if coverage < 0.95 { partial += 1 } else { full += 1 });
        assert!(partial > 50 && full > 100, "{partial} {full}");
    }
}

//! Pixels for plotters, with a bitmap font: no font file is needed.

use font8x8::{BASIC_FONTS, LATIN_FONTS, UnicodeFonts};
use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{BackendColor, BackendCoord, BackendTextStyle, DrawingBackend, DrawingErrorKind};
use std::convert::Infallible;

/// Pixels of a glyph's side before scaling.
const GLYPH: i32 = 8;
/// plotters' font sizes are line heights; glyphs are this much smaller, as in its SVG.
const LINE: f64 = 1.24;

/// 8-bit RGB rows.
pub(super) struct Raster<'a> {
    rgb: &'a mut [u8],
    width: u32,
    height: u32,
}

impl<'a> Raster<'a> {
    pub(super) fn new(rgb: &'a mut [u8], width: u32, height: u32) -> Raster<'a> {
        Raster { rgb, width, height }
    }
}

/// The whole factor by which the font is enlarged for a size.
fn factor(size: f64) -> i32 {
    ((size / LINE / f64::from(GLYPH)).floor() as i32).max(1)
}

/// A letter, as wide as its ink: plotters lays text out for a proportional font.
struct Glyph {
    rows: [u8; GLYPH as usize],
    /// First column with ink.
    first: i32,
    /// To the next letter.
    advance: i32,
}

impl Glyph {
    fn of(letter: char) -> Glyph {
        let rows = BASIC_FONTS.get(letter).or_else(|| LATIN_FONTS.get(letter)).or(BASIC_FONTS.get('?'));
        let rows = rows.unwrap_or_default();
        let ink = rows.iter().fold(0, |all, row| all | row);
        if ink == 0 {
            return Glyph { rows, first: 0, advance: GLYPH / 2 };
        }
        let (first, last) = (ink.trailing_zeros() as i32, 7 - ink.leading_zeros() as i32);
        Glyph { rows, first, advance: last - first + 2 }
    }
}

/// Of a text before enlarging.
fn length(text: &str) -> i32 {
    text.chars().map(|letter| Glyph::of(letter).advance).sum()
}

type Done = Result<(), DrawingErrorKind<Infallible>>;

impl DrawingBackend for Raster<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    fn ensure_prepared(&mut self) -> Done {
        Ok(())
    }

    fn present(&mut self) -> Done {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, color: BackendColor) -> Done {
        if (0..self.width as i32).contains(&x) && (0..self.height as i32).contains(&y) {
            let at = 3 * (y as usize * self.width as usize + x as usize);
            let (r, g, b) = color.rgb;
            for (old, new) in self.rgb[at..at + 3].iter_mut().zip([r, g, b]) {
                let mixed = f64::from(*old) * (1.0 - color.alpha) + f64::from(new) * color.alpha;
                *old = mixed.round() as u8;
            }
        }
        Ok(())
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, at: BackendCoord) -> Done {
        let k = factor(style.size());
        let (width, height) = (length(text) * k, GLYPH * k);
        let dx = match style.anchor().h_pos {
            HPos::Left => 0,
            HPos::Center => -width / 2,
            HPos::Right => -width,
        };
        let dy = match style.anchor().v_pos {
            VPos::Top => 0,
            VPos::Center => -height / 2,
            VPos::Bottom => -height,
        };
        let mut left = dx;
        for letter in text.chars() {
            let glyph = Glyph::of(letter);
            for (row, bits) in (0i32..).zip(glyph.rows) {
                for column in (0..GLYPH).filter(|column| bits >> column & 1 == 1) {
                    for dot in 0..k * k {
                        let x = left + (column - glyph.first) * k + dot % k;
                        let y = dy + row * k + dot / k;
                        let (x, y) = style.transform().transform(x, y);
                        self.draw_pixel((at.0 + x, at.1 + y), style.color())?;
                    }
                }
            }
            left += glyph.advance * k;
        }
        Ok(())
    }

    fn estimate_text_size<S: BackendTextStyle>(
        &self,
        text: &str,
        style: &S,
    ) -> Result<(u32, u32), DrawingErrorKind<Infallible>> {
        let k = factor(style.size());
        Ok(((length(text) * k) as u32, (GLYPH * k) as u32))
    }
}

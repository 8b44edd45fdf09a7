//! An 8-bit sRGB raster with rectangles, pictures and bitmap text.

use font8x8::{BASIC_FONTS, LATIN_FONTS, UnicodeFonts};

/// sRGB codes.
pub(crate) type Color = [u8; 3];

/// Pixels of a glyph's side before scaling.
const GLYPH: u32 = 8;

/// Rows from the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Canvas {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) rgb: Vec<u8>,
}

/// Pixels that `text` takes at a scale.
pub(crate) fn text_width(text: &str, scale: u32) -> u32 {
    text.chars().count() as u32 * GLYPH * scale
}

/// Pixels of a line of text.
pub(crate) const fn text_height(scale: u32) -> u32 {
    GLYPH * scale
}

impl Canvas {
    pub(crate) fn new(width: u32, height: u32, ground: Color) -> Canvas {
        let pixels = width as usize * height as usize;
        Canvas { width, height, rgb: ground.repeat(pixels) }
    }

    /// Fills a rectangle; what lies outside is dropped.
    pub(crate) fn fill(&mut self, [x, y]: [u32; 2], [width, height]: [u32; 2], color: Color) {
        for row in y..y.saturating_add(height).min(self.height) {
            for column in x..x.saturating_add(width).min(self.width) {
                self.set([column, row], color);
            }
        }
    }

    /// Copies a picture; what lies outside is dropped.
    pub(crate) fn paste(&mut self, [x, y]: [u32; 2], picture: &Canvas) {
        for (index, pixel) in (0u32..).zip(picture.rgb.as_chunks::<3>().0) {
            self.set([x + index % picture.width, y + index / picture.width], *pixel);
        }
    }

    /// One line of text, top left corner at `x, y`; characters the font lacks become `?`.
    pub(crate) fn text(&mut self, [x, y]: [u32; 2], text: &str, scale: u32, color: Color) {
        for (place, letter) in (0u32..).zip(text.chars()) {
            let glyph = BASIC_FONTS.get(letter).or_else(|| LATIN_FONTS.get(letter)).or(BASIC_FONTS.get('?'));
            for (row, bits) in (0u32..).zip(glyph.unwrap_or_default()) {
                for column in (0..GLYPH).filter(|column| bits >> column & 1 == 1) {
                    let at = [x + (place * GLYPH + column) * scale, y + row * scale];
                    self.fill(at, [scale, scale], color);
                }
            }
        }
    }

    fn set(&mut self, [x, y]: [u32; 2], color: Color) {
        if x < self.width && y < self.height {
            let at = 3 * (y as usize * self.width as usize + x as usize);
            self.rgb[at..at + 3].copy_from_slice(&color);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lit(canvas: &Canvas) -> Vec<String> {
        let row =
            |row: &[u8]| row.as_chunks::<3>().0.iter().map(|p| if p[0] > 0 { '#' } else { '.' }).collect();
        canvas.rgb.chunks(3 * canvas.width as usize).map(row).collect()
    }

    #[test]
    fn a_letter_is_upright_and_not_mirrored() {
        let mut canvas = Canvas::new(8, 8, [0; 3]);
        canvas.text([0, 0], "L", 1, [255; 3]);
        let rows = lit(&canvas);
        assert_eq!(&rows[0], "####....");
        assert_eq!(&rows[6], "#######.");
    }

    #[test]
    fn drawing_is_cut_at_the_edges() {
        let mut canvas = Canvas::new(3, 2, [0; 3]);
        canvas.fill([2, 1], [9, u32::MAX], [1; 3]);
        canvas.paste([1, 1], &Canvas::new(5, 5, [1; 3]));
        canvas.text([1, 1], "wide", 3, [0; 3]);
        assert_eq!(lit(&canvas)[0], "...");
        assert_eq!(canvas.rgb.len(), 18);
    }
}

//! The contact sheet: rows of pictures on a dark ground, each with its caption.

use crate::image::canvas::{Canvas, Color, text_height, text_width};
use crate::image::{Metadata, View, code8, png8};
use std::io::{self, Write};

// Dark, so that the pictures' own tones are seen against nothing brighter.
const GROUND: Color = [24, 26, 31];
const FRAME: Color = [52, 56, 66];
const TITLE: Color = [240, 242, 246];
const HEADING: Color = [126, 184, 236];
const CAPTION: Color = [214, 218, 226];
const DETAIL: Color = [146, 152, 164];

const MARGIN: u32 = 40;
/// Between pictures of a row.
const GAP: u32 = 24;
/// Between rows.
const ROW_GAP: u32 = 40;
const TITLE_SCALE: u32 = 3;
const TEXT_SCALE: u32 = 2;
/// From one line of text to the next.
const LINE: u32 = text_height(TEXT_SCALE) + 8;
/// Wider pictures are shrunk; up to here they are shown pixel by pixel, or one could not judge edges.
const WIDEST: u32 = 640;

/// A picture and what stands under it.
#[derive(Debug, Clone)]
pub struct Cell {
    picture: Canvas,
    captions: [String; 2],
}

/// Cells in a row under a heading.
#[derive(Debug, Clone)]
pub struct Section {
    /// Over the row.
    pub heading: String,
    /// From left to right.
    pub cells: Vec<Cell>,
}

/// All rows.
#[derive(Debug, Clone)]
pub struct Sheet {
    /// Over everything.
    pub title: String,
    /// A line below the title.
    pub subtitle: String,
    /// From top to bottom.
    pub sections: Vec<Section>,
}

impl Cell {
    /// The picture in sRGB, shrunk by a whole factor where it is too wide.
    pub fn new(view: View<'_>, captions: [String; 2]) -> Cell {
        Cell { picture: shrunk(view, view.width.div_ceil(WIDEST)), captions }
    }

    fn width(&self) -> u32 {
        let text = self.captions.iter().map(|c| text_width(c, TEXT_SCALE)).max().unwrap_or(0);
        text.max(self.picture.width)
    }
}

impl Section {
    fn width(&self) -> u32 {
        let cells: u32 = self.cells.iter().map(|c| c.width() + GAP).sum();
        cells.saturating_sub(GAP).max(text_width(&self.heading, TEXT_SCALE))
    }

    fn tallest(&self) -> u32 {
        self.cells.iter().map(|c| c.picture.height).max().unwrap_or(0)
    }

    /// Heading, rule, pictures, two captions.
    fn height(&self) -> u32 {
        LINE + GAP / 2 + self.tallest() + GAP / 2 + 2 * LINE
    }

    fn draw(&self, canvas: &mut Canvas, top: u32) {
        canvas.text([MARGIN, top], &self.heading, TEXT_SCALE, HEADING);
        canvas.fill([MARGIN, top + LINE], [canvas.width - 2 * MARGIN, 1], FRAME);
        let top = top + LINE + GAP / 2;
        let mut x = MARGIN;
        for cell in &self.cells {
            let picture = &cell.picture;
            canvas.fill([x - 1, top - 1], [picture.width + 2, picture.height + 2], FRAME);
            canvas.paste([x, top], picture);
            let mut y = top + picture.height + GAP / 2;
            for (caption, color) in cell.captions.iter().zip([CAPTION, DETAIL]) {
                canvas.text([x, y], caption, TEXT_SCALE, color);
                y += LINE;
            }
            x += cell.width() + GAP;
        }
    }
}

impl Sheet {
    /// Writes the sheet as a PNG.
    pub fn encode(&self, metadata: &Metadata, out: &mut dyn Write) -> io::Result<()> {
        let canvas = self.draw();
        png8(canvas.width, canvas.height, &canvas.rgb, metadata, out)
    }

    fn draw(&self) -> Canvas {
        let widest = self.sections.iter().map(Section::width).max().unwrap_or(0);
        let width =
            widest.max(text_width(&self.title, TITLE_SCALE)).max(text_width(&self.subtitle, TEXT_SCALE));
        let head = MARGIN + text_height(TITLE_SCALE) + 12 + LINE + ROW_GAP;
        let body: u32 = self.sections.iter().map(|s| s.height() + ROW_GAP).sum();
        let mut canvas =
            Canvas::new(width + 2 * MARGIN, head + body.saturating_sub(ROW_GAP) + MARGIN - 8, GROUND);
        canvas.text([MARGIN, MARGIN], &self.title, TITLE_SCALE, TITLE);
        canvas.text([MARGIN, MARGIN + text_height(TITLE_SCALE) + 12], &self.subtitle, TEXT_SCALE, DETAIL);
        let mut top = head;
        for section in &self.sections {
            section.draw(&mut canvas, top);
            top += section.height() + ROW_GAP;
        }
        canvas
    }
}

/// Means of `factor * factor` linear pixels, then encoded; cells at the right and bottom edge may be
/// smaller.
fn shrunk(view: View<'_>, factor: u32) -> Canvas {
    let (width, height) = (view.width.div_ceil(factor), view.height.div_ceil(factor));
    let mut rgb = Vec::with_capacity(3 * width as usize * height as usize);
    for y in 0..height {
        for x in 0..width {
            let (mut sum, mut count) = ([0.0f32; 3], 0.0);
            for row in y * factor..((y + 1) * factor).min(view.height) {
                for column in x * factor..((x + 1) * factor).min(view.width) {
                    let pixel = view.linear[row as usize * view.width as usize + column as usize];
                    // Clamped first: a pixel shows no brighter than white.
                    sum = std::array::from_fn(|c| sum[c] + pixel[c].clamp(0.0, 1.0));
                    count += 1.0;
                }
            }
            rgb.extend(sum.map(|c| code8(c / count)));
        }
    }
    Canvas { width, height, rgb }
}

#[cfg(test)]
mod tests;

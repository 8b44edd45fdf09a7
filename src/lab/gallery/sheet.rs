//! The contact sheet: rows of pictures on a dark ground, under each picture the parts in which the
//! row's pictures differ most, enlarged, and its caption.

use super::window::{Difference, differences};
use crate::image::canvas::{Canvas, Color};
use crate::image::{Metadata, View, code8, png8, text};
use std::io::{self, Write};

// Dark, so that the pictures' own tones are seen against nothing brighter.
const GROUND: Color = [24, 26, 31];
const FRAME: Color = [52, 56, 66];
const TITLE: Color = [240, 242, 246];
const HEADING: Color = [126, 184, 236];
const CAPTION: Color = [214, 218, 226];
const DETAIL: Color = [146, 152, 164];
/// Frames of enlarged parts: yellow and magenta, which the colour-blind can tell apart.
const PARTS: [Color; 2] = [[255, 214, 64], [255, 92, 214]];

const MARGIN: u32 = 40;
/// Between pictures of a row.
const GAP: u32 = 32;
/// Between a picture and what belongs to it.
const NEAR: u32 = 12;
/// Between rows.
const ROW_GAP: u32 = 56;
/// Heights of lines of text.
const TITLE_SIZE: u32 = 56;
const HEADING_SIZE: u32 = 38;
const TEXT_SIZE: u32 = 30;
/// From one line of text to the next.
const LINE: u32 = TEXT_SIZE + 6;
/// Wider pictures are shrunk. The sheet's widest picture is shown this wide or a little less: pixel
/// by pixel or enlarged by a whole factor, or one could not judge edges.
const WIDEST: u32 = 640;
/// Width of the frame round a part, in its picture and round its enlargement.
const BORDER: u32 = 3;
/// Parts are enlarged by this factor more than their picture.
const ENLARGED: u32 = 4;

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
}

/// A row with all that is drawn of it.
struct Row<'a> {
    section: &'a Section,
    /// Pictures as large as they are shown, and the factor to that size.
    shown: Vec<(Canvas, u32)>,
    parts: Vec<Difference>,
}

impl<'a> Row<'a> {
    /// Pictures become as wide as `width` or, as only whole factors are used, a little less.
    fn new(section: &'a Section, width: u32) -> Row<'a> {
        let pictures: Vec<&Canvas> = section.cells.iter().map(|c| &c.picture).collect();
        let factor = |picture: &Canvas| (width / picture.width).max(1);
        let shown = pictures.iter().map(|p| (p.enlarged(factor(p)), factor(p))).collect();
        // Enlarged, all of a picture's parts are as wide as the picture together.
        let count = PARTS.len() as u32;
        let size = pictures.first().map_or([0, 0], |p| {
            let room = (p.width * factor(p)).saturating_sub((count - 1) * NEAR) / count;
            let width = room / (ENLARGED * factor(p));
            [width, (width * p.height).div_ceil(p.width)]
        });
        // A picture of few pixels is large enough as it is.
        let parts = if size[0] == 0 { Vec::new() } else { differences(&pictures, size, PARTS.len()) };
        Row { section, shown, parts }
    }

    /// What the frames mean, each with its colour.
    fn legend(&self) -> Vec<(String, Color)> {
        let name = |i: usize| &self.section.cells[i].captions[0];
        let line = |part: &Difference| {
            let (left, right) = (name(part.right - 1), name(part.right));
            format!("×{ENLARGED}: where “{left}” and “{right}” differ most")
        };
        self.parts.iter().map(line).zip(PARTS).collect()
    }

    fn legend_widths(&self) -> Vec<u32> {
        self.legend().iter().map(|(line, _)| TEXT_SIZE + text::width(line, TEXT_SIZE)).collect()
    }

    fn cell_width(&self, i: usize) -> u32 {
        let captions = self.section.cells[i].captions.iter().map(|c| text::width(c, TEXT_SIZE));
        captions.max().unwrap_or(0).max(self.shown[i].0.width)
    }

    fn width(&self) -> u32 {
        let cells: u32 = (0..self.shown.len()).map(|i| self.cell_width(i) + GAP).sum();
        let legend: u32 = self.legend_widths().iter().map(|w| w + GAP).sum();
        cells.max(legend).saturating_sub(GAP).max(text::width(&self.section.heading, HEADING_SIZE))
    }

    /// From the row's top to its pictures: heading, rule, legend.
    fn head(&self) -> u32 {
        HEADING_SIZE + NEAR + 1 + NEAR + if self.parts.is_empty() { 0 } else { LINE + NEAR }
    }

    /// Height of the tallest picture, and of the tallest with its parts.
    fn tallest(&self) -> [u32; 2] {
        let height = |(picture, factor): &(Canvas, u32)| {
            let part = |d: &Difference| NEAR + d.window.size[1] * factor * ENLARGED;
            [picture.height, picture.height + self.parts.iter().map(part).max().unwrap_or(0)]
        };
        self.shown.iter().map(height).fold([0, 0], |[a, b], [c, d]| [a.max(c), b.max(d)])
    }

    fn height(&self) -> u32 {
        self.head() + self.tallest()[1] + NEAR + 2 * LINE
    }

    fn draw(&self, canvas: &mut Canvas, top: u32) {
        canvas.text([MARGIN, top], &self.section.heading, HEADING_SIZE, HEADING);
        canvas.fill([MARGIN, top + HEADING_SIZE + NEAR], [canvas.width - 2 * MARGIN, 1], FRAME);
        let mut x = MARGIN;
        let y = top + HEADING_SIZE + NEAR + 1 + NEAR;
        for ((line, color), width) in self.legend().iter().zip(self.legend_widths()) {
            canvas.outline([x + BORDER, y + 8], [TEXT_SIZE - 16; 2], BORDER, *color);
            canvas.text([x + TEXT_SIZE, y], line, TEXT_SIZE, DETAIL);
            x += width + GAP;
        }
        let top = top + self.head();
        let mut x = MARGIN;
        for (i, cell) in self.section.cells.iter().enumerate() {
            self.draw_pictures(canvas, i, [x, top]);
            let mut y = top + self.tallest()[1] + NEAR;
            for (caption, color) in cell.captions.iter().zip([CAPTION, DETAIL]) {
                canvas.text([x, y], caption, TEXT_SIZE, color);
                y += LINE;
            }
            x += self.cell_width(i) + GAP;
        }
    }

    /// Draws a cell's picture and its parts below.
    fn draw_pictures(&self, canvas: &mut Canvas, i: usize, [x, top]: [u32; 2]) {
        let (shown, factor) = &self.shown[i];
        canvas.outline([x, top], [shown.width, shown.height], 1, FRAME);
        canvas.paste([x, top], shown);
        let mut left = x;
        for (part, color) in self.parts.iter().zip(PARTS) {
            let [corner, size] = [part.window.corner, part.window.size].map(|p| p.map(|c| c * factor));
            canvas.outline([x + corner[0], top + corner[1]], size, 1, color);
            let part = shown.cropped(corner, size).enlarged(ENLARGED);
            let at = [left, top + self.tallest()[0] + NEAR];
            canvas.outline(at, [part.width, part.height], BORDER, color);
            canvas.paste(at, &part);
            left += part.width + NEAR;
        }
    }
}

impl Sheet {
    /// Writes the sheet as a PNG.
    pub fn encode(&self, metadata: &Metadata, out: &mut dyn Write) -> io::Result<()> {
        let canvas = self.draw();
        png8(canvas.width, canvas.height, &canvas.rgb, metadata, out)
    }

    /// Width at which the pictures are shown: that of the widest, by a whole factor.
    fn shown_width(&self) -> u32 {
        let widest = self.sections.iter().flat_map(|s| &s.cells).map(|c| c.picture.width).max().unwrap_or(1);
        widest * (WIDEST / widest).max(1)
    }

    fn draw(&self) -> Canvas {
        let shown = self.shown_width();
        let rows: Vec<Row<'_>> = self.sections.iter().map(|s| Row::new(s, shown)).collect();
        let widest = rows.iter().map(Row::width).max().unwrap_or(0);
        let width =
            widest.max(text::width(&self.title, TITLE_SIZE)).max(text::width(&self.subtitle, TEXT_SIZE));
        let head = MARGIN + TITLE_SIZE + LINE + ROW_GAP;
        let body: u32 = rows.iter().map(|row| row.height() + ROW_GAP).sum();
        let mut canvas =
            Canvas::new(width + 2 * MARGIN, head + body.saturating_sub(ROW_GAP) + MARGIN, GROUND);
        canvas.text([MARGIN, MARGIN], &self.title, TITLE_SIZE, TITLE);
        canvas.text([MARGIN, MARGIN + TITLE_SIZE], &self.subtitle, TEXT_SIZE, DETAIL);
        let mut top = head;
        for row in &rows {
            row.draw(&mut canvas, top);
            top += row.height() + ROW_GAP;
        }
        canvas
    }
}

/// Means of `factor * factor` linear pixels, then encoded; cells at the right and bottom edge may
/// be smaller.
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

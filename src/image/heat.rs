//! Numbers as colours: the map "inferno" of Smith and van der Walt (matplotlib, 2015), in which a larger
//! number is always lighter, and pictures of such numbers above a legend: quantity, unit, colour bar and scale.

use super::canvas::{Canvas, Color};
use super::{Metadata, png8, text};
use crate::units::figure;
use std::io::{self, Write};

/// Colour of what is not a number: none that [`heat`] gives.
pub const NO_NUMBER: [u8; 3] = [0, 255, 255];
const GROUND: Color = [24, 26, 31];
const TEXT: Color = [214, 218, 226];

/// Between legend and edges.
const GAP: u32 = 6;
/// Height of the bar.
const BAR: u32 = 12;
/// Least width of a legend; the area beside a narrower picture stays empty.
const LEGEND_LEAST: u32 = 240;
/// Height of a line of the legend's text: of narrow pictures, and from [`LARGE`] pixels of width on.
const LINES: [u32; 2] = [14, 24];
const LARGE: u32 = 600;

/// sRGB code of a number in [0, 1]: black, violet, red, orange, pale yellow. Outside, the nearest end;
/// [`NO_NUMBER`] for NaN.
pub fn heat(value01: f64) -> [u8; 3] {
    if value01.is_nan() {
        return NO_NUMBER;
    }
    colorous::INFERNO.eval_continuous(value01.clamp(0.0, 1.0)).as_array()
}

/// The numbers at the ends of the colour bar.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Range {
    /// The smaller of 0 and the least finite number of the picture, and the greatest.
    #[default]
    Auto,
    /// These; numbers outside get the colour of the nearer end.
    Given(f64, f64),
}

/// A painted picture with its legend below.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Painted {
    canvas: Canvas,
}

impl Range {
    /// The ends, in ascending order.
    pub fn ends(self, values: &[f64]) -> (f64, f64) {
        match self {
            Range::Given(a, b) => (a.min(b), a.max(b)),
            Range::Auto => values
                .iter()
                .filter(|v| v.is_finite())
                .fold((0.0, 0.0), |(lo, hi): (f64, f64), v| (lo.min(*v), hi.max(*v))),
        }
    }
}

/// Paints rows of `width` numbers, and below them a legend. `what` is the quantity and its unit; it is wrapped to
/// the width of the picture. An incomplete last row is left out.
pub fn paint(values: &[f64], width: u32, range: Range, what: &str) -> Painted {
    let height = values.len().checked_div(width as usize).unwrap_or(0) as u32;
    let (lo, hi) = range.ends(values);
    let place = |v: f64| if hi > lo { (v - lo) / (hi - lo) } else { v - lo };
    let line = LINES[usize::from(width >= LARGE)];
    let missing = values.iter().any(|v| v.is_nan());
    let what = if missing { format!("{what} (cyan: no value)") } else { what.to_owned() };
    let full = width.max(LEGEND_LEAST);
    let titles = wrapped(&what, full - 2 * GAP, line);
    let strip = titles.len() as u32 * line + BAR + line + 4 * GAP;
    let mut canvas = Canvas::new(full, height + strip, GROUND);
    for (i, value) in (0u32..).zip(&values[..width as usize * height as usize]) {
        canvas.fill([i % width, i / width], [1, 1], heat(place(*value)));
    }

    let mut top = height + GAP;
    for title in &titles {
        canvas.text([GAP, top], title, line, TEXT);
        top += line;
    }
    top += GAP;
    let (left, bar) = (GAP, canvas.width - 2 * GAP);
    for x in 0..bar {
        canvas.fill([left + x, top], [1, BAR], heat(f64::from(x) / f64::from(bar - 1)));
    }
    top += BAR + GAP;
    let middle = lo + (hi - lo) / 2.0;
    let labels = [lo, middle, hi].map(figure);
    let widths = [0, 1, 2].map(|i| text::width(&labels[i], line));
    let places = [left, left + (bar.saturating_sub(widths[1])) / 2, left + bar.saturating_sub(widths[2])];
    for (label, x) in labels.iter().zip(places) {
        canvas.text([x, top], label, line, TEXT);
    }
    Painted { canvas }
}

/// Breaks a text between words into lines of at most `width` pixels. A longer word is a line of its own.
fn wrapped(text: &str, width: u32, size: u32) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let last = lines.len() - 1;
        let longer = if lines[last].is_empty() { word.to_owned() } else { format!("{} {word}", lines[last]) };
        if lines[last].is_empty() || text::width(&longer, size) <= width {
            lines[last] = longer;
        } else {
            lines.push(word.to_owned());
        }
    }
    lines
}

impl Painted {
    /// Pixels with the legend: width and height.
    pub fn size(&self) -> [u32; 2] {
        [self.canvas.width, self.canvas.height]
    }

    /// sRGB codes, three a pixel, rows from the top.
    pub fn rgb(&self) -> &[u8] {
        &self.canvas.rgb
    }

    /// As a PNG.
    ///
    /// # Errors
    /// If `out` cannot be written.
    pub fn write(&self, metadata: &Metadata, out: &mut dyn Write) -> io::Result<()> {
        png8(self.canvas.width, self.canvas.height, &self.canvas.rgb, metadata, out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::linear8;

    /// Relative luminance of a code, the sum of IEC 61966-2-1 (ITU-R BT.709 weights).
    fn luminance(rgb: [u8; 3]) -> f32 {
        rgb.iter().zip([0.2126, 0.7152, 0.0722]).map(|(c, w)| w * linear8(*c)).sum()
    }

    #[test]
    fn more_is_lighter() {
        let steps: Vec<f32> = (0..=64).map(|i| luminance(heat(f64::from(i) / 64.0))).collect();
        assert!(steps.is_sorted_by(|a, b| a < b), "{steps:?}");
        assert!(steps[0] < 0.001 && steps[64] > 0.9);
        // The comparer notices a map that is not ordered: the rainbow.
        let rainbow: Vec<f32> = (0..=64)
            .map(|i| luminance(colorous::TURBO.eval_continuous(f64::from(i) / 64.0).as_array()))
            .collect();
        assert!(!rainbow.is_sorted_by(|a, b| a < b));
    }

    #[test]
    fn odd_numbers_have_a_colour() {
        assert_eq!((heat(-3.0), heat(f64::NEG_INFINITY)), (heat(0.0), heat(0.0)));
        assert_eq!((heat(1.5), heat(f64::INFINITY)), (heat(1.0), heat(1.0)));
        assert_eq!(heat(f64::NAN), NO_NUMBER);
        assert!((0..=1000).all(|i| heat(f64::from(i) / 1000.0) != NO_NUMBER));
    }

    fn pixel(painted: &Painted, x: u32, y: u32) -> [u8; 3] {
        let at = 3 * (y * painted.size()[0] + x) as usize;
        [0, 1, 2].map(|c| painted.rgb()[at + c])
    }

    #[test]
    fn a_picture_is_painted_in_place_with_its_scale() {
        let values = [0.0, 1.0, 2.0, 4.0, f64::NAN, f64::INFINITY];
        let painted = paint(&values, 3, Range::Auto, "steps");
        assert_eq!(Range::Auto.ends(&values), (0.0, 4.0));
        let expected = [0.0, 0.25, 0.5, 1.0, f64::NAN, 1.0].map(heat);
        for (i, color) in (0u32..).zip(expected) {
            assert_eq!(pixel(&painted, i % 3, i / 3), color, "value {i}");
        }
        // The bar runs from one end of the colours to the other.
        let [width, height] = painted.size();
        assert_eq!((width, height), (LEGEND_LEAST, 2 + 2 * LINES[0] + BAR + 4 * GAP));
        let row = 2 + GAP + LINES[0] + GAP + BAR / 2;
        assert_eq!(
            (pixel(&painted, GAP, row), pixel(&painted, width - GAP - 1, row)),
            (heat(0.0), heat(1.0))
        );
        // Another scale is told by other digits, and no scale by none.
        let other = paint(&values, 3, Range::Given(0.0, 8.0), "steps");
        assert_ne!(painted.rgb()[3 * (row * width) as usize..], other.rgb()[3 * (row * width) as usize..]);
        assert_eq!(pixel(&other, 0, 1), heat(0.5));
        let mut png = Vec::new();
        painted.write(&Metadata::default(), &mut png).unwrap();
        assert_eq!(::image::load_from_memory(&png).unwrap().into_rgb8().as_raw(), painted.rgb());
    }

    #[test]
    fn legends_fit_at_every_width() {
        let long = "truncation: upper bound on light from rays not traced, linear light (cyan: no value)";
        for (width, what) in [1, 96, 240, 599, 600, 1920].into_iter().flat_map(|w| [(w, long), (w, "steps")])
        {
            let (full, size) = (width.max(LEGEND_LEAST), LINES[usize::from(width >= LARGE)]);
            let lines = wrapped(what, full - 2 * GAP, size);
            assert_eq!(lines.join(" "), what);
            assert!(lines.iter().all(|l| text::width(l, size) <= full - 2 * GAP), "{width}: {lines:?}");
            // Nothing touches the right edge of the legend.
            let painted = paint(&vec![1.234e-5; width as usize], width, Range::Auto, what);
            assert!(
                (1..painted.size()[1]).all(|y| pixel(&painted, full - 1, y) == GROUND),
                "{width}: {what}"
            );
            // The labels of the scale do not run into each other.
            let labels = [-1.234e-10, 1.234e-10, 9.876e-10].map(|v| text::width(&figure(v), size));
            assert!(labels.iter().sum::<u32>() + 2 * GAP <= full - 2 * GAP);
        }
    }

    #[test]
    fn flat_and_empty_pictures_are_no_trouble() {
        assert_eq!(pixel(&paint(&[0.0; 4], 2, Range::Auto, ""), 1, 1), heat(0.0));
        assert_eq!(Range::Given(2.0, 1.0).ends(&[]), (1.0, 2.0));
        assert_eq!(Range::Auto.ends(&[3.0, 5.0, f64::NAN]), (0.0, 5.0));
        assert_eq!(Range::Auto.ends(&[-2.0, -1.0]), (-2.0, 0.0));
        paint(&[], 0, Range::Auto, "nothing");
        let wide = paint(&[1.0; 700], 700, Range::Auto, "one row");
        assert_eq!(wide.size(), [700, 1 + 2 * LINES[1] + BAR + 4 * GAP]);
    }
}

//! Numbers as colours: the map "inferno" of Smith and van der Walt (matplotlib, 2015), in which a larger
//! number is always lighter, and pictures of such numbers with a bar that tells the scale.

use super::canvas::{Canvas, Color};
use super::{Metadata, png8, text};
use crate::units::number;
use std::io::{self, Write};

/// Colour of what is not a number: none that [`heat`] gives.
pub const NO_NUMBER: [u8; 3] = [0, 255, 255];
const GROUND: Color = [24, 26, 31];
const TEXT: Color = [214, 218, 226];

/// Between legend and edges.
const GAP: u32 = 6;
/// Height of the bar.
const BAR: u32 = 12;
/// Narrower pictures get a legend of this width beside empty ground.
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

/// Which numbers the ends of the colours stand for.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Range {
    /// The least (or 0, if that is less) and the greatest finite number of the picture.
    #[default]
    Auto,
    /// These; numbers beyond take the colour of the end.
    Given(f64, f64),
}

/// A painted picture with its legend below.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Painted {
    canvas: Canvas,
}

impl Range {
    /// The ends, the first less than the second or equal to it.
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

/// Paints rows of `width` numbers, and below them what the colours mean; `what` names the numbers and
/// their unit. What does not fill a row is left out.
pub fn paint(values: &[f64], width: u32, range: Range, what: &str) -> Painted {
    let height = values.len().checked_div(width as usize).unwrap_or(0) as u32;
    let (lo, hi) = range.ends(values);
    let place = |v: f64| if hi > lo { (v - lo) / (hi - lo) } else { v - lo };
    let line = LINES[usize::from(width >= LARGE)];
    let strip = line + BAR + line + 4 * GAP;
    let mut canvas = Canvas::new(width.max(LEGEND_LEAST), height + strip, GROUND);
    for (i, value) in (0u32..).zip(&values[..width as usize * height as usize]) {
        canvas.fill([i % width, i / width], [1, 1], heat(place(*value)));
    }

    let missing = values.iter().any(|v| v.is_nan());
    let what = if missing { format!("{what} (cyan: no number)") } else { what.to_owned() };
    let mut top = height + GAP;
    canvas.text([GAP, top], &what, line, TEXT);
    top += line + GAP;
    let (left, bar) = (GAP, canvas.width - 2 * GAP);
    for x in 0..bar {
        canvas.fill([left + x, top], [1, BAR], heat(f64::from(x) / f64::from(bar - 1)));
    }
    top += BAR + GAP;
    let middle = lo + (hi - lo) / 2.0;
    let labels = [lo, middle, hi].map(|v| number(format!("{v:.2e}").parse().unwrap_or(v)));
    let widths = [0, 1, 2].map(|i| text::width(&labels[i], line));
    let places = [left, left + (bar.saturating_sub(widths[1])) / 2, left + bar.saturating_sub(widths[2])];
    for (label, x) in labels.iter().zip(places) {
        canvas.text([x, top], label, line, TEXT);
    }
    Painted { canvas }
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

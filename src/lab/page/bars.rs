//! Horizontal bars as SVG: one row per item, with a line for a range where there is one.

use super::markup::escaped;
use std::fmt::Write;

/// Pixels of a row, of the names, of the longest bar, and of the texts behind the bars.
const ROW: f64 = 22.0;
const NAMES: f64 = 150.0;
const LONGEST: f64 = 400.0;
const TEXTS: f64 = 210.0;

/// A row.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Bar {
    /// Left of the bar.
    pub name: String,
    /// Length; not negative.
    pub value: f64,
    /// Lower and upper end of a thin line over the end of the bar.
    pub range: Option<[f64; 2]>,
    /// Right of the bar.
    pub text: String,
}

/// The bars in the order given, drawn to one scale from 0; `title` is for screen readers.
pub(crate) fn svg(title: &str, bars: &[Bar]) -> String {
    let ends = bars.iter().map(|b| b.range.map_or(b.value, |[_, upper]| upper.max(b.value)));
    let longest = ends.filter(|x| x.is_finite()).fold(0.0, f64::max);
    let place =
        |x: f64| if longest > 0.0 && x.is_finite() { (x / longest).clamp(0.0, 1.0) * LONGEST } else { 0.0 };
    let (width, height) = (NAMES + LONGEST + TEXTS, ROW * bars.len() as f64);
    let mut text = format!(
        "<svg class=\"bars\" viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{}\">\n",
        escaped(title)
    );
    for (i, bar) in bars.iter().enumerate() {
        let top = ROW * i as f64;
        let middle = top + 0.5 * ROW;
        let (length, name, words) = (place(bar.value), escaped(&bar.name), escaped(&bar.text));
        let end = bar.range.map_or(length, |[_, upper]| place(upper).max(length));
        let _ = write!(
            text,
            "<g><text x=\"{:.1}\" y=\"{middle:.1}\" class=\"name\">{name}</text>\
             <rect x=\"{NAMES}\" y=\"{:.1}\" width=\"{length:.1}\" height=\"{:.1}\"/>",
            NAMES - 8.0,
            top + 3.0,
            ROW - 6.0,
        );
        if let Some([lower, upper]) = bar.range {
            let (x0, x1) = (NAMES + place(lower), NAMES + place(upper));
            let _ = write!(
                text,
                "<path d=\"M{x0:.1} {middle:.1}H{x1:.1}M{x0:.1} {:.1}v8M{x1:.1} {:.1}v8\"/>",
                middle - 4.0,
                middle - 4.0
            );
        }
        let _ = writeln!(text, "<text x=\"{:.1}\" y=\"{middle:.1}\">{words}</text></g>", NAMES + end + 8.0);
    }
    text + "</svg>\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bar(value: f64) -> Bar {
        Bar { name: "a<b".into(), value, range: None, text: "1 s".into() }
    }

    #[test]
    fn lengths_are_to_scale() {
        let text = svg("time", &[bar(1.0), bar(4.0), Bar { range: Some([3.0, 8.0]), ..bar(4.0) }]);
        for width in ["width=\"50.0\"", "width=\"200.0\""] {
            assert!(text.contains(width), "{text}");
        }
        assert!(text.contains("M300.0 55.0H550.0") && text.contains("a&lt;b"), "{text}");
    }

    #[test]
    fn nothing_and_odd_values_have_no_length() {
        assert!(svg("time", &[]).starts_with("<svg"));
        let text = svg("time", &[bar(0.0), bar(f64::NAN), bar(f64::INFINITY)]);
        assert_eq!(text.matches("width=\"0.0\"").count(), 3, "{text}");
    }
}

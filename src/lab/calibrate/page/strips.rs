//! Values with intervals, one line each: drawn as SVG by hand, since the axis holds names.

use super::html::escaped;
use crate::lab::calibrate::{FamilySummary, Tally};
use std::fmt::Write;

/// Pixels.
const LEFT: f64 = 270.0;
const WIDTH: f64 = 560.0;
const RIGHT: f64 = 150.0;
const ROW: f64 = 20.0;
const TOP: f64 = 10.0;

/// One line of a plot.
struct Strip {
    name: String,
    /// Low end, value and high end, as places from 0 to 1.
    places: [f64; 3],
    /// Shown at the right.
    figure: String,
    color: &'static str,
}

/// Coverage of `--budget` and `--error` by family.
pub(super) fn coverage(summaries: &[FamilySummary], confidence: f64) -> String {
    let mut strips = Vec::new();
    let mut add = |name: String, tally: Tally| {
        let share = tally.decided;
        if share.of > 0 {
            let interval = share.interval();
            strips.push(Strip {
                name,
                places: [interval.low, share.value(), interval.high],
                figure: share.to_string(),
                color: if interval.high < confidence { "#d55e00" } else { "#0072b2" },
            });
        }
    };
    for s in summaries {
        s.budget.iter().for_each(|b| add(format!("{}, --samples {}", s.name, b.samples), b.total));
        s.error.iter().for_each(|e| add(format!("{}, --error {}", s.name, e.target), e.kept));
    }
    let ticks: Vec<(f64, String)> =
        [0.0, 0.25, 0.5, 0.75, 1.0].map(|x| (x, format!("{} %", 100.0 * x))).into();
    svg(&strips, confidence, &ticks)
}

/// Gain in rays by family.
pub(super) fn gain(summaries: &[FamilySummary]) -> String {
    // Powers of two from 1/16 to 16.
    let place = |x: f64| ((x.log2() + 4.0) / 8.0).clamp(0.0, 1.0);
    let mut strips = Vec::new();
    for s in summaries {
        for e in &s.error {
            if let (Some(gain), Some([low, high])) = (e.gain_rays, e.gain_range) {
                strips.push(Strip {
                    name: format!("{}, --error {}", s.name, e.target),
                    places: [place(low), place(gain), place(high)],
                    figure: format!("x{gain:.2} (x{low:.2} to x{high:.2})"),
                    color: if gain < 1.0 { "#d55e00" } else { "#0072b2" },
                });
            }
        }
    }
    let ticks: Vec<(f64, String)> = (-4..=4)
        .map(|k| {
            let name = if k < 0 { format!("1/{}", 1 << -k) } else { format!("{}", 1 << k) };
            (place(2f64.powi(k)), name)
        })
        .collect();
    svg(&strips, place(1.0), &ticks)
}

fn svg(strips: &[Strip], mark: f64, ticks: &[(f64, String)]) -> String {
    if strips.is_empty() {
        return "<p>No trial.</p>\n".into();
    }
    let bottom = TOP + ROW * strips.len() as f64;
    let (width, height) = (LEFT + WIDTH + RIGHT, bottom + 24.0);
    let x = |place: f64| LEFT + WIDTH * place;
    let mut text = format!(
        "<div class=\"scroll\"><svg width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" role=\"img\" \
         font-family=\"sans-serif\" font-size=\"13\">\n"
    );
    let mut line = |x1: f64, y1: f64, x2: f64, y2: f64, color: &str, stroke: f64| {
        let _ = writeln!(
            text,
            "<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" stroke=\"{color}\" stroke-width=\"{stroke}\"/>"
        );
    };
    ticks.iter().for_each(|(at, _)| line(x(*at), TOP, x(*at), bottom, "#e3e6ea", 1.0));
    line(x(mark), TOP, x(mark), bottom, "#969696", 2.0);
    let y = |i: usize| TOP + ROW * (i as f64 + 0.5);
    for (i, strip) in strips.iter().enumerate() {
        line(x(strip.places[0]), y(i), x(strip.places[2]), y(i), strip.color, 2.0);
    }
    for (i, Strip { name, places, figure, color }) in strips.iter().enumerate() {
        let base = y(i) + 4.5;
        let _ = writeln!(
            text,
            "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"4\" fill=\"{color}\"/><text x=\"{:.1}\" y=\"{base:.1}\" \
             text-anchor=\"end\">{}</text><text x=\"{:.1}\" y=\"{base:.1}\">{}</text>",
            x(places[1]),
            y(i),
            LEFT - 10.0,
            escaped(name),
            LEFT + WIDTH + 8.0,
            escaped(figure)
        );
    }
    for (at, name) in ticks {
        let (at, base) = (x(*at), bottom + 16.0);
        let _ = writeln!(text, "<text x=\"{at:.1}\" y=\"{base:.1}\" text-anchor=\"middle\">{name}</text>");
    }
    text + "</svg></div>\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_strip_reaches_from_its_low_to_its_high_end() {
        let strip =
            Strip { name: "<a>".into(), places: [0.0, 0.5, 1.0], figure: "1/2".into(), color: "#000" };
        let text = svg(&[strip], 0.95, &[(0.0, "0".into())]);
        assert!(text.contains("&lt;a&gt;") && text.contains("x1=\"270.0\"") && text.contains("x2=\"830.0\""));
        assert!(text.contains("cx=\"550.0\"") && !text.contains("NaN"));
    }
}

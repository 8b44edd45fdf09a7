//! The page of the extremes: what a device makes of them, generated from a run on it.

mod chaos;
mod cost;
mod epsilon;

use crate::lab::markdown::{number, table};
use crate::lab::plot;
use crate::render::{RenderError, Renderer};
use crate::report::table::Align::Left;
use crate::settings::Precision;

/// A case and what came of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// The case's name.
    pub name: &'static str,
    /// The failure it stands for.
    pub stands_for: &'static str,
    /// Where the bound comes from.
    pub derivation: &'static str,
    /// What came out.
    pub figure: f64,
    /// What may come out.
    pub bound: f64,
    /// What both count.
    pub unit: String,
    /// True if the bound is kept.
    pub passed: bool,
}

/// The page and the pictures that lie beside it.
#[derive(Debug, Clone)]
pub struct Page {
    /// Markdown.
    pub text: String,
    /// File names and SVG text.
    pub pictures: Vec<(&'static str, String)>,
}

/// Why there is no page.
#[derive(Debug, thiserror::Error)]
pub enum PageError {
    /// The device failed.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The user interrupted.
    #[error("interrupted: no page is written")]
    Stopped,
    /// A figure or picture could not be made.
    #[error("{0}")]
    Figure(String),
}

/// Ends the page's work where the user asks for it.
type Stop<'a> = &'a dyn Fn() -> bool;

fn running(stop: Stop<'_>) -> Result<(), PageError> {
    if stop() { Err(PageError::Stopped) } else { Ok(()) }
}

/// Measures what the page needs and writes it. `command` is what made it; `say` gets each step's name, `stop` ends the work.
///
/// # Errors
/// If the device fails, or the user interrupts.
pub fn make(
    renderer: &mut Renderer,
    precision: Precision,
    outcomes: &[Outcome],
    command: &str,
    say: &mut dyn FnMut(&str),
    stop: Stop<'_>,
) -> Result<Page, PageError> {
    let device = renderer.device().info();
    let is_cpu = device.kind == "cpu";
    let mut pictures = Vec::new();
    let mut draw = |name: &'static str, charts: &[plot::Chart]| {
        let svg = plot::svg(charts, (1000, 400)).map_err(PageError::Figure)?;
        pictures.push((name, svg));
        Ok::<_, PageError>(())
    };

    say("error against epsilon");
    let epsilon = epsilon::measure(renderer, precision, stop)?;
    draw("epsilon.svg", &epsilon.charts())?;
    let chaos = if renderer.device().has_double() {
        say("single against double precision");
        let chaos = chaos::measure(renderer, stop)?;
        draw("chaos.svg", &chaos.charts())?;
        format!(
            "{}\n![Paths that differ, and the distance between them, against depth](chaos.svg)\n",
            chaos.text()
        )
    } else {
        "Not measured: this device has no double precision.\n".into()
    };
    say("what protections cost");
    let cost = cost::measure(renderer, stop)?.text(&device.kind);

    let lavapipe = if is_cpu {
        "The device is a CPU driver. **Its times are its own and say nothing of a GPU**; its errors are those of f32 \
         as this driver rounds it.\n\n"
    } else {
        ""
    };
    let text = format!(
        "# The extremes\n\n\
         <!-- Generated; do not edit. -->\n\
         Made by `{command}`, which measures all that is below and writes this page and its pictures anew.\n\n\
         Device: {} ({}), {}, Vulkan {}. Precision: `{}`, where nothing else is said.\n{lavapipe}\
         - [Cases](#cases)\n\
         - [Error against epsilon](#error-against-epsilon)\n\
         - [Single against double precision](#single-against-double-precision)\n\
         - [What protections cost](#what-protections-cost)\n\n\
         ## Cases\n\n{}\n\
         ## Error against epsilon\n\n{}\n\
         ![Error and wrong pixels against a fixed epsilon](epsilon.svg)\n\n\
         ## Single against double precision\n\n{chaos}\n\
         ## What protections cost\n\n{cost}",
        device.name,
        device.kind,
        device.driver,
        device.api,
        precision.name(),
        cases(outcomes),
        epsilon.text(),
    );
    Ok(Page { text, pictures })
}

fn cases(outcomes: &[Outcome]) -> String {
    let rows: Vec<[String; 6]> = outcomes
        .iter()
        .map(|o| {
            [
                format!("`{}`", o.name),
                o.stands_for.into(),
                format!("{} {}", number(o.figure), o.unit),
                number(o.bound),
                if o.passed { "pass".into() } else { "**FAIL**".into() },
                o.derivation.into(),
            ]
        })
        .collect();
    let failed = outcomes.iter().filter(|o| !o.passed).count();
    let columns = ["case", "stands for", "figure", "bound", "verdict", "the bound comes from"];
    format!(
        "{} cases, {failed} failed. `whitted stress --list` says what each does.\n\n{}",
        outcomes.len(),
        table(&columns.map(|c| (c, Left)), &rows)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failing_case_is_published_as_failing() {
        let good = Outcome {
            name: "holes",
            stands_for: "light | seams",
            derivation: "exact",
            figure: 0.0,
            bound: 0.0,
            unit: "misses".into(),
            passed: true,
        };
        let bad = Outcome { name: "drift", figure: f64::NAN, passed: false, ..good.clone() };
        let text = cases(&[good, bad]);
        assert!(text.starts_with("2 cases, 1 failed."), "{text}");
        assert!(text.contains("| `holes` | light \\| seams | 0 misses | 0 | pass | exact |"), "{text}");
        assert!(text.contains("| `drift` | light \\| seams | NaN misses | 0 | **FAIL** | exact |"), "{text}");
    }
}

//! The calibration as a self-contained HTML page with plots.

mod html;
mod scatter;
mod strips;

use super::Calibration;
use crate::units;
use html::{escaped, paragraph};

/// The style of the sweep's page.
const STYLE: &str = include_str!("../../page/page.css");

const SCATTER: &str = "Each dot is one render: its true error, and the bound that it stated. A dot below the line is a bound \
                       that did not hold; far above it, one that is wider than necessary.";
const COVERAGE: &str = "Share of the trials whose bound held, with its 95 % confidence interval. The vertical line is the \
                        confidence that was asked for: an interval wholly to its left is a bound that claims too much.";
const GAIN: &str = "Rays of a plain render with the right depth and samples / rays of <code>--error</code>, geometric mean over \
                    the scenes, with the least and the greatest. Right of the line, <code>--error</code> is cheaper.";

impl Calibration {
    /// The page; `command` is the command line that made it.
    ///
    /// # Errors
    /// If a plot cannot be drawn; says why.
    pub fn html(&self, command: &str) -> Result<String, String> {
        let title = "Error bounds by family of scenes";
        let mut text = format!(
            "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" \
             content=\"width=device-width\"><title>{title}</title>\n<style>\n{STYLE}</style></head><body>\n<h1>{title}</h1>\n"
        );
        text += &self.lead();
        text += &self.facts(command);
        let summaries = self.summaries();
        text += "<h2 id=\"error\">True and stated error</h2>\n";
        text += &paragraph(SCATTER);
        text += "<div class=\"plots\">";
        for svg in scatter::plots(self)? {
            text += &format!("<figure>{svg}</figure>\n");
        }
        text += "</div>\n<h2 id=\"coverage\">Coverage</h2>\n";
        text += &paragraph(COVERAGE);
        text += &strips::coverage(&summaries, self.header.trials.confidence);
        text += "<h2 id=\"gain\">Gain of <code>--error</code></h2>\n";
        text += &paragraph(GAIN);
        text += &strips::gain(&summaries);
        text += &self.failure_table();
        text += "</body></html>\n";
        Ok(text)
    }

    fn lead(&self) -> String {
        let failures = self.failures();
        let trials: usize = (self.scenes.iter())
            .map(|s| {
                2 * s.budget.len() + s.time.len() + s.error.iter().map(|e| e.trials.len()).sum::<usize>()
            })
            .sum();
        let part = match self.is_complete() {
            true => "",
            false => {
                "<p class=\"note\"><b>Interrupted:</b> fewer scenes than planned; the same command continues.</p>\n"
            }
        };
        format!(
            "<p class=\"lead\">{} of {trials} bounds did not hold, on {}.</p>\n{part}",
            failures.len(),
            units::plural(self.scenes.len() as u64, "scene")
        )
    }

    fn facts(&self, command: &str) -> String {
        let (d, t) = (&self.header.device, &self.header.trials);
        let program = &self.header.program;
        let list = [
            ("image", format!("{} x {} pixels", t.width, t.height)),
            ("scenes", format!("those of families drawn with seed {}", t.seed)),
            ("seeds", format!("{} per scene and setting", t.seeds)),
            (
                "device",
                format!(
                    "{} ({}), {}, Vulkan {}",
                    escaped(&d.name),
                    escaped(&d.kind),
                    escaped(&d.driver),
                    escaped(&d.api)
                ),
            ),
            (
                "made by",
                format!(
                    "<code>{}</code><br>whitted {} ({})",
                    escaped(command),
                    program.version,
                    escaped(&program.git)
                ),
            ),
        ];
        let items: Vec<String> =
            list.iter().map(|(name, value)| format!("<dt>{name}</dt><dd>{value}</dd>")).collect();
        format!("<dl class=\"facts\">{}</dl>\n", items.join("\n"))
    }

    fn failure_table(&self) -> String {
        let rows: Vec<[String; 5]> = self
            .failures()
            .iter()
            .map(|f| {
                let figure = |x: f64| crate::lab::markdown::number(x);
                [
                    f.scene.clone(),
                    f.options.clone(),
                    f.part.to_owned(),
                    figure(f.bound),
                    figure(f.error.error()),
                ]
            })
            .collect();
        let heads = ["scene", "render", "bound", "stated", "true"];
        html::table("Bounds that did not hold", 3, &heads, &rows)
    }
}

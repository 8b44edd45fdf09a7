//! The page of one render or profile: the picture and its layers, the error, what was asked for and reached, where the
//! time went, device, settings and warnings.

use super::page::bars::{self, Bar};
use super::page::markup::{escaped, facts, section};
use super::page::views::{image, switch};
use super::page::{document, pictures};
use super::plot::{self, Axis, Chart, Legend, Look, Scale, Series};
use super::profile::Spread;
use super::surface_pictures::SurfacePicture;
use crate::accuracy::promise::Layer;
use crate::image::{Metadata, View, heat};
use crate::render::SurfaceLayer;
use crate::report::{ReferencePoint, Report, text};
use crate::stats::Quartiles;
use crate::units::{figure, grouped, number, seconds, short};
use std::io;

/// What the page shows.
pub struct RenderPage<'a> {
    /// The picture.
    pub view: View<'a>,
    /// Share of the work that was done; below 1 if interrupted or short of time.
    pub done: f64,
    /// All figures.
    pub report: &'a Report,
    /// Layers with one number a pixel, rows from the top; NaN if unknown.
    pub layers: &'a [(Layer, Vec<f64>)],
    /// Surface layers, as pictures.
    pub surfaces: &'a [(SurfaceLayer, SurfacePicture)],
    /// Medians and quartiles over several runs, of `profile`.
    pub profile: Option<&'a Spread>,
    /// The command line.
    pub command: String,
}

/// The whole page.
///
/// # Errors
/// If a picture cannot be encoded as PNG.
pub fn page(page: &RenderPage<'_>) -> io::Result<String> {
    let report = page.report;
    let what = if page.profile.is_some() { "Profile" } else { "Render" };
    // A profile has no image file, whose name would come first.
    let summary = text::summary(report);
    let mut body = format!("<p class=\"lead\">{}</p>\n", escaped(summary.trim_start_matches(": ")));
    body += &notes(page);
    body += &looks(page)?;
    body += &error(report);
    body += &convergence(report)?;
    body += &passes(report, page.profile);
    body += &rays(report);
    body += &tests(report);
    body += &about(page);
    Ok(document(&format!("{what} of {}", report.scene.file), &body))
}

/// What a reader must know before anything else.
fn notes(page: &RenderPage<'_>) -> String {
    let mut lines = text::warnings(page.report);
    if page.done < 1.0 {
        lines.insert(0, format!("warning: only {:.1} % of the work was done", 100.0 * page.done));
    }
    lines.iter().map(|line| format!("<p class=\"note\">{}</p>\n", escaped(line))).collect()
}

/// The picture, and its layers behind tabs, each above its legend.
fn looks(page: &RenderPage<'_>) -> io::Result<String> {
    let View { width, height, linear } = page.view;
    let size = [width, height];
    let picture = image(&pictures::picture(linear, size, width.max(1))?, size, "picture");
    if page.layers.is_empty() && page.surfaces.is_empty() {
        return Ok(format!("<h2 id=\"picture\">Picture</h2>\n<div class=\"picture\">{picture}</div>\n"));
    }
    let mut tabs = vec![("picture", picture)];
    for (layer, values) in page.layers {
        let what = format!("{}: {}", layer.name(), layer.unit());
        let painted = heat::paint(values, width, heat::Range::Auto, &what);
        let mut png = Vec::new();
        painted.write(&Metadata::default(), &mut png)?;
        tabs.push((layer.name(), image(&png, painted.size(), &what)));
    }
    for (layer, picture) in page.surfaces {
        let described = image(&picture.png, picture.size, picture.what);
        tabs.push((layer.name(), format!("{described}\n<p>{}</p>", escaped(picture.what))));
    }
    Ok(format!(
        "<h2 id=\"picture\">Picture and layers</h2>\n<p>Click a name, or use the arrow keys. A layer of one number a pixel is in \
         false colours; its legend names quantity, unit and scale.</p>\n{}",
        switch("layers", &tabs)
    ))
}

/// The error's parts, and whether a request was kept. Empty if neither was asked for.
fn error(report: &Report) -> String {
    let asked = &report.asked;
    let lines = text::error(report);
    let Some(e) = &report.error else {
        let why =
            asked.unmet_why.as_deref().map_or(String::new(), |why| format!("not kept: {}", escaped(why)));
        return match asked.error.is_some() || asked.time.is_some() {
            true => format!("<h2 id=\"error\">Error</h2>\n<p>No bound on the error. {why}</p>\n"),
            false => String::new(),
        };
    };
    // After the statement a line per part: its name, then its value and a remark.
    let part = |line: &String| {
        let (name, words) = line.trim().split_once(' ').unwrap_or((line, ""));
        let value = match name {
            "sampling" => e.sampling,
            "truncation" => e.truncation,
            _ => e.rounding.unwrap_or(0.0),
        };
        Bar { name: name.to_owned(), value, range: None, text: words.trim().to_owned() }
    };
    let mut parts: Vec<Bar> = lines.iter().filter(|line| line.starts_with("  ")).map(part).collect();
    parts.push(Bar { name: "total".into(), value: e.total, range: None, text: figure(e.total) });
    if let Some(value) = asked.error {
        parts.push(Bar { name: "asked for".into(), value, range: None, text: figure(value) });
    }
    let words = lines.iter().filter(|line| !line.starts_with("  "));
    let words: String = words.map(|line| format!("<p>{}</p>\n", escaped(line))).collect();
    format!("<h2 id=\"error\">Error</h2>\n{words}{}", bars::svg("parts of the error", &parts))
}

/// Error against the reference picture, over time and over rays; empty without one.
fn convergence(report: &Report) -> io::Result<String> {
    let Some(reference) = report.reference.as_ref().filter(|r| !r.points.is_empty()) else {
        return Ok(String::new());
    };
    let points = &reference.points;
    let chart = |title, label, x: fn(&ReferencePoint) -> f64| Chart {
        title,
        x: Axis::around(label, Scale::Decades, points.iter().map(x)),
        y: Axis::around("RMSE, linear light", Scale::Decades, points.iter().map(|p| p.rmse)),
        series: vec![Series {
            name: "this render".into(),
            color: 0,
            points: points.iter().map(|p| (x(p), p.rmse)).collect(),
            look: Look::Marked,
        }],
        mark: None,
        legend: Legend::LowerLeft,
    };
    let charts = [
        chart("Error against time", "seconds since the first submit", |p| p.seconds),
        chart("Error against rays", "rays of all kinds", |p| p.rays as f64),
    ];
    let svg = plot::svg(&charts, (960, 360)).map_err(io::Error::other)?;
    let rows = points
        .iter()
        .map(|p| [format!("{:.4}", p.seconds), number(p.samples), grouped(p.rays), figure(p.rmse)]);
    let note = format!(
        "Error against {} after each round of samples: RMSE in linear light clamped to [0, 1]. Both axes are logarithmic. \
         A curve that turns level has come down to the picture's own error, or to a bias such as that of the depth.",
        escaped(&reference.file)
    );
    let table = section("Convergence", &note, (0, &["seconds", "samples per pixel", "rays", "RMSE"]), rows);
    Ok(format!("{table}<figure id=\"convergence-plot\">{svg}</figure>\n"))
}

/// Device time per pass and depth: of one run, or the medians of several with their quartiles.
fn passes(report: &Report, profile: Option<&Spread>) -> String {
    let single = |x: f64| Quartiles { lower: x, median: x, upper: x };
    let rows: Vec<(&str, u32, u64, Quartiles)> = match profile {
        Some(spread) => {
            spread.passes.iter().map(|p| (p.name.as_str(), p.depth, p.items, p.seconds)).collect()
        }
        None => {
            report.passes.iter().map(|p| (p.name.as_str(), p.depth, p.items, single(p.seconds))).collect()
        }
    };
    if rows.is_empty() {
        return String::new();
    }
    let total: f64 = rows.iter().map(|r| r.3.median).sum();
    let share = |x: f64| if total > 0.0 { 100.0 * x / total } else { 0.0 };
    // Passes run to the depth that was asked for, even if no ray is left.
    let traced = report.rays.by_depth.len() as u32;
    let (live, empty): (Vec<_>, Vec<_>) = rows.into_iter().partition(|r| r.1 <= traced);
    let mut list: Vec<Bar> = live
        .into_iter()
        .map(|(name, depth, items, time)| Bar {
            name: if depth > 0 { format!("{name}, depth {depth}") } else { name.to_owned() },
            value: time.median,
            range: profile.map(|_| [time.lower, time.upper]),
            text: format!(
                "{}, {:.1} %, {} items",
                seconds(time.median),
                share(time.median),
                short(items as f64)
            ),
        })
        .collect();
    if let Some(last) = empty.iter().map(|r| r.1).max() {
        let value: f64 = empty.iter().map(|r| r.3.median).sum();
        let text = format!("{}, {:.1} %", seconds(value), share(value));
        list.push(Bar { name: format!("no rays, to depth {last}"), value, range: None, text });
    }
    let how = match profile {
        Some(spread) => format!("medians of {} runs; the thin lines are the middle half", spread.repeats),
        None => "one run".into(),
    };
    format!(
        "<h2 id=\"passes\">Passes</h2>\n<p>Device time per pass and depth ({how}). Items are rays, samples or pixels, \
         depending on the pass.</p>\n{}",
        bars::svg("device time of the passes", &list)
    )
}

fn rays(report: &Report) -> String {
    let cells = report.rays.by_depth.iter().map(|d| {
        let kinds = [d.primary, d.reflection, d.refraction, d.shadow];
        let [primary, reflection, refraction, shadow] = kinds.map(grouped);
        [d.depth.to_string(), primary, reflection, refraction, shadow]
    });
    let r = &report.rays;
    let note = format!(
        "Primary {}, reflection {}, refraction {}, shadow {}.",
        grouped(r.primary),
        grouped(r.reflection),
        grouped(r.refraction),
        grouped(r.shadow)
    );
    section("Rays", &note, (0, &["depth", "primary", "reflection", "refraction", "shadow"]), cells)
}

/// Box and primitive tests; empty if they were not counted.
fn tests(report: &Report) -> String {
    let rows = report.tests.iter().flat_map(|tests| &tests.by_kind).map(|k| {
        let numbers = [k.rays, k.boxes, k.primitives].map(grouped);
        let [rays, boxes, primitives] = numbers;
        [k.kind.clone(), k.depth.to_string(), rays, boxes, primitives]
    });
    let note = "A box test is the box of one child of a node for one ray that still looks for a hit; a primitive test is one \
                triangle or sphere for one such ray.";
    section("Tests", note, (1, &["rays", "depth", "count", "box tests", "primitive tests"]), rows)
}

/// Device, scene, settings, plan, times and the program.
fn about(page: &RenderPage<'_>) -> String {
    let report = page.report;
    let lines = text::about(report);
    let mut list: Vec<(&str, String)> = lines
        .lines()
        .filter_map(|l| l.split_once(' '))
        .map(|(name, value)| (name, escaped(value.trim())))
        .collect();
    let t = &report.time;
    let time = format!(
        "{} so far: scene {}, build {}, first dispatch {}, render {}, of which device {}",
        seconds(t.wall),
        seconds(t.scene),
        seconds(t.build),
        seconds(t.first_dispatch),
        seconds(t.render),
        seconds(t.device),
    );
    let program = &report.program;
    list.push(("time", time));
    list.push(("hash", format!("<code>{}</code> (linear SHA-256)", escaped(&report.image.linear_sha256))));
    list.push((
        "made by",
        format!(
            "<code>{}</code><br>{} {} ({})",
            escaped(&page.command),
            escaped(&program.name),
            escaped(&program.version),
            escaped(&program.git)
        ),
    ));
    format!("<h2 id=\"about\">Device and settings</h2>\n{}", facts(&list))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::{DepthInfo, ErrorInfo, PassInfo, ReferenceInfo};

    fn report() -> Report {
        let mut report = Report::default();
        report.scene.file = "<b>&.toml".into();
        report.rays.by_depth = vec![DepthInfo::of(1, [1234, 0, 0, 567])];
        let pass = |depth| PassInfo { name: "shade".into(), depth, launches: 1, seconds: 0.5, items: 9 };
        report.passes = vec![pass(1), pass(2), pass(3)];
        report
    }

    fn text_of(report: &Report, layers: &[(Layer, Vec<f64>)], done: f64) -> String {
        let view = View { width: 2, height: 1, linear: &[[0.5; 3]; 2] };
        page(&RenderPage {
            view,
            done,
            report,
            layers,
            surfaces: &[],
            profile: None,
            command: "whitted <x>".into(),
        })
        .unwrap()
    }

    #[test]
    fn a_plain_render_has_picture_passes_and_settings() {
        let text = text_of(&report(), &[], 1.0);
        assert!(
            text.contains("Render of &lt;b&gt;&amp;.toml") && !text.contains("<b>&") && !text.contains("<x>")
        );
        assert!(
            text.contains("shade, depth 1") && text.contains("no rays, to depth 3") && text.contains("1,234")
        );
        assert_eq!((text.matches("<img ").count(), text.matches("type=\"radio\"").count()), (1, 0));
        assert!(!text.contains("id=\"error\"") && !text.contains("class=\"note\"") && !text.contains("http"));
    }

    #[test]
    fn layers_error_and_warnings_are_shown() {
        let mut report = report();
        report.error = Some(ErrorInfo {
            confidence: 0.95,
            sampling: 0.25,
            truncation: 0.125,
            total: 0.375,
            ..ErrorInfo::default()
        });
        report.asked.error = Some(0.5);
        report.asked.met = Some(true);
        report.warnings.push("a<b".into());
        let layers = [(Layer::Samples, vec![1.0, 2.0]), (Layer::Cost, vec![1.0, f64::NAN])];
        let text = text_of(&report, &layers, 0.5);
        assert_eq!((text.matches("<img ").count(), text.matches("type=\"radio\"").count()), (3, 3));
        for part in [
            "error at most 0.375",
            "asked for an error of 0.5: kept",
            "rays cut at depth",
            "samples per pixel",
        ] {
            assert!(text.contains(part), "{part}");
        }
        // To scale: half of what was asked for, and a quarter.
        assert!(text.contains("width=\"200.0\"") && text.contains("width=\"100.0\""));
        assert!(text.contains("warning: a&lt;b") && text.contains("only 50.0 %"));
    }

    #[test]
    fn a_reference_gives_two_curves_and_a_table() {
        let mut report = report();
        let point =
            |n: f64| ReferencePoint { seconds: 0.1 * n, samples: n, rays: 1000 * n as u64, rmse: 0.1 / n };
        let points = [1.0, 2.0, 4.0].map(point).to_vec();
        report.reference = Some(ReferenceInfo { file: "t<.exr".into(), points });
        let text = text_of(&report, &[], 1.0);
        assert!(text.contains("Error against time") && text.contains("Error against rays"));
        assert!(text.contains("t&lt;.exr") && text.contains("<td>4,000</td>"), "{text}");
        let circles = text.matches("<circle ").count();
        assert_eq!(circles, 2 * 3, "{circles}");
    }

    #[test]
    fn a_request_without_a_bound_says_so() {
        let mut report = report();
        report.asked.time = Some(1.0);
        report.asked.unmet_why = Some("too short".into());
        assert!(text_of(&report, &[], 1.0).contains("No bound on the error. not kept: too short"));
    }
}

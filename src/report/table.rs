//! Text for people: aligned columns, and the story of a render on one screen.

use crate::report::{PassInfo, Report};
use crate::units::{bytes, grouped, number, plural, seconds, short};
use std::fmt::{self, Write};

/// Side on which a column is flush.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Align {
    /// Words.
    Left,
    /// Numbers.
    Right,
}

/// Rows of text cells under a heading, printed as wide as needed.
#[derive(Debug)]
pub struct Table<const N: usize> {
    align: [Align; N],
    rows: Vec<[String; N]>,
}

impl<const N: usize> Table<N> {
    /// An empty table of these columns.
    pub fn new(columns: &[(&str, Align); N]) -> Table<N> {
        Table { align: columns.map(|(_, align)| align), rows: vec![columns.map(|(name, _)| name.to_owned())] }
    }

    /// Adds a row.
    pub fn row(&mut self, cells: [String; N]) {
        self.rows.push(cells);
    }
}

impl<const N: usize> fmt::Display for Table<N> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let widths: [usize; N] = std::array::from_fn(|column| {
            self.rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0)
        });
        for row in &self.rows {
            let mut line = String::new();
            for ((cell, width), align) in row.iter().zip(widths).zip(self.align) {
                match align {
                    Align::Left => write!(line, "{cell:<width$}  ")?,
                    Align::Right => write!(line, "{cell:>width$}  ")?,
                }
            }
            writeln!(out, "{}", line.trim_end())?;
        }
        Ok(())
    }
}

/// One line: file, size, samples, depth, rays and seconds.
pub fn summary(report: &Report) -> String {
    let settings = &report.settings;
    let [x0, y0, x1, y1] = settings.region();
    let rays = report.rays.total();
    format!(
        "{}: {}x{} pixels, {}, depth {}, {} rays in {}",
        report.image.file,
        x1 - x0,
        y1 - y0,
        plural(settings.samples.into(), "sample"),
        settings.depth,
        short(rays as f64),
        seconds(report.time.render),
    )
}

/// The error budget, and whether what was asked for was reached.
pub fn error(report: &Report) -> Vec<String> {
    let Some(e) = &report.error else { return Vec::new() };
    let figure = |x: f64| format!("{x:.2e}");
    let mut lines = vec![format!(
        "error at most {} (RMSE in linear light from 0 to 1, {} % confidence)",
        figure(e.total),
        number(100.0 * e.confidence)
    )];
    lines.push(format!("  sampling   {}  (expected {})", figure(e.sampling), figure(e.sampling_estimate)));
    lines.push(match &e.truncation_unbounded_why {
        None => format!("  truncation {}  (depth {})", figure(e.truncation), report.settings.depth),
        Some(why) => format!("  truncation {} as shown; unbounded beyond white: {why}", figure(e.truncation)),
    });
    lines.push(match (e.rounding, e.rounding_pixels) {
        (Some(part), Some(pixels)) => {
            let pixels = plural(pixels, "pixel");
            format!("  rounding   {}  ({pixels} with other paths in f64)", figure(part))
        }
        _ => "  rounding   not compared with f64".into(),
    });
    let asked = &report.asked;
    let what = match (asked.error, asked.time) {
        (Some(error), _) => format!("an error of {}", number(error)),
        (_, Some(time)) => seconds(time),
        _ => return lines,
    };
    lines.push(match (asked.met, &asked.unmet_why) {
        (Some(true), _) => format!("asked for {what}: kept"),
        (_, why) => format!("asked for {what}: not kept, {}", why.as_deref().unwrap_or("as it ended early")),
    });
    lines
}

/// What ought not to have happened, one line each.
pub fn warnings(report: &Report) -> Vec<String> {
    let counters = &report.counters;
    [
        (counters.degenerate_triangles, "triangle", "without area dropped"),
        (counters.nan_rays, "ray", "with a NaN or infinity"),
        (counters.clamped_lights, "light", "nearer to a surface than its spawn offset"),
        (counters.stack_overflow, "ray", "that overflowed the traversal stack"),
        (counters.loop_cap, "ray", "ended by the traversal's loop cap"),
        (counters.media_overflow, "ray", "inside more solids than can be tracked"),
    ]
    .into_iter()
    .filter(|&(count, ..)| count > 0)
    .map(|(count, noun, what)| format!("{} {what}", plural(count, noun)))
    .chain(report.warnings.iter().cloned())
    .map(|warning| format!("warning: {warning}"))
    .collect()
}

/// Device, scene and plan; time per pass and depth; rays per depth; totals.
pub fn report(report: &Report) -> String {
    [about(report), passes(report), rays(report), totals(report)].join("\n")
}

/// Device, scene, settings and plan.
pub fn about(report: &Report) -> String {
    let Report { device, scene, settings, plan, .. } = report;
    let [x, y, z] = scene.local_frame.center.map(number);
    let crop = settings.crop.map_or(String::new(), |[x0, y0, x1, y1]| format!(", crop {x0},{y0},{x1},{y1}"));
    let lines = [
        ("device", format!("{} ({}), {}, Vulkan {}", device.name, device.kind, device.driver, device.api)),
        (
            "scene",
            format!(
                "{}: {}, {}, {}; local = (world - ({x}, {y}, {z})) * 2^{}",
                scene.file,
                plural(scene.triangles, "triangle"),
                plural(scene.spheres, "sphere"),
                plural(scene.lights, "light"),
                scene.local_frame.scale_log2,
            ),
        ),
        (
            "image",
            format!(
                "{}x{} pixels{crop}, {}, depth {}; sampler {}, seed {}, precision {}, origin {}",
                settings.width,
                settings.height,
                plural(settings.samples.into(), "sample"),
                settings.depth,
                settings.sampler,
                settings.seed,
                settings.precision,
                settings.origin,
            ),
        ),
        (
            "plan",
            format!(
                "{}; {}, {}, {}",
                plan.features.join(", "),
                bytes(plan.bytes),
                plural(plan.tiles, "tile"),
                if plan.batches == 1 { "1 batch".into() } else { format!("{} batches", plan.batches) },
            ),
        ),
    ];
    lines.iter().fold(String::new(), |text, (name, line)| text + &format!("{name:<7} {line}\n"))
}

fn passes(report: &Report) -> String {
    use Align::{Left, Right};
    let total: f64 = report.passes.iter().map(|p| p.seconds).sum();
    // One column of seconds, in which a thousandth of the whole is still a number.
    let decimals = (3.0 - total.max(1e-9).log10().floor()).clamp(0.0, 9.0) as usize;
    let cells = |name: &str, depth: String, rows: &[PassInfo]| {
        let launches = rows.iter().map(|p| p.launches).sum();
        let seconds: f64 = rows.iter().map(|p| p.seconds).sum();
        let share = if total > 0.0 { 100.0 * seconds / total } else { 0.0 };
        let time = format!("{seconds:.decimals$}");
        [
            name.to_owned(),
            depth,
            grouped(launches),
            time,
            format!("{share:.1} %"),
            String::new(),
            String::new(),
        ]
    };
    let mut table = Table::new(&[
        ("pass", Left),
        ("depth", Right),
        ("launches", Right),
        ("seconds", Right),
        ("share", Right),
        ("items", Right),
        ("items/s", Right),
    ]);
    // Passes are launched to the depth that was asked for, rays or no rays.
    let traced = report.rays.by_depth.len() as u32;
    let empty: Vec<PassInfo> = report.passes.iter().filter(|p| p.depth > traced).cloned().collect();
    let last = empty.iter().map(|p| p.depth).max();
    for pass in report.passes.iter().filter(|p| p.depth <= traced) {
        let depth = if pass.depth == 0 { "-".into() } else { pass.depth.to_string() };
        let mut row = cells(&pass.name, depth, std::slice::from_ref(pass));
        row[5] = grouped(pass.items);
        // A pass of one item a launch has no throughput to speak of.
        let rate = pass.items as f64 / pass.seconds;
        row[6] = if pass.items > pass.launches && rate.is_finite() { short(rate) } else { "-".into() };
        table.row(row);
    }
    if let Some(last) = last {
        let first = traced + 1;
        let depths = if first == last { first.to_string() } else { format!("{first}-{last}") };
        table.row(cells("no rays", depths, &empty));
    }
    // Items of different passes are different things; their sum would mean nothing.
    table.row(cells("all", String::new(), &report.passes));
    table.to_string()
}

fn rays(report: &Report) -> String {
    use Align::Right;
    let rays = &report.rays;
    let mut table = Table::new(&[("depth", Right), ("rays traced", Right), ("shadow rays", Right)]);
    for row in &rays.by_depth {
        table.row([row.depth.to_string(), grouped(row.traced), grouped(row.shadow)]);
    }
    let traced = rays.primary + rays.reflection + rays.refraction;
    table.row(["all".into(), grouped(traced), grouped(rays.shadow)]);
    format!(
        "{table}primary {}, reflection {}, refraction {}, shadow {}\n",
        grouped(rays.primary),
        grouped(rays.reflection),
        grouped(rays.refraction),
        grouped(rays.shadow),
    )
}

fn totals(report: &Report) -> String {
    let time = &report.time;
    let total = report.rays.total() as f64;
    let mut text = format!(
        "wall {} = scene {} + build {} + first dispatch {} + render {} + rest\n",
        seconds(time.wall),
        seconds(time.scene),
        seconds(time.build),
        seconds(time.first_dispatch),
        seconds(time.render),
    );
    text += &format!("device {} of the render", seconds(time.device));
    for (seconds, clock) in [(time.render, "render"), (time.device, "device")] {
        if seconds > 0.0 {
            text += &format!("; {} rays/s of {clock} time", short(total / seconds));
        }
    }
    text + "\n"
}

#[cfg(test)]
mod tests;

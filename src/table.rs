//! Text for people: aligned columns, and the story of a render on one screen.

use crate::report::{PassInfo, Report};
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
    let (width, height) = size(report);
    let rays = report.rays.total();
    format!(
        "{}: {width}x{height} pixels, {}, depth {}, {} rays in {}",
        report.image.file,
        plural(settings.samples.into(), "sample"),
        settings.depth,
        short(rays as f64),
        seconds(report.time.render),
    )
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
    .map(|(count, noun, what)| format!("warning: {} {what}", plural(count, noun)))
    .chain(report.warnings.iter().map(|w| format!("warning: {w}")))
    .collect()
}

/// Device, scene and plan; time per pass and depth; rays per depth; totals.
pub fn report(report: &Report) -> String {
    [about(report), passes(report), rays(report), totals(report)].join("\n")
}

fn about(report: &Report) -> String {
    let Report { device, scene, settings, plan, .. } = report;
    let [x, y, z] = scene.local_frame.center;
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
                mebibytes(plan.bytes),
                plural(plan.tiles, "tile"),
                if plan.batches == 1 { "1 batch".into() } else { format!("{} batches", plan.batches) },
            ),
        ),
    ];
    lines.iter().fold(String::new(), |text, (name, line)| text + &format!("{name:<7} {line}\n"))
}

fn passes(report: &Report) -> String {
    use Align::{Left, Right};
    let sum = PassInfo {
        name: "all".into(),
        launches: report.passes.iter().map(|p| p.launches).sum(),
        seconds: report.passes.iter().map(|p| p.seconds).sum(),
        ..PassInfo::default()
    };
    let mut table = Table::new(&[
        ("pass", Left),
        ("depth", Right),
        ("launches", Right),
        ("seconds", Right),
        ("share", Right),
        ("items", Right),
        ("M items/s", Right),
    ]);
    for pass in report.passes.iter().chain([&sum]) {
        let total = std::ptr::eq(pass, &sum);
        // Items of different passes are different things; their sum would mean nothing.
        let (items, rate) = if total {
            (String::new(), String::new())
        } else {
            let rate = pass.items as f64 / pass.seconds / 1e6;
            (grouped(pass.items), if rate.is_finite() { format!("{rate:.2}") } else { "-".into() })
        };
        let share = if sum.seconds > 0.0 { 100.0 * pass.seconds / sum.seconds } else { 0.0 };
        table.row([
            pass.name.clone(),
            if total {
                String::new()
            } else if pass.depth == 0 {
                "-".into()
            } else {
                pass.depth.to_string()
            },
            grouped(pass.launches),
            format!("{:.6}", pass.seconds),
            format!("{share:.1} %"),
            items,
            rate,
        ]);
    }
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

/// Size of the image written.
fn size(report: &Report) -> (u32, u32) {
    let settings = &report.settings;
    settings.crop.map_or((settings.width, settings.height), |[x0, y0, x1, y1]| (x1 - x0, y1 - y0))
}

/// `1 sample`, `20 samples`.
pub fn plural(count: u64, noun: &str) -> String {
    format!("{} {noun}{}", grouped(count), if count == 1 { "" } else { "s" })
}

/// `61.5 MiB`.
pub fn mebibytes(bytes: u64) -> String {
    format!("{:.1} MiB", bytes as f64 / f64::from(1 << 20))
}

/// `12,345,678`.
pub fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// Three digits and a factor: `12.3 M`; no factor below 1000.
pub fn short(count: f64) -> String {
    let (value, factor) = match count {
        c if c >= 1e9 => (c / 1e9, " G"),
        c if c >= 1e6 => (c / 1e6, " M"),
        c if c >= 1e3 => (c / 1e3, " k"),
        c => return format!("{c:.0}"),
    };
    format!("{}{factor}", three_digits(value))
}

/// Three digits and a unit: `1.23 s`, `45.6 ms`, `7.00 us`.
pub fn seconds(time: f64) -> String {
    let (value, unit) = match time {
        t if t >= 1.0 || t == 0.0 => (t, "s"),
        t if t >= 1e-3 => (t * 1e3, "ms"),
        t => (t * 1e6, "us"),
    };
    format!("{} {unit}", three_digits(value))
}

fn three_digits(value: f64) -> String {
    let decimals = if value >= 100.0 {
        0
    } else if value >= 10.0 {
        1
    } else {
        2
    };
    format!("{value:.decimals$}")
}

#[cfg(test)]
#[path = "table_tests.rs"]
mod tests;

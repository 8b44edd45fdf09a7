//! The report of a render as text for people.

use super::table::{Align, Table};
use super::{PassInfo, ReferenceInfo, Report};
use crate::units::{bytes, figure, grouped, number, plural, seconds, short};

/// One line: file, size, samples, depth, rays and seconds.
pub fn summary(report: &Report) -> String {
    let settings = &report.settings;
    let [x0, y0, x1, y1] = settings.region();
    let rays = report.rays.total();
    format!(
        "{}: {}x{} pixels, {} per pixel, depth {}, {} rays in {}",
        report.image.file,
        x1 - x0,
        y1 - y0,
        plural(settings.samples.into(), "sample"),
        settings.depth,
        short(rays as f64),
        seconds(report.time.render),
    )
}

/// The error budget, and whether the error or time that was asked for was kept; empty without either.
pub fn error(report: &Report) -> Vec<String> {
    let Some(e) = &report.error else { return without_error(report) };
    let mut lines = vec![format!(
        "error at most {} (RMSE in linear light from 0 to 1; {} % confidence)",
        figure(e.total),
        number(100.0 * e.confidence)
    )];
    let unseen = match e.unseen > 0.5 * e.sampling {
        true => format!("; parts of pixels that no sample met: up to {}", figure(e.unseen)),
        false => String::new(),
    };
    lines.push(format!(
        "  sampling   {} (best estimate {}{unseen})",
        figure(e.sampling),
        figure(e.sampling_estimate)
    ));
    let measured = match (e.truncation_certain, e.truncation_pixels) {
        (Some(certain), Some(pixels)) => {
            format!("; from longer paths of {}, certain {}", plural(pixels, "pixel"), figure(certain))
        }
        _ => String::new(),
    };
    let depth = report.settings.depth;
    lines.push(match &e.truncation_unbounded_why {
        None if e.truncation == 0.0 => "  truncation 0 (no ray was cut)".into(),
        None => format!("  truncation {} (rays cut at depth {depth}{measured})", figure(e.truncation)),
        Some(why) => format!(
            "  truncation {} with values above 1 clamped{measured}; no bound without clamping: {why}",
            figure(e.truncation)
        ),
    });
    lines.push(match (e.rounding, e.rounding_pixels) {
        (Some(part), Some(pixels)) => {
            let others = match e.rounding_values {
                Some(values) if pixels > 0 => format!(", {} in the others", figure(values)),
                _ => String::new(),
            };
            let pixels = plural(pixels, "pixel");
            format!("  rounding   {} ({pixels} with different paths in f64{others})", figure(part))
        }
        _ => "  rounding   not measured (not compared with f64)".into(),
    });
    if let Some(part) = e.encoding {
        lines.push(format!("  encoding   {} (steps of the file's codes)", figure(part)));
    }
    if let Some(part) = e.not_excluded {
        lines.push(format!(
            "  not excluded: {} if the scene's brightest light shows in parts of pixels between the samples",
            figure(part)
        ));
    }
    if let Some(why) = &e.void {
        lines = vec![format!("no error bound: {why}")];
    }
    let asked = &report.asked;
    let what = match (asked.error, asked.time) {
        (Some(error), _) => format!("an error of {}", number(error)),
        (_, Some(time)) => seconds(time),
        _ => return lines,
    };
    lines.push(match (asked.met, &asked.unmet_why) {
        (Some(true), _) => format!("asked for {what}: kept"),
        (_, why) => format!("asked for {what}: not kept, {}", why.as_deref().unwrap_or("it was interrupted")),
    });
    lines
}

/// Of a render for a time that left none to learn the error.
fn without_error(report: &Report) -> Vec<String> {
    match (report.asked.time, report.asked.met) {
        (Some(time), Some(true)) => vec![
            "error unknown: there was no time to learn it".to_owned(),
            format!("asked for {}: kept", seconds(time)),
        ],
        _ => Vec::new(),
    }
}

/// Numerical faults and other warnings, one line each.
pub fn warnings(report: &Report) -> Vec<String> {
    let counters = &report.counters;
    [
        (counters.degenerate_triangles, "triangle", "without area ignored"),
        (counters.nan_rays, "ray", "with a NaN or infinity"),
        (counters.clamped_lights, "light", "closer to a surface than the ray offset there"),
        (counters.stack_overflow, "ray", "that overflowed the traversal stack"),
        (counters.loop_cap, "ray", "stopped at the limit on traversal steps"),
        (counters.media_overflow, "ray", "inside more nested solids than are tracked"),
    ]
    .into_iter()
    .filter(|&(count, ..)| count > 0)
    .map(|(count, noun, what)| format!("{} {what}", plural(count, noun)))
    .chain(report.warnings.iter().cloned())
    .map(|warning| format!("warning: {warning}"))
    .collect()
}

/// Device, scene and plan; time per pass and depth; rays per depth and kind; totals.
pub fn report(report: &Report) -> String {
    let passes = passes(report) + "items: rays, samples or pixels, depending on the pass\n";
    let mut parts = vec![about(report), passes, rays(report)];
    parts.extend(report.reference.as_ref().map(convergence));
    parts.push(totals(report));
    parts.join("\n")
}

/// Error against the reference picture after each round of samples.
fn convergence(reference: &ReferenceInfo) -> String {
    use Align::Right;
    let mut table = Table::new(&[("seconds", Right), ("samples", Right), ("rays", Right), ("RMSE", Right)]);
    for p in &reference.points {
        table.row([format!("{:.4}", p.seconds), number(p.samples), grouped(p.rays), figure(p.rmse)]);
    }
    format!("error against {}\n{table}", reference.file)
}

/// One line: the error of the whole image against the reference picture; none without one.
pub fn reference(report: &Report) -> Option<String> {
    let reference = report.reference.as_ref()?;
    let last = reference.points.last()?;
    let error = figure(last.rmse);
    Some(format!("difference from {}: {error} (RMSE in linear light from 0 to 1)", reference.file))
}

/// Device, scene, local frame, settings and plan, one line each.
pub fn about(report: &Report) -> String {
    let Report { device, scene, settings, plan, .. } = report;
    let [x, y, z] = scene.local_frame.center.map(number);
    let crop = settings.crop.map_or(String::new(), |[x0, y0, x1, y1]| format!(", crop {x0},{y0},{x1},{y1}"));
    let lines = [
        ("device", format!("{} ({}), {}, Vulkan {}", device.name, device.kind, device.driver, device.api)),
        (
            "scene",
            format!(
                "{}: {}, {}, {}",
                scene.file,
                plural(scene.triangles, "triangle"),
                plural(scene.spheres, "sphere"),
                plural(scene.lights, "light"),
            ),
        ),
        ("frame", format!("local = (world - ({x}, {y}, {z})) * 2^{}", scene.local_frame.scale_log2)),
        (
            "image",
            format!(
                "{}x{} pixels{crop}, {} per pixel, depth {}; sampler {}, seed {}, precision {}, origin {}",
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
                "kernels for {}; {} of device memory, {}, {}",
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
    // Enough decimals to show a thousandth of the total.
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
        ("dispatches", Right),
        ("seconds", Right),
        ("share", Right),
        ("items", Right),
        ("items/s", Right),
    ]);
    // Passes run to the depth that was asked for, even if no ray is left.
    let traced = report.rays.by_depth.len() as u32;
    let empty: Vec<PassInfo> = report.passes.iter().filter(|p| p.depth > traced).cloned().collect();
    let last = empty.iter().map(|p| p.depth).max();
    for pass in report.passes.iter().filter(|p| p.depth <= traced) {
        let depth = if pass.depth == 0 { "-".into() } else { pass.depth.to_string() };
        let mut row = cells(&pass.name, depth, std::slice::from_ref(pass));
        row[5] = grouped(pass.items);
        // One item per dispatch: a throughput would mean nothing.
        let rate = pass.items as f64 / pass.seconds;
        row[6] = if pass.items > pass.launches && rate.is_finite() { short(rate) } else { "-".into() };
        table.row(row);
    }
    if let Some(last) = last {
        let first = traced + 1;
        let depths = if first == last { first.to_string() } else { format!("{first}-{last}") };
        table.row(cells("no rays", depths, &empty));
    }
    // Items of different passes (rays, samples, pixels) do not add up.
    table.row(cells("all", String::new(), &report.passes));
    table.to_string()
}

fn rays(report: &Report) -> String {
    use Align::Right;
    let rays = &report.rays;
    let mut table = Table::new(&[
        ("depth", Right),
        ("primary rays", Right),
        ("reflection", Right),
        ("refraction", Right),
        ("shadow", Right),
        ("all", Right),
    ]);
    let mut row = |name: String, kinds: [u64; 4]| {
        let [primary, reflection, refraction, shadow] = kinds.map(grouped);
        table.row([name, primary, reflection, refraction, shadow, grouped(kinds.iter().sum())]);
    };
    for d in &rays.by_depth {
        row(d.depth.to_string(), [d.primary, d.reflection, d.refraction, d.shadow]);
    }
    row("all".into(), [rays.primary, rays.reflection, rays.refraction, rays.shadow]);
    table.to_string()
}

fn totals(report: &Report) -> String {
    let time = &report.time;
    let total = report.rays.total() as f64;
    let mut text = format!(
        "total  {}: scene {}, build {}, first dispatch {}, render {}, other {}\n",
        seconds(time.wall),
        seconds(time.scene),
        seconds(time.build),
        seconds(time.first_dispatch),
        seconds(time.render),
        seconds((time.wall - time.scene - time.build - time.first_dispatch - time.render).max(0.0)),
    );
    for (clock, time) in [("render", time.render), ("device", time.device)] {
        text += &format!("{clock} {}", seconds(time));
        if time > 0.0 {
            text += &format!(", {} rays/s", short(total / time));
        }
        text += "\n";
    }
    text
}

#[cfg(test)]
mod tests;

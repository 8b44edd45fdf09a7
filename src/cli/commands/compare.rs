//! `whitted compare`.

use crate::atomic_file;
use crate::cli::args::{CompareArgs, Metric};
use crate::cli::console::{self, Console};
use crate::cli::delivery::write_json;
use crate::cli::failure::Failure;
use crate::compare::flip;
use crate::compare::metrics::{self, Metrics, pixel_error};
use crate::image::heat::{self, Range};
use crate::image::{Metadata, Picture};
use crate::report::ProgramInfo;
use crate::report::table::{Align, Table};
use crate::units::{grouped, number};
use anyhow::{Context, anyhow};
use serde::Serialize;
use std::path::Path;

/// What `--json` writes.
#[derive(Debug, Serialize)]
struct Comparison {
    program: ProgramInfo,
    a: PictureInfo,
    b: PictureInfo,
    metrics: Figures,
    judged: Judged,
    #[serde(skip_serializing_if = "Option::is_none")]
    diff: Option<Diff>,
}

#[derive(Debug, Serialize)]
struct PictureInfo {
    file: String,
    width: u32,
    height: u32,
    encoding: &'static str,
}

#[derive(Debug, Serialize)]
struct Figures {
    #[serde(flatten)]
    plain: Metrics,
    /// Mean of the FLIP map.
    flip: f64,
    /// Of all pixels.
    differing_share: f64,
    /// Of all pixels, in 8-bit codes.
    code_differing_share: f64,
}

#[derive(Debug, Serialize)]
struct Judged {
    metric: String,
    /// None: psnr of equal pictures, which is infinite.
    value: Option<f64>,
    threshold: Option<f64>,
    /// On the wrong side of the threshold; None without one.
    above: Option<bool>,
}

/// The false-colour picture.
#[derive(Debug, Serialize)]
struct Diff {
    file: String,
    shows: &'static str,
    /// Numbers that the ends of the colours stand for.
    scale: [f64; 2],
}

/// Compares two pictures.
pub fn run(args: &CompareArgs, console: &mut Console) -> Result<(), Failure> {
    check(args)?;
    let (a, b) = (load(&args.a)?, load(&args.b)?);
    if (a.width, a.height) != (b.width, b.height) {
        return Err(Failure::Other(anyhow!(
            "{} has {}x{} pixels and {} has {}x{}: pictures must have the same size",
            args.a.display(),
            a.width,
            a.height,
            args.b.display(),
            b.width,
            b.height,
        )));
    }
    let map = flip::flip(&a.linear, &b.linear, a.width as usize, flip::PIXELS_PER_DEGREE)
        .context("cannot compare the pictures")?;
    let plain = metrics::compare(&a.linear, &b.linear).context("cannot compare the pictures")?;
    let pixels = a.linear.len().max(1) as f64;
    let figures = Figures {
        plain,
        flip: flip::mean(&map),
        differing_share: plain.differing_pixels as f64 / pixels,
        code_differing_share: plain.code_differing_pixels as f64 / pixels,
    };
    let judged = judge(&figures, args.metric, args.threshold);
    let diff = match &args.diff {
        Some(path) => Some(draw(path, args, [&a, &b], map)?),
        None => None,
    };
    let about = |path: &Path, picture: &Picture| PictureInfo {
        file: path.display().to_string(),
        width: picture.width,
        height: picture.height,
        encoding: picture.encoding,
    };
    let (a, b) = (about(&args.a, &a), about(&args.b, &b));
    let comparison = Comparison { program: ProgramInfo::default(), a, b, metrics: figures, judged, diff };
    tell(args, &comparison, console)?;
    match comparison.judged {
        Judged { above: Some(true), value, threshold, metric } => Err(Failure::AboveThreshold(format!(
            "{metric} {} is {} the threshold {}",
            value.map_or("infinite".into(), number),
            if args.metric == Metric::Psnr { "below" } else { "above" },
            threshold.map_or(String::new(), number),
        ))),
        _ => Ok(()),
    }
}

/// What can be known before the pictures are read.
fn check(args: &CompareArgs) -> Result<(), Failure> {
    let files = [&args.diff, &args.json];
    for path in files.into_iter().flatten().filter(|p| p.as_os_str() != "-") {
        if [&args.a, &args.b].contains(&path) {
            return Err(Failure::Usage(format!("{} would overwrite a picture to compare", path.display())));
        }
        atomic_file::check(path).with_context(|| format!("cannot write {}", path.display()))?;
    }
    if args.diff.is_some() && args.diff == args.json {
        return Err(Failure::Usage("--diff and --json name the same file".into()));
    }
    Ok(())
}

/// Reads a picture that has a number in every channel.
fn load(path: &Path) -> Result<Picture, Failure> {
    let picture = Picture::read(path).map_err(anyhow::Error::from)?;
    let is_bad = |p: &[f32; 3]| p.iter().any(|c| c.is_nan());
    if let Some(first) = picture.linear.iter().position(is_bad) {
        let count = picture.linear.iter().filter(|p| is_bad(p)).count();
        let width = picture.width as usize;
        return Err(Failure::Other(anyhow!(
            "{} has {count} pixels that are not numbers (NaN), the first at ({}, {}): the errors would be meaningless; \
             render the picture again or crop them away",
            path.display(),
            first % width,
            first / width,
        )));
    }
    Ok(picture)
}

fn judge(figures: &Figures, metric: Metric, threshold: Option<f64>) -> Judged {
    let plain = &figures.plain;
    let (name, value) = match metric {
        Metric::Rmse => ("rmse", Some(plain.rmse)),
        Metric::Mean => ("mean", Some(plain.mean_abs)),
        Metric::Max => ("max", Some(plain.max_abs)),
        Metric::P999 => ("p999", Some(plain.p999)),
        Metric::Psnr => ("psnr", plain.psnr),
        Metric::Flip => ("flip", Some(figures.flip)),
        Metric::Pixels => ("pixels", Some(figures.differing_share)),
        Metric::Codes => ("codes", Some(f64::from(plain.code_max))),
    };
    let beyond =
        |limit: f64| value.is_some_and(|v| if metric == Metric::Psnr { v < limit } else { v > limit });
    Judged { metric: name.into(), value, threshold, above: threshold.map(beyond) }
}

/// Writes the difference in false colours.
fn draw(path: &Path, args: &CompareArgs, [a, b]: [&Picture; 2], flip: Vec<f64>) -> Result<Diff, Failure> {
    let errors = a.linear.iter().zip(&b.linear).map(|(a, b)| pixel_error(a, b));
    let (shows, values): (_, Vec<f64>) = match args.metric {
        Metric::Flip => ("LDR-FLIP", flip),
        Metric::Codes => ("8-bit codes, worst channel", errors.map(|(_, code)| code.into()).collect()),
        _ => ("linear error, worst channel", errors.map(|(error, _)| error).collect()),
    };
    let range = args.full_scale.map_or(Range::Auto, |top| Range::Given(0.0, top));
    let (low, high) = range.ends(&values);
    let painted = heat::paint(&values, a.width, range, shows);
    let scale = format!("{shows}, from {} (black) to {} (pale yellow)", number(low), number(high));
    let metadata = Metadata::new([
        ("Software", concat!(env!("CARGO_PKG_NAME"), " ", env!("CARGO_PKG_VERSION"))),
        ("Description", &format!("{} less {}", args.a.display(), args.b.display())),
        ("Scale", &scale),
    ]);
    atomic_file::write(path, |out| painted.write(&metadata, out))
        .with_context(|| format!("cannot write {}", path.display()))?;
    Ok(Diff { file: path.display().to_string(), shows, scale: [low, high] })
}

fn tell(args: &CompareArgs, comparison: &Comparison, console: &mut Console) -> Result<(), Failure> {
    let text = table(comparison);
    match &args.json {
        Some(path) if path.as_os_str() == "-" => {
            let json =
                serde_json::to_string_pretty(comparison).context("cannot express the figures as JSON")?;
            console.say(&text);
            console::print(&(json + "\n"))
        }
        other => {
            if let Some(path) = other {
                write_json(path, comparison)?;
            }
            if console.is_quiet() { Ok(()) } else { console::print(&text) }
        }
    }
}

fn table(comparison: &Comparison) -> String {
    use Align::{Left, Right};
    let Comparison { a, b, metrics, judged, diff, .. } = comparison;
    let plain = &metrics.plain;
    let mut table = Table::new(&[("error", Left), ("value", Right), ("", Left)]);
    let mut row = |name: &str, value: String, note: &str| {
        let mark = if name == judged.metric {
            match (judged.threshold, judged.above) {
                (Some(limit), Some(true)) => format!("; exceeds the threshold {}", number(limit)),
                (Some(limit), _) => format!("; within the threshold {}", number(limit)),
                _ => String::new(),
            }
        } else {
            String::new()
        };
        table.row([name.into(), value, format!("{note}{mark}")]);
    };
    let share = |count: u64, share: f64| format!("{} pixels, {}", grouped(count), percent(share));
    row("rmse", number(plain.rmse), "root mean square over all channels");
    row("mean", number(plain.mean_abs), "mean absolute over all channels");
    row("max", number(plain.max_abs), "largest channel");
    row("p999", number(plain.p999), "99.9th percentile of the pixels' worst channels");
    row("psnr", plain.psnr.map_or("infinite".into(), |db| format!("{db:.2}")), "decibels");
    row("flip", number(metrics.flip), "mean LDR-FLIP, 67 pixels per degree");
    row(
        "pixels",
        number(metrics.differing_share),
        &format!("differ; {}", share(plain.differing_pixels, metrics.differing_share)),
    );
    row("codes", plain.code_max.to_string(), "largest difference in 8-bit sRGB codes");
    row("", number(plain.code_mean), "mean difference in 8-bit sRGB codes");
    row(
        "",
        number(metrics.code_differing_share),
        &format!(
            "differ in 8-bit sRGB codes; {}",
            share(plain.code_differing_pixels, metrics.code_differing_share)
        ),
    );
    let mut text = format!(
        "a  {} ({})\nb  {} ({})\n{}x{} pixels, in linear light clamped to [0, 1]\n\n{table}",
        a.file, a.encoding, b.file, b.encoding, a.width, a.height
    );
    if let Some(Diff { file, shows, scale: [low, high] }) = diff {
        text +=
            &format!("\n{file}: {shows}, from {} (black) to {} (pale yellow)\n", number(*low), number(*high));
    }
    text
}

fn percent(share: f64) -> String {
    format!("{} %", number(format!("{:.2e}", 100.0 * share).parse().unwrap_or(share)))
}

#[cfg(test)]
mod tests;

//! The small tables: Pareto front, fastest setting per error, convergence, cost of samples,
//! precisions.

use crate::lab::page::markup::{error, section};
use crate::lab::sweep::record::Record;
use crate::lab::sweep::row::Row;
use crate::stats::{median, quartiles};
use crate::units::{figure, seconds};

/// Rows of the Pareto front, fastest first.
pub(super) fn front_rows(record: &Record) -> Vec<&Row> {
    let mut rows: Vec<&Row> = record.rows.iter().filter(|r| r.on_front).collect();
    rows.sort_by(|a, b| a.seconds().total_cmp(&b.seconds()));
    rows
}

pub(super) fn front(record: &Record) -> String {
    let cells = front_rows(record).into_iter().map(|r| {
        let flip = r.error.as_ref().map(|e| e.flip);
        [r.name.clone(), seconds(r.seconds()), error(r.rmse()), error(flip)]
    });
    section(
        "Pareto front",
        "The settings worth choosing: each has the lowest error for its time. Every other setting is both slower \
         and worse than one of these, or better by less than 1 %.",
        (1, &["setting", "time", "RMSE", "FLIP"]),
        cells,
    )
}

pub(super) fn cheapest(record: &Record) -> String {
    let cells = record.cheapest.iter().map(|c| {
        [
            format!("at most {}", figure(c.error)),
            c.name.clone().unwrap_or("no setting of this sweep".into()),
            c.seconds.map_or("-".into(), seconds),
            error(c.rmse),
        ]
    });
    section(
        "Fastest setting for an error",
        "For each error asked for, the fastest setting that keeps it.",
        (2, &["RMSE asked for", "setting", "time", "RMSE reached"]),
        cells,
    )
}

pub(super) fn slopes(record: &Record) -> String {
    let cells = record.slopes.iter().map(|s| {
        let sure = s.uncertainty.map_or(String::new(), |u| format!(" \u{b1} {u:.2}"));
        [s.line.clone(), format!("{:.2}{sure}", s.fitted), s.points.to_string(), s.theory.clone()]
    });
    section(
        "Convergence",
        "How fast the sampling error falls: the exponent <i>s</i> in error &prop; samples<sup><i>s</i></sup>, \
         fitted by least squares in log-log coordinates, &plusmn; its standard error. A more negative exponent \
         gains more from each added sample.",
        (1, &["settings", "fitted exponent", "points fitted", "theory"]),
        cells,
    )
}

pub(super) fn doublings(record: &Record) -> String {
    let mut counts: Vec<u32> = record.doublings.iter().map(|d| d.samples).collect();
    counts.sort_unstable();
    counts.dedup();
    let cells = counts.iter().map(|n| {
        let of: Vec<_> = record.doublings.iter().filter(|d| d.samples == *n).collect();
        let hold = of.iter().filter(|d| d.holds()).count();
        let q = quartiles(&of.iter().map(|d| d.ratio).collect::<Vec<_>>());
        [
            format!("{n} to {}", 2 * n),
            q.map_or("-".into(), |q| format!("{:.2}", q.median)),
            q.map_or("-".into(), |q| format!("{:.2} to {:.2}", q.lower, q.upper)),
            format!("{hold} of {}", of.len()),
        ]
    });
    section(
        "Cost of twice the samples",
        "Device time with twice the samples divided by that before, over all settings that differ in nothing \
         else. 2 is expected; less means that part of the time does not depend on samples.",
        (1, &["samples per pixel", "ratio, median", "interquartile range", "settings within 20 % of 2"]),
        cells,
    )
}

pub(super) fn precisions(record: &Record) -> String {
    let mut names: Vec<&str> = record.rows.iter().map(|r| r.point.precision.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    if names.len() < 2 {
        return String::new();
    }
    let base = if names.contains(&"robust") { "robust" } else { names[0] };
    let cells = names.iter().map(|name| {
        let of = record.rows.iter().filter(|r| r.point.precision == *name);
        let (mut times, mut errors, mut rounding) = (vec![], vec![], vec![]);
        for row in of {
            let mut other = row.point.clone();
            other.precision = base.into();
            let Some(other) = record.rows.iter().find(|r| r.point == other) else { continue };
            times.push(row.measured.device.median / other.measured.device.median);
            errors.extend(row.rmse().zip(other.rmse()).map(|(a, b)| a / b));
            rounding.extend(row.error.as_ref().and_then(|e| e.rounding));
        }
        let factor = |list: &[f64]| median(list).map_or("-".into(), |m| format!("{m:.3}"));
        let most = rounding.iter().copied().reduce(f64::max);
        [(*name).to_owned(), factor(&times), factor(&errors), error(median(&rounding)), error(most)]
    });
    let (time, rmse) = (format!("device time / {base}"), format!("RMSE / {base}"));
    section(
        "Precisions",
        "Each precision against the others at otherwise equal settings: ratios are medians over all settings. \
         Rounding error is the RMSE from the picture of the same setting in f64.",
        (1, &["precision", &time, &rmse, "rounding error, median", "rounding error, largest"]),
        cells,
    )
}

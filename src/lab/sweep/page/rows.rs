//! The table of all settings: the columns most people want, and the rest behind a toggle.

use crate::lab::page::markup::{error, escaped};
use crate::lab::sweep::record::Record;
use crate::lab::sweep::row::Row;
use crate::units::{seconds, short};
use std::fmt::Write;

/// A column after those of the axes.
struct Column {
    head: &'static str,
    /// Explains the heading, as a tooltip.
    what: &'static str,
    /// Shown before the toggle is used.
    main: bool,
    /// Sort value and text; `None` if unknown.
    cell: fn(&Row) -> Option<(f64, String)>,
}

fn time(x: f64) -> Option<(f64, String)> {
    Some((x, seconds(x)))
}

fn count(x: u64) -> Option<(f64, String)> {
    Some((x as f64, short(x as f64)))
}

fn figure(x: Option<f64>) -> Option<(f64, String)> {
    x.map(|x| (x, error(Some(x))))
}

macro_rules! columns {
    ($($main:literal $head:literal $what:literal $cell:expr;)*) => {
        &[$(Column { head: $head, what: $what, main: $main, cell: $cell },)*]
    };
}

/// In the order shown.
const COLUMNS: &[Column] = columns! {
    true "time" "render time: from the first submit to the last pixel, median" |r| time(r.measured.render.median);
    true "IQR" "interquartile range of the render time" |r| time(r.measured.render.iqr);
    false "device time" "time of the GPU passes, median" |r| time(r.measured.device.median);
    false "device IQR" "interquartile range of the device time" |r| time(r.measured.device.iqr);
    false "renders" "timed renders behind the medians" |r| count(r.measured.repeats.into());
    true "rays" "rays of all kinds" |r| count(r.rays.total());
    false "primary" "camera rays" |r| count(r.rays.primary);
    false "reflection" "reflected rays" |r| count(r.rays.reflection);
    false "refraction" "refracted rays" |r| count(r.rays.refraction);
    false "shadow" "shadow rays" |r| count(r.rays.shadow);
    true "RMSE" "root mean square error against the truth" |r| figure(r.rmse());
    true "sampling" "part of the RMSE that more samples would remove" |r| figure(r.error.as_ref()?.sampling);
    true "bias" "part of the RMSE that infinitely many samples would leave" |r| figure(r.error.as_ref()?.limit);
    false "rounding" "RMSE from the picture of the same setting in f64" |r| figure(r.error.as_ref()?.rounding);
    false "truth error" "standard error of the truth" |r| figure(Some(r.error.as_ref()?.truth));
    false "mean abs" "mean absolute error over all channels" |r| figure(Some(r.error.as_ref()?.metrics.mean_abs));
    false "max" "largest error of any channel" |r| figure(Some(r.error.as_ref()?.metrics.max_abs));
    false "p99.9" "99.9th percentile of the pixels' worst channels" |r| figure(Some(r.error.as_ref()?.metrics.p999));
    false "PSNR" "peak signal-to-noise ratio, decibels" |r| {
        r.error.as_ref()?.metrics.psnr.map(|db| (db, format!("{db:.1} dB")))
    };
    true "FLIP" "mean FLIP error, 0 to 1, models what an observer notices" |r| figure(Some(r.error.as_ref()?.flip));
    false "8-bit mean" "mean difference in 8-bit sRGB codes" |r| {
        r.error.as_ref().map(|e| (e.metrics.code_mean, format!("{:.3}", e.metrics.code_mean)))
    };
    false "8-bit max" "largest difference in 8-bit sRGB codes" |r| count(r.error.as_ref()?.metrics.code_max.into());
    true "efficiency" "1 / (MSE x time), as a share of the best setting" |r| figure(r.efficiency);
};

/// The section; columns of the axes come first.
pub(super) fn section(record: &Record) -> String {
    let more = COLUMNS.iter().filter(|c| !c.main).count();
    let axes: String =
        record.axes.iter().map(|a| format!("<th class=\"l\" scope=\"col\">{}</th>", escaped(a))).collect();
    let heads: String = COLUMNS
        .iter()
        .map(|c| format!("<th scope=\"col\"{} title=\"{}\">{}</th>", class(c), escaped(c.what), c.head))
        .collect();
    let mut text = format!(
        "<h2 id=\"settings\">All settings</h2>\n<p>Click a heading to sort by it, hover over it for its meaning. Settings \
         on the Pareto front are tinted.</p>\n<input type=\"checkbox\" id=\"all-columns\"> \
         <label class=\"toggle\" for=\"all-columns\">show {more} more columns</label>\n\
         <div class=\"scroll tall\"><table class=\"sortable\"><thead><tr>{axes}{heads}</tr></thead><tbody>\n"
    );
    let best = record.rows.iter().filter_map(|r| r.efficiency).fold(0.0, f64::max);
    for row in &record.rows {
        text += if row.on_front { "<tr class=\"front\">" } else { "<tr>" };
        for axis in &record.axes {
            let _ = write!(text, "<td class=\"l\">{}</td>", escaped(&row.point.value(axis)));
        }
        for column in COLUMNS {
            let class = class(column);
            let _ = match (column.cell)(row) {
                None => write!(text, "<td{class}>-</td>"),
                Some((value, _)) if column.head == "efficiency" => {
                    write!(text, "<td{class} data-v=\"{value:e}\">{:.0} %</td>", 100.0 * value / best)
                }
                Some((value, shown)) => write!(text, "<td{class} data-v=\"{value:e}\">{shown}</td>"),
            };
        }
        text += "</tr>\n";
    }
    text + "</tbody></table></div>\n"
}

fn class(column: &Column) -> &'static str {
    if column.main { "" } else { " class=\"more\"" }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_has_a_cell_for_every_heading() {
        let judged = Row { error: Some(Default::default()), efficiency: Some(2.0), ..Row::default() };
        let record =
            Record { axes: vec!["depth".into()], rows: vec![Row::default(), judged], ..Record::default() };
        let text = section(&record);
        let (cells, heads) = (text.matches("<td").count(), text.matches("<th ").count());
        assert_eq!((cells, heads), (2 * heads, 1 + COLUMNS.len()));
        assert!(text.contains(">100 %<"), "the only efficiency is the best");
    }
}

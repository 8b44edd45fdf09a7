//! The plots of a sweep, each with a caption that says what to read off it.

use crate::lab::plot::{Axis, Chart, Legend, Look, Scale, Series};
use crate::lab::sweep::analysis::{Line, fit, lines, theory};
use crate::lab::sweep::record::Record;
use crate::lab::sweep::row::Row;

/// Axes by which points may be coloured, in order of preference.
const COLORED: [&str; 6] = ["sampler", "precision", "fresnel", "spheres", "depth", "origin"];
/// More colours are hard to distinguish.
const MOST_COLORS: usize = 6;

/// A plot of the page.
pub(super) struct Plot {
    /// Of its files, without the extension.
    pub name: &'static str,
    pub chart: Chart,
    /// Shown below it.
    pub caption: &'static str,
}

const TIME: &str = "Each dot is one setting: its render time (median) and its error. Lower left is better. The line is \
                    the Pareto front: the lowest error for the time. A dot far from the line takes longer, or errs more, \
                    than it need.";
const SAMPLES: &str = "Sampling error, without bias, one line per sampler. Lower is better; a steeper line gains more \
                       from each added sample. Both axes are logarithmic, so a straight line is a power law and its \
                       slope the exponent. The thin lines have the slope that theory predicts at edges.";
const DEPTH: &str = "Error at the most samples per pixel of this sweep. Where a curve is flat, more depth does not help: \
                     the rest is sampling error. The thin line is the bias, the error that infinitely many samples \
                     would leave; its fall shows how much light longer paths carry.";
const EPSILON: &str = "Error when secondary rays start at a fixed distance (epsilon) from the surface. Too small, and \
                       rays hit the surface they leave; too large, and they skip what is near. The level lines are \
                       origin=bound, which derives the distance from the rounding error and needs no epsilon: it should \
                       be as low as the lowest point of the curve.";

/// The plots; those of axes that were not swept are left out.
pub(super) fn plots(record: &Record) -> Vec<Plot> {
    let all = [
        ("error_time", TIME, time(record)),
        ("error_samples", SAMPLES, samples(record)),
        ("error_depth", DEPTH, depth(record)),
        ("error_epsilon", EPSILON, epsilon(record)),
    ];
    all.into_iter().filter_map(|(name, caption, chart)| Some(Plot { name, chart: chart?, caption })).collect()
}

fn judged(record: &Record) -> impl Iterator<Item = (&Row, f64)> {
    record.rows.iter().filter_map(|r| Some((r, r.rmse()?)))
}

/// The values of an axis in the order of the rows.
fn values(record: &Record, axis: &str) -> Vec<String> {
    let mut list = Vec::new();
    for value in record.rows.iter().map(|r| r.point.value(axis)) {
        if !list.contains(&value) {
            list.push(value);
        }
    }
    list
}

fn xs(series: &[Series]) -> Vec<f64> {
    series.iter().flat_map(|s| s.points.iter().map(|p| p.0)).collect()
}

fn ys(series: &[Series]) -> Vec<f64> {
    series.iter().flat_map(|s| s.points.iter().map(|p| p.1)).collect()
}

fn chart(
    title: &'static str,
    x: (&'static str, Scale),
    series: Vec<Series>,
    legend: Legend,
) -> Option<Chart> {
    if series.iter().all(|s| s.points.is_empty()) {
        return None;
    }
    Some(Chart {
        title,
        x: Axis::around(x.0, x.1, xs(&series)),
        y: Axis::around("RMSE, linear light", Scale::Decades, ys(&series)),
        series,
        mark: None,
        legend,
    })
}

fn time(record: &Record) -> Option<Chart> {
    let colored = COLORED.iter().find(|axis| (2..=MOST_COLORS).contains(&values(record, axis).len()));
    let groups = colored.map_or(vec![String::new()], |axis| values(record, axis));
    let of_group = |group: &String| {
        let in_group = |r: &Row| colored.is_none_or(|axis| r.point.value(axis) == *group);
        judged(record).filter(|(r, _)| in_group(r)).map(|(r, e)| (r.seconds(), e)).collect::<Vec<_>>()
    };
    let name = |group: &String| match colored {
        Some(axis) if ["sampler", "precision"].contains(axis) => group.clone(),
        Some(axis) => format!("{axis} {group}"),
        None => "settings".into(),
    };
    // The front is drawn first, under the points.
    let front = record.front.iter().filter_map(|n| record.rows.iter().find(|r| r.name == *n));
    let mut series = vec![Series {
        name: "Pareto front".into(),
        color: 6,
        points: front.filter_map(|r| Some((r.seconds(), r.rmse()?))).collect(),
        look: Look::Thick,
    }];
    series.extend(groups.iter().enumerate().map(|(color, group)| Series {
        name: name(group),
        color,
        points: of_group(group),
        look: Look::Dots,
    }));
    chart("Error against time", ("render time, seconds", Scale::Decades), series, Legend::UpperRight)
}

/// For each sampler the line with the lowest bias: there the sampling error can be seen the
/// furthest.
fn samples(record: &Record) -> Option<Chart> {
    let limit = |row: &Row| row.error.as_ref().and_then(|e| e.limit).unwrap_or(f64::INFINITY);
    let all = lines(&record.rows);
    let best = |sampler: &str| {
        let of = all.iter().filter(|l| l.row.point.sampler == sampler && l.points.len() > 1);
        of.min_by(|a, b| limit(&a.row).total_cmp(&limit(&b.row)))
    };
    let mut series = Vec::new();
    for (color, sampler) in values(record, "sampler").into_iter().enumerate() {
        let Some(Line { points, .. }) = best(&sampler).cloned() else { continue };
        let logs: Vec<(f64, f64)> = points.iter().map(|(n, e)| (n.ln(), e.ln())).collect();
        let slope = fit(&logs).map_or(String::new(), |(s, _)| format!(", slope {s:.2}"));
        let (n0, e0) = points[0];
        let exponent = theory(&sampler).1;
        let guide = points.iter().map(|(n, _)| (*n, e0 * (n / n0).powf(exponent))).collect();
        series.push(Series { name: format!("{sampler}{slope}"), color, points, look: Look::Marked });
        let name = format!("theory: slope {exponent}");
        series.push(Series { name, color, points: guide, look: Look::Plain });
    }
    let x = ("samples per pixel", Scale::Octaves);
    chart("Sampling error against samples", x, series, Legend::LowerLeft)
}

/// Rows that differ in `axis` (and `open`, unless empty) only: at the most samples per pixel, with
/// every other axis at its preferred value, or its last if that was not swept.
fn along<'a>(record: &'a Record, axis: &str, open: &str) -> Vec<(&'a Row, f64)> {
    let most = record.rows.iter().map(|r| r.point.samples).max();
    let wanted = |name: &str, preferred: &str| {
        let list = values(record, name);
        let found = list.iter().find(|v| *v == preferred).or(list.last());
        found.cloned().unwrap_or_default()
    };
    let deepest = record.rows.iter().map(|r| r.point.depth).max().unwrap_or(0).to_string();
    let fixed: Vec<(&str, String)> = [
        ("sampler", "owen"),
        ("depth", deepest.as_str()),
        ("cutoff", "0"),
        ("precision", "robust"),
        ("origin", "bound"),
        ("seed", "0"),
        ("fresnel", "scene"),
        ("spheres", "analytic"),
    ]
    .into_iter()
    .filter(|(name, _)| *name != axis && *name != open)
    .map(|(name, preferred)| (name, wanted(name, preferred)))
    .collect();
    judged(record)
        .filter(|(r, _)| Some(r.point.samples) == most)
        .filter(|(r, _)| fixed.iter().all(|(name, value)| r.point.value(name) == *value))
        .collect()
}

fn depth(record: &Record) -> Option<Chart> {
    if values(record, "depth").len() < 2 {
        return None;
    }
    let rows = along(record, "depth", "sampler");
    let mut series: Vec<Series> = values(record, "sampler")
        .into_iter()
        .take(MOST_COLORS)
        .enumerate()
        .map(|(color, sampler)| Series {
            points: points(&rows, |r, e| {
                (r.point.sampler == sampler).then_some((f64::from(r.point.depth), e))
            }),
            name: sampler,
            color,
            look: Look::Marked,
        })
        .collect();
    let limit = points(&along(record, "depth", ""), |r, _| {
        Some((f64::from(r.point.depth), r.error.as_ref()?.limit?))
    });
    let name = "bias".into();
    series.push(Series { name, color: 3, points: limit, look: Look::Plain });
    let mut chart = chart(
        "Error against depth",
        ("depth: rays in the longest path", Scale::Linear),
        series,
        Legend::UpperRight,
    )?;
    // Five decades below the largest error, all is rounding.
    chart.y.range[0] = chart.y.range[0].max(chart.y.range[1] * 1e-5);
    clip(&mut chart);
    Some(chart)
}

fn epsilon(record: &Record) -> Option<Chart> {
    let fixed = |row: &Row| row.point.origin.strip_prefix("fixed:").and_then(|x| x.parse::<f64>().ok());
    let rows = along(record, "origin", "");
    let curve = |value: &dyn Fn(&Row, f64) -> Option<f64>| {
        let mut list = points(&rows, |r, e| Some((fixed(r)?, value(r, e)?)));
        list.sort_by(|a, b| a.0.total_cmp(&b.0));
        list
    };
    let total = curve(&|_, e| Some(e));
    let (first, last) = (total.first()?.0, total.last()?.0);
    if total.len() < 2 {
        return None;
    }
    let limit = |r: &Row| r.error.as_ref().and_then(|e| e.limit);
    let level = |value: Option<f64>| value.map_or(Vec::new(), |y| vec![(first, y), (last, y)]);
    let bound = rows.iter().find(|(r, _)| r.point.origin == "bound");
    let series = vec![
        Series { name: "fixed epsilon".into(), color: 0, points: total, look: Look::Marked },
        Series {
            name: "fixed epsilon, bias only".into(),
            color: 1,
            points: curve(&|r, _| limit(r)),
            look: Look::Marked,
        },
        Series {
            name: "error bound".into(),
            color: 0,
            points: level(bound.map(|(_, e)| *e)),
            look: Look::Plain,
        },
        Series {
            name: "error bound, bias only".into(),
            color: 1,
            points: level(bound.and_then(|(r, _)| limit(r))),
            look: Look::Plain,
        },
    ];
    let x = ("epsilon, metres along the ray", Scale::Decades);
    chart("Error against a fixed epsilon", x, series, Legend::UpperRight)
}

fn points(rows: &[(&Row, f64)], point: impl Fn(&Row, f64) -> Option<(f64, f64)>) -> Vec<(f64, f64)> {
    rows.iter().filter_map(|(r, e)| point(r, *e)).collect()
}

/// Removes points below the chart.
fn clip(chart: &mut Chart) {
    let least = chart.y.range[0];
    chart.series.iter_mut().for_each(|s| s.points.retain(|p| p.1 >= least));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::sweep::point::Words;
    use crate::lab::sweep::row::{ErrorInfo, Measured, Spread};

    fn record() -> Record {
        let mut record = Record { axes: vec!["samples".into(), "sampler".into()], ..Record::default() };
        for sampler in ["random", "owen"] {
            for k in 0..5u32 {
                let error = 0.1 * 2f64.powf(theory(sampler).1 * f64::from(k));
                let spread = Spread { median: 0.01 * 2f64.powi(k as i32), iqr: 0.0 };
                record.rows.push(Row {
                    name: format!("{sampler} {k}"),
                    point: Words { samples: 1 << k, sampler: sampler.into(), depth: 4, ..Words::default() },
                    measured: Measured { repeats: 5, device: spread, render: spread },
                    error: Some(ErrorInfo {
                        total: error,
                        sampling: Some(error),
                        limit: Some(0.0),
                        ..ErrorInfo::default()
                    }),
                    ..Row::default()
                });
            }
        }
        record.conclude(&[0.1]);
        record
    }

    #[test]
    fn what_was_not_swept_has_no_plot() {
        let names: Vec<_> = plots(&record()).into_iter().map(|p| p.name).collect();
        assert_eq!(names, ["error_time", "error_samples"]);
        assert!(plots(&Record::default()).is_empty());
    }

    #[test]
    fn the_slope_stands_beside_theorys() {
        let chart = samples(&record()).unwrap();
        assert_eq!(chart.series.len(), 4);
        for (series, slope) in chart.series.iter().zip(["-0.5", "-0.5", "-0.75", "-0.75"]) {
            assert!(series.name.contains(slope), "{}", series.name);
        }
        assert_eq!(chart.series[0].points.len(), 4, "without the one sample at the centre");
    }

    #[test]
    fn the_front_is_drawn_as_found() {
        let record = record();
        let chart = time(&record).unwrap();
        assert_eq!(chart.series[0].points.len(), record.front.len());
        assert_eq!(chart.series.len(), 3);
    }
}

//! Statistics over the rows: the Pareto front of time and error, the fastest point for an error,
//! the slope of error against samples, and the cost of twice the samples.

use super::row::{ErrorInfo, Row};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The fastest point with at most a given error.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Cheapest {
    /// Greatest RMSE allowed.
    pub error: f64,
    /// Name of the row; `None` if no row has so small an error.
    pub name: Option<String>,
    /// Its render seconds.
    pub seconds: Option<f64>,
    /// Its RMSE.
    pub rmse: Option<f64>,
}

/// A power law fitted to the sampling error against samples.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Slope {
    /// The settings that its points share, in words.
    pub line: String,
    /// `random`, `stratified` or `owen`.
    pub sampler: String,
    /// Number of points fitted.
    pub points: usize,
    /// Exponent of the sampling error, bias subtracted.
    pub fitted: f64,
    /// Standard error of `fitted`, from the residuals; `None` with two points.
    pub uncertainty: Option<f64>,
    /// Exponent in theory, in words.
    pub theory: String,
}

/// Device times of the same settings with n and 2n samples.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Doubling {
    /// The row with n samples.
    pub name: String,
    /// n.
    pub samples: u32,
    /// Device seconds of n.
    pub seconds: f64,
    /// Device seconds of 2n.
    pub seconds_twice: f64,
    /// `seconds_twice` / `seconds`; 2 is expected.
    pub ratio: f64,
}

impl Doubling {
    /// True if the ratio is within 20 % of 2.
    pub fn holds(&self) -> bool {
        (self.ratio / 2.0 - 1.0).abs() <= 0.2
    }
}

/// Relative improvement below which an error does not count as lower.
const SAME: f64 = 0.01;

/// Indices of the Pareto front of (time, error) pairs, by time. Of equal pairs the first counts; a
/// slower pair has to be better by more than `SAME`.
pub fn front(points: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> =
        (0..points.len()).filter(|i| points[*i].0.is_finite() && points[*i].1.is_finite()).collect();
    order.sort_by(|a, b| {
        let ((ta, ea), (tb, eb)) = (points[*a], points[*b]);
        ta.total_cmp(&tb).then(ea.total_cmp(&eb))
    });
    let mut best = f64::INFINITY;
    order.retain(|i| {
        let better = points[*i].1 < best * (1.0 - SAME) || (best > 0.0 && points[*i].1 == 0.0);
        if better {
            best = points[*i].1;
        }
        better
    });
    order
}

/// The fastest row with at most each error.
pub fn cheapest(rows: &[Row], errors: &[f64]) -> Vec<Cheapest> {
    let one = |error: &f64| {
        let keeps = rows.iter().filter(|r| r.rmse().is_some_and(|e| e <= *error));
        let row = keeps.min_by(|a, b| a.seconds().total_cmp(&b.seconds()));
        Cheapest {
            error: *error,
            name: row.map(|r| r.name.clone()),
            seconds: row.map(Row::seconds),
            rmse: row.and_then(Row::rmse),
        }
    };
    errors.iter().map(one).collect()
}

/// Slope of the least-squares line, and its standard error from three points on.
pub fn fit(points: &[(f64, f64)]) -> Option<(f64, Option<f64>)> {
    let n = points.len() as f64;
    let mean = |f: fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / n;
    let (mx, my) = (mean(|p| p.0), mean(|p| p.1));
    let sxx: f64 = points.iter().map(|p| (p.0 - mx).powi(2)).sum();
    if points.len() < 2 || sxx <= 0.0 {
        return None;
    }
    let slope = points.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum::<f64>() / sxx;
    let rest: f64 = points.iter().map(|p| (p.1 - my - slope * (p.0 - mx)).powi(2)).sum();
    Some((slope, (points.len() > 2).then(|| (rest / (n - 2.0) / sxx).sqrt())))
}

/// Exponent of a sampler's RMSE against samples in theory, in words and at edges (Owen, "Monte
/// Carlo Theory, Methods and Examples", chapters 10 and 17; on edges Mitchell, "Consequences of
/// Stratified Sampling in Graphics", 1996).
pub fn theory(sampler: &str) -> (&'static str, f64) {
    match sampler {
        "random" => ("-1/2", -0.5),
        "stratified" => ("-3/4 on edges, -1 where smooth", -0.75),
        _ => ("-3/4 on edges, -1.4 where smooth", -0.75),
    }
}

/// Rows that differ in samples and seed only.
#[derive(Debug, Clone)]
pub struct Line {
    /// One of them.
    pub row: Row,
    /// (samples, sampling error), by samples; root mean square over seeds.
    pub points: Vec<(f64, f64)>,
}

/// All lines, without one-sample rows, whose sample lies at the pixel's centre, and without errors
/// smaller than the truth's own standard error.
pub fn lines(rows: &[Row]) -> Vec<Line> {
    let mut groups: BTreeMap<String, Vec<(&Row, f64)>> = BTreeMap::new();
    for row in rows.iter().filter(|r| r.point.samples > 1) {
        let above_noise = |e: &ErrorInfo| e.sampling.filter(|s| *s > e.truth);
        if let Some(sampling) = row.error.as_ref().and_then(above_noise) {
            let key = serde_json::to_string(&row.point.line()).unwrap_or_default();
            groups.entry(key).or_default().push((row, sampling));
        }
    }
    let line = |group: Vec<(&Row, f64)>| {
        let mut squares: BTreeMap<u32, Vec<f64>> = BTreeMap::new();
        for (row, sampling) in &group {
            squares.entry(row.point.samples).or_default().push(sampling * sampling);
        }
        let root = |list: &[f64]| (list.iter().sum::<f64>() / list.len() as f64).sqrt();
        let points = squares.iter().map(|(n, list)| (f64::from(*n), root(list))).collect();
        group.first().map(|(row, _)| Line { row: (*row).clone(), points })
    };
    groups.into_values().filter_map(line).collect()
}

/// The slope of every line of two points or more.
pub fn slopes(rows: &[Row], describe: &dyn Fn(&Row) -> String) -> Vec<Slope> {
    let of = |Line { row, points }: Line| {
        let logs: Vec<(f64, f64)> = points.iter().map(|(n, e)| (n.ln(), e.ln())).collect();
        let (fitted, uncertainty) = fit(&logs)?;
        Some(Slope {
            line: describe(&row),
            sampler: row.point.sampler.clone(),
            points: points.len(),
            fitted,
            uncertainty,
            theory: theory(&row.point.sampler).0.into(),
        })
    };
    lines(rows).into_iter().filter_map(of).collect()
}

/// Every pair of rows that differ only in n against 2n samples.
pub fn doublings(rows: &[Row]) -> Vec<Doubling> {
    let key = |row: &Row| serde_json::to_string(&row.point).unwrap_or_default();
    let by_key: BTreeMap<String, &Row> = rows.iter().map(|r| (key(r), r)).collect();
    rows.iter()
        .filter_map(|row| {
            let mut twice = row.clone();
            twice.point.samples *= 2;
            let twice = by_key.get(&key(&twice))?;
            let (seconds, seconds_twice) = (row.measured.device.median, twice.measured.device.median);
            (seconds > 0.0).then(|| Doubling {
                name: row.name.clone(),
                samples: row.point.samples,
                seconds,
                seconds_twice,
                ratio: seconds_twice / seconds,
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::point::Words;
    use super::super::row::{Measured, Spread};
    use super::*;

    fn row(samples: u32, seconds: f64, rmse: f64) -> Row {
        let spread = Spread { median: seconds, iqr: 0.0 };
        Row {
            name: format!("samples={samples}"),
            point: Words { samples, sampler: "owen".into(), ..Words::default() },
            measured: Measured { repeats: 5, device: spread, render: spread },
            error: Some(ErrorInfo { total: rmse, sampling: Some(rmse), ..ErrorInfo::default() }),
            ..Row::default()
        }
    }

    #[test]
    fn the_front_is_what_nothing_beats() {
        let points = [(1.0, 5.0), (2.0, 3.0), (2.0, 4.0), (3.0, 3.0), (4.0, 1.0), (0.5, f64::NAN)];
        assert_eq!(front(&points), [0, 1, 4]);
        assert_eq!(front(&[]), [0; 0]);
        // Slower for next to nothing is not on it; little by little is.
        assert_eq!(front(&[(1.0, 1.0), (2.0, 0.995), (3.0, 0.985)]), [0, 2]);
        // A point that is better and faster than all clears the rest away.
        assert_eq!(front(&[(1.0, 5.0), (2.0, 3.0), (0.1, 0.1)]), [2]);
    }

    #[test]
    fn the_slope_of_a_power_law_is_its_exponent() {
        for slope in [-0.5, -0.75, -1.4] {
            let rows: Vec<Row> =
                (0..9).map(|k| row(1 << k, 1.0, 0.3 * 2f64.powf(slope * f64::from(k)))).collect();
            let found = slopes(&rows, &|_| "all".into());
            assert_eq!((found.len(), found[0].points), (1, 8), "one sample is no random sample");
            assert!((found[0].fitted - slope).abs() < 1e-12 && found[0].uncertainty.unwrap() < 1e-12);
        }
        assert_eq!(fit(&[(1.0, 1.0)]), None);
        assert_eq!(fit(&[(1.0, 1.0), (1.0, 2.0)]), None);
    }

    #[test]
    fn a_floor_left_in_the_error_would_bend_the_line_and_is_taken_off() {
        let error = |k: i32, floor: f64| {
            let total = (0.3f64 * 2f64.powf(-0.75 * f64::from(k))).hypot(floor);
            (total, (total * total - floor * floor).sqrt())
        };
        let rows: Vec<Row> = (1..9)
            .map(|k| {
                let (total, sampling) = error(k, 0.02);
                let mut row = row(1 << k, 1.0, total);
                row.error.as_mut().unwrap().sampling = Some(sampling);
                row
            })
            .collect();
        assert!((slopes(&rows, &|_| String::new())[0].fitted + 0.75).abs() < 1e-9);
        let bent: Vec<Row> = (1..9).map(|k| row(1 << k, 1.0, error(k, 0.02).0)).collect();
        assert!(slopes(&bent, &|_| String::new())[0].fitted > -0.65);
    }

    #[test]
    fn seeds_are_averaged_as_squares() {
        let mut rows = vec![row(2, 1.0, 0.3), row(2, 1.0, 0.4), row(4, 1.0, 0.1)];
        rows[1].point.seed = 1;
        let line = lines(&rows).remove(0).points;
        assert!((line[0].1 - 0.125f64.sqrt()).abs() < 1e-15 && line.len() == 2);
    }

    #[test]
    fn what_the_truth_drowns_is_no_slope() {
        let mut rows = vec![row(2, 1.0, 0.1), row(4, 1.0, 0.05), row(8, 1.0, 0.04)];
        rows[2].error.as_mut().unwrap().truth = 0.05;
        assert_eq!(slopes(&rows, &|_| String::new())[0].points, 2);
    }

    #[test]
    fn the_cheapest_is_the_fastest_that_is_good_enough() {
        let rows = [row(1, 1.0, 0.1), row(2, 2.0, 0.05), row(4, 3.0, 0.01)];
        let found = cheapest(&rows, &[0.5, 0.05, 0.001]);
        let names: Vec<_> = found.iter().map(|c| c.name.as_deref()).collect();
        assert_eq!(names, [Some("samples=1"), Some("samples=2"), None]);
    }

    #[test]
    fn doublings_are_held_to_a_fifth() {
        let rows = [row(1, 1.0, 0.1), row(2, 2.3, 0.1), row(4, 6.0, 0.1), row(16, 9.0, 0.1)];
        let found = doublings(&rows);
        assert_eq!(found.iter().map(|d| (d.samples, d.holds())).collect::<Vec<_>>(), [(1, true), (2, false)]);
    }
}

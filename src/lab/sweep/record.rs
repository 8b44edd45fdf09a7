//! The record of a sweep, as written to `sweep.json` and `sweep.csv`.

use super::analysis::{Cheapest, Doubling, Slope, cheapest, doublings, front, slopes};
use super::row::Row;
use super::truth::TruthInfo;
use crate::report::{DeviceInfo, ProgramInfo};
use serde::{Deserialize, Serialize};
use std::fmt::Write;

/// All results of a sweep.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Record {
    /// Version of the program.
    pub program: ProgramInfo,
    /// Device that rendered the points.
    pub device: DeviceInfo,
    /// The command line.
    pub command: String,
    /// Path of the scene file.
    pub scene: String,
    /// SHA-256 of the scene's content.
    pub scene_sha256: String,
    /// Width of every picture, pixels.
    pub width: u32,
    /// Height of every picture, pixels.
    pub height: u32,
    /// Names of the axes, in the order given.
    pub axes: Vec<String>,
    /// Number of points of the grid; `rows` has fewer after an interruption.
    pub points: usize,
    /// The truth; missing until it is rendered.
    pub truth: Option<TruthInfo>,
    /// One per point.
    pub rows: Vec<Row>,
    /// Names of the rows on the Pareto front of time and error, by time.
    pub front: Vec<String>,
    /// The fastest row for each given error.
    pub cheapest: Vec<Cheapest>,
    /// Power laws of error against samples.
    pub slopes: Vec<Slope>,
    /// Times of n and 2n samples.
    pub doublings: Vec<Doubling>,
    /// Bias (RMSE), by the settings that determine it.
    pub limits: std::collections::BTreeMap<String, f64>,
}

impl Record {
    /// Computes everything that follows from the rows.
    pub fn conclude(&mut self, errors: &[f64]) {
        let pairs: Vec<(f64, f64)> =
            self.rows.iter().map(|r| (r.seconds(), r.rmse().unwrap_or(f64::NAN))).collect();
        let best = front(&pairs);
        for (i, row) in self.rows.iter_mut().enumerate() {
            row.on_front = best.contains(&i);
            let work = row.error.as_ref().map(|e| e.total * e.total * row.measured.render.median);
            row.efficiency = work.filter(|w| *w > 0.0).map(|w| 1.0 / w);
        }
        self.front = best.iter().map(|i| self.rows[*i].name.clone()).collect();
        self.cheapest = cheapest(&self.rows, errors);
        self.slopes = slopes(&self.rows, &|row| self.line(row));
        self.doublings = doublings(&self.rows);
    }

    /// The swept values of a row, except samples and seed.
    pub fn line(&self, row: &Row) -> String {
        let words = self.axes.iter().filter(|a| !["samples", "seed"].contains(&a.as_str()));
        let text: Vec<String> = words.map(|a| format!("{a} {}", row.point.value(a))).collect();
        if text.is_empty() { "the scene's settings".into() } else { text.join(", ") }
    }

    /// One line per row; columns are named as in `sweep.json`.
    pub fn csv(&self) -> String {
        let mut text = String::from(
            "name,samples,sampler,depth,cutoff,precision,origin,seed,fresnel,spheres,width,height,repeats,\
             render_seconds,render_iqr,device_seconds,device_iqr,primary,reflection,refraction,shadow,rmse,\
             rmse_sampling,rmse_limit,mean_abs,max_abs,p999,psnr,flip,code_mean,code_max,rmse_rounding,truth_error,truth_truncation,\
             efficiency,on_front,linear_sha256\n",
        );
        for row in &self.rows {
            let (p, m, r) = (&row.point, &row.measured, &row.rays);
            let mut cells = vec![
                quoted(&row.name),
                p.samples.to_string(),
                p.sampler.clone(),
                p.depth.to_string(),
                p.cutoff.to_string(),
                p.precision.clone(),
                p.origin.clone(),
                p.seed.to_string(),
                p.fresnel.clone(),
                p.spheres.clone(),
                self.width.to_string(),
                self.height.to_string(),
                m.repeats.to_string(),
            ];
            cells.extend(
                [m.render.median, m.render.iqr, m.device.median, m.device.iqr].map(|x| x.to_string()),
            );
            cells.extend([r.primary, r.reflection, r.refraction, r.shadow].map(|n| n.to_string()));
            let maybe = |x: Option<f64>| x.map_or(String::new(), |x| x.to_string());
            match &row.error {
                None => cells.extend(std::iter::repeat_n(String::new(), 13)),
                Some(e) => {
                    let m = &e.metrics;
                    cells.extend([e.total.to_string(), maybe(e.sampling), maybe(e.limit)]);
                    cells.extend([m.mean_abs, m.max_abs, m.p999].map(|x| x.to_string()));
                    cells.extend([
                        maybe(m.psnr),
                        e.flip.to_string(),
                        m.code_mean.to_string(),
                        m.code_max.to_string(),
                    ]);
                    cells.extend([maybe(e.rounding), e.truth.to_string(), maybe(e.truth_truncation)]);
                }
            }
            cells.extend([maybe(row.efficiency), row.on_front.to_string(), row.image.linear_sha256.clone()]);
            let _ = writeln!(text, "{}", cells.join(","));
        }
        text
    }
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.into() }
}

#[cfg(test)]
mod tests {
    use super::super::row::ErrorInfo;
    use super::*;

    #[test]
    fn every_csv_line_has_a_cell_for_every_name() {
        let judged = Row { name: "a, \"b\"".into(), error: Some(ErrorInfo::default()), ..Row::default() };
        let record = Record { rows: vec![Row::default(), judged], ..Record::default() };
        let text = record.csv();
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[2].starts_with("\"a, \"\"b\"\"\","));
        let cells = |line: &str| line.replace("a, ", "a ").split(',').count();
        assert_eq!((cells(lines[1]), cells(lines[2])), (cells(lines[0]), cells(lines[0])));
    }

    #[test]
    fn efficiency_is_one_over_mean_square_and_time() {
        let mut row = Row { error: Some(ErrorInfo { total: 0.1, ..ErrorInfo::default() }), ..Row::default() };
        row.measured.render.median = 4.0;
        let mut record = Record { rows: vec![row], ..Record::default() };
        record.conclude(&[0.2]);
        assert!((record.rows[0].efficiency.unwrap() - 25.0).abs() < 1e-9);
        assert!(record.rows[0].on_front && record.cheapest[0].seconds == Some(4.0));
    }
}

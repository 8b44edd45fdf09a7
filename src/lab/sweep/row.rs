//! One row per point: its times, counts and errors, under the names of the render report.

use super::point::Words;
use crate::compare::flip;
use crate::compare::metrics::{Metrics, Rgb, SizeMismatch, compare};
use crate::report::{
    Counters, DeviceInfo, ImageInfo, PassInfo, PlanInfo, ProgramInfo, RayInfo, Report, SceneInfo,
    SettingsInfo, TimeInfo,
};
use crate::stats::quartiles;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Seconds measured several times.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Median.
    pub median: f64,
    /// Interquartile range.
    pub iqr: f64,
}

impl Spread {
    /// From `values`; zero if there are none.
    pub fn of(values: &[f64]) -> Spread {
        quartiles(values).map_or(Spread::default(), |q| Spread { median: q.median, iqr: q.range() })
    }
}

/// Number and times of the renders.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// Timed renders, without the warm-up; 1 for a point that takes long.
    pub repeats: u32,
    /// Device time of the passes.
    pub device: Spread,
    /// From the first submit to the last pixel on the host.
    pub render: Spread,
}

/// Error of a point against the truth, in linear light clamped to [0, 1].
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorInfo {
    /// Kind of `total`: `rmse`.
    pub kind: String,
    /// Root mean square over all channels.
    pub total: f64,
    /// Part of `total` that more samples would remove, RMSE.
    pub sampling: Option<f64>,
    /// Bias: the RMSE that infinitely many samples would leave, from depth, cutoff, precision,
    /// origin, Fresnel law and spheres.
    pub limit: Option<f64>,
    /// Standard error of the truth, RMSE.
    pub truth: f64,
    /// RMSE from the picture of the same settings in f64; missing if that is not in the sweep.
    pub rounding: Option<f64>,
    /// Upper bound on the RMSE from the truth's own depth limit; missing if unknown.
    pub truth_truncation: Option<f64>,
    /// Mean of the FLIP map (Andersson et al. 2020) at its authors' viewing distance.
    pub flip: f64,
    /// All other metrics.
    #[serde(flatten)]
    pub metrics: Metrics,
}

/// A point with its times and errors.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Row {
    /// Hash of everything that the image and its time depend on.
    pub key: String,
    /// The swept values in words.
    pub name: String,
    /// Program.
    pub program: ProgramInfo,
    /// Device.
    pub device: DeviceInfo,
    /// Scene as rendered.
    pub scene: SceneInfo,
    /// Settings in force.
    pub settings: SettingsInfo,
    /// The settings that a sweep can vary.
    pub point: Words,
    /// The plan.
    pub plan: PlanInfo,
    /// Times of the last render; `device` and `render` are medians.
    pub time: TimeInfo,
    /// Medians and their spread.
    pub measured: Measured,
    /// Rays traced.
    pub rays: RayInfo,
    /// Passes of the last render.
    pub passes: Vec<PassInfo>,
    /// Counts of numerical faults.
    pub counters: Counters,
    /// Warnings.
    pub warnings: Vec<String>,
    /// Picture and hash.
    pub image: ImageInfo,
    /// Errors; missing until they are measured.
    pub error: Option<ErrorInfo>,
    /// 1 / (mean square error * render seconds).
    pub efficiency: Option<f64>,
    /// True if on the Pareto front.
    pub on_front: bool,
}

impl Row {
    /// A row without errors.
    pub fn new(key: String, name: String, point: Words, report: Report, measured: Measured) -> Row {
        // The report's own `error` is the bound of a render with --budget, --error or --time.
        let Report {
            program,
            device,
            scene,
            settings,
            plan,
            time,
            rays,
            passes,
            counters,
            warnings,
            image,
            ..
        } = report;
        let time = TimeInfo { device: measured.device.median, render: measured.render.median, ..time };
        Row {
            key,
            name,
            program,
            device,
            scene,
            settings,
            point,
            plan,
            time,
            measured,
            rays,
            passes,
            counters,
            warnings,
            image,
            ..Row::default()
        }
    }

    /// Seconds of a render.
    pub fn seconds(&self) -> f64 {
        self.measured.render.median
    }

    /// Total error; `None` until it is measured.
    pub fn rmse(&self) -> Option<f64> {
        self.error.as_ref().map(|e| e.total)
    }
}

/// Measures the errors of an image. `truth_error` is the truth's standard error, `truth_truncation`
/// the bound on the error from its depth limit, and `limit` the bias.
///
/// # Errors
/// If the images have different sizes.
pub fn judge<A: Rgb + Sync>(
    image: &[A],
    truth: &[DVec3],
    width: usize,
    truth_error: f64,
    truth_truncation: Option<f64>,
    limit: Option<f64>,
) -> Result<ErrorInfo, SizeMismatch> {
    let metrics = compare(image, truth)?;
    let flip = flip::mean(&flip::flip(image, truth, width, flip::PIXELS_PER_DEGREE)?);
    let total = metrics.rmse;
    // The truth's noise is independent of the image's, so their squares add up.
    let sampling = limit.map(|l| (total * total - l * l - truth_error * truth_error).max(0.0).sqrt());
    let kind = "rmse".into();
    Ok(ErrorInfo {
        kind,
        total,
        sampling,
        limit,
        rounding: None,
        truth: truth_error,
        truth_truncation,
        flip,
        metrics,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn truth() -> Vec<DVec3> {
        (0..100).map(|i| DVec3::new(f64::from(i) / 100.0, 0.5, 1.0 - f64::from(i) / 100.0)).collect()
    }

    /// A judge that could not tell a wrong truth from a right one would be none.
    #[test]
    fn a_wrong_truth_shows_as_error() {
        let image: Vec<[f32; 3]> = truth().iter().map(|p| p.to_array().map(|x| x as f32)).collect();
        let right = judge(&image, &truth(), 10, 0.0, None, None).unwrap();
        assert!(right.total < 1e-7, "{right:?}");
        let swapped: Vec<DVec3> = truth().iter().map(|p| DVec3::new(p.z, p.y, p.x)).collect();
        let wrong = judge(&image, &swapped, 10, 0.0, None, None).unwrap();
        assert!(wrong.total > 0.3 && wrong.flip > 0.1 && wrong.metrics.max_abs > 0.9, "{wrong:?}");
        assert!(judge(&image[1..], &truth(), 10, 0.0, None, None).is_err());
    }

    #[test]
    fn the_parts_add_up_as_squares() {
        let image: Vec<[f32; 3]> = truth().iter().map(|p| p.to_array().map(|x| x as f32 * 0.8)).collect();
        let e = judge(&image, &truth(), 10, 0.01, None, Some(0.05)).unwrap();
        let sum = e.sampling.unwrap().powi(2) + e.limit.unwrap().powi(2) + e.truth.powi(2);
        assert!((sum - e.total * e.total).abs() < 1e-12);
        // A limit above the whole leaves nothing, not a root of something negative.
        assert_eq!(judge(&image, &truth(), 10, 0.0, None, Some(9.0)).unwrap().sampling, Some(0.0));
    }
}

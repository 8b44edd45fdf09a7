//! One pair of pictures: read, measured, judged.

use crate::cli::args::{CompareArgs, Metric};
use crate::cli::failure::Failure;
use crate::compare::flip;
use crate::compare::metrics::{self, Metrics};
use crate::compare::statistical::{self, Statistics};
use crate::image::Picture;
use crate::units::{figure, number};
use anyhow::{Context, anyhow};
use serde::Serialize;
use std::path::Path;

/// All metrics of a pair.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Figures {
    #[serde(flatten)]
    pub plain: Metrics,
    /// Mean of the FLIP map.
    pub flip: f64,
    /// Of all pixels.
    pub differing_share: f64,
    /// Of all pixels, in 8-bit codes.
    pub code_differing_share: f64,
}

/// The metric that was asked for, against its threshold.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Judged {
    pub metric: String,
    /// None: psnr of equal pictures, which is infinite.
    pub value: Option<f64>,
    pub threshold: Option<f64>,
    /// On the wrong side of the threshold; None without one.
    pub above: Option<bool>,
}

/// What pairs are judged by.
#[derive(Debug, Clone, Copy)]
pub(super) struct Criteria {
    pub metric: Metric,
    pub threshold: Option<f64>,
    /// Of a statistical test of one pair; None without one.
    pub significance: Option<f64>,
}

impl Criteria {
    pub fn of(args: &CompareArgs) -> Criteria {
        Criteria { metric: args.metric, threshold: args.threshold, significance: args.significance() }
    }
}

/// Two pictures of one size, measured and judged.
pub(super) struct Pair {
    pub a: Picture,
    pub b: Picture,
    pub figures: Figures,
    pub judged: Judged,
    /// Result of `--statistical`.
    pub statistics: Option<Statistics>,
    /// FLIP of each pixel.
    pub flip: Vec<f64>,
    /// |z| of each pixel's block; empty without `--statistical`.
    pub scores: Vec<f64>,
}

impl Pair {
    /// Reads two pictures, measures their difference and judges it.
    pub fn of(a: &Path, b: &Path, criteria: &Criteria) -> Result<Pair, Failure> {
        let (first, second) = (load(a)?, load(b)?);
        // A crop is compared with its part of the whole.
        let pictures = [first.clone().cut_like(&second), second.cut_like(&first)];
        let [first, second] = &pictures;
        if (first.width, first.height) != (second.width, second.height) {
            return Err(Failure::Other(anyhow!(
                "{} has {}x{} pixels and {} has {}x{}: pictures must have the same size",
                a.display(),
                first.width,
                first.height,
                b.display(),
                second.width,
                second.height,
            )));
        }
        let width = first.width as usize;
        let flip = flip::flip(&first.linear, &second.linear, width, flip::PIXELS_PER_DEGREE)
            .context("cannot compare the pictures")?;
        let plain = metrics::compare(&first.linear, &second.linear).context("cannot compare the pictures")?;
        let pixels = first.linear.len().max(1) as f64;
        let figures = Figures {
            plain,
            flip: flip::mean(&flip),
            differing_share: plain.differing_pixels as f64 / pixels,
            code_differing_share: plain.code_differing_pixels as f64 / pixels,
        };
        let tested = match criteria.significance {
            Some(p) => {
                let tested = statistical::test(&first.linear, &second.linear, width, p);
                Some(tested.context("cannot compare the pictures")?)
            }
            None => None,
        };
        let judged = judge(&figures, criteria.metric, criteria.threshold);
        let (statistics, scores) = tested.map_or((None, Vec::new()), |t| (Some(t.statistics), t.map));
        let [a, b] = pictures;
        Ok(Pair { a, b, figures, judged, statistics, flip, scores })
    }

    /// Why the pair is not accepted: above the threshold, or different beyond noise.
    pub fn refusal(&self) -> Option<String> {
        refusal(&self.judged, self.statistics.as_ref())
    }
}

/// As [`Pair::refusal`].
fn refusal(judged: &Judged, statistics: Option<&Statistics>) -> Option<String> {
    if let Some(s) = statistics.filter(|s| s.significant) {
        return Some(match &s.worst {
            Some(worst) if !s.exact => format!(
                "the pictures differ by more than noise: {} blocks, the worst at {} with |z| {} above {}",
                s.significant_blocks,
                region(worst.region),
                figure(worst.z.abs()),
                figure(s.threshold),
            ),
            _ => format!("{} pixels differ, too few for noise: compared exactly", s.differing_pixels),
        });
    }
    let Judged { metric, value, threshold, above: Some(true) } = judged else { return None };
    Some(format!(
        "{metric} {} is {} the threshold {}",
        value.map_or("infinite".into(), number),
        if metric == "psnr" { "below" } else { "above" },
        threshold.map_or(String::new(), number),
    ))
}

/// `x0,y0,x1,y1`, as `--crop` takes it.
pub(super) fn region([x0, y0, x1, y1]: [u32; 4]) -> String {
    format!("{x0},{y0},{x1},{y1}")
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

pub(super) fn judge(figures: &Figures, metric: Metric, threshold: Option<f64>) -> Judged {
    let plain = &figures.plain;
    let value = match metric {
        Metric::Rmse => Some(plain.rmse),
        Metric::Mean => Some(plain.mean_abs),
        Metric::Max => Some(plain.max_abs),
        Metric::P999 => Some(plain.p999),
        Metric::Psnr => plain.psnr,
        Metric::Flip => Some(figures.flip),
        Metric::Pixels => Some(figures.differing_share),
        Metric::Codes => Some(f64::from(plain.code_max)),
    };
    let beyond =
        |limit: f64| value.is_some_and(|v| if metric == Metric::Psnr { v < limit } else { v > limit });
    Judged { metric: metric.name().into(), value, threshold, above: threshold.map(beyond) }
}

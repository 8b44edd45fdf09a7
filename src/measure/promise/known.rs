//! An image whose error is known, and what can be painted of it.

use super::Task;
use crate::coincident;
use crate::measure::budget::{self, Rounding};
use crate::measure::gathered::Gathered;
use crate::measure::limit::RadianceLimit;
use crate::render::{RenderError, Survey};
use crate::report::Report;
use std::time::Duration;

/// An image with its error budget.
#[derive(Debug, Clone)]
pub struct Known {
    /// The samples; a row is as wide as the region rendered.
    pub samples: Gathered,
    /// Rows of the region rendered.
    pub height: u32,
    /// Greatest radiance that a ray of this scene can bring.
    pub limit: RadianceLimit,
    /// Difference of each pixel to the same samples in f64, where all of them were compared.
    pub rounding: Option<Vec<f64>>,
    /// Everything that was counted, timed, asked for and reached.
    pub report: Report,
    /// Share of the pixels that have samples; 1 unless interrupted.
    pub done: f64,
    /// True if it was cancelled.
    pub cancelled: bool,
}

/// What `--aov` paints, one number a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Layer {
    /// Half the width of the pixel's confidence interval.
    Sampling,
    /// What rays that were not traced can add to the pixel as shown.
    Truncation,
    /// Difference to the same samples in f64.
    Rounding,
    /// Samples.
    Samples,
    /// Rays in the longest path.
    Depth,
    /// Rays traced, shadow rays included.
    Cost,
}

impl Layer {
    /// All, as the command line names them.
    pub const ALL: [Layer; 6] =
        [Layer::Sampling, Layer::Truncation, Layer::Rounding, Layer::Samples, Layer::Depth, Layer::Cost];

    /// As the command line and files name it.
    pub fn name(self) -> &'static str {
        match self {
            Layer::Sampling => "sampling",
            Layer::Truncation => "truncation",
            Layer::Rounding => "rounding",
            Layer::Samples => "samples",
            Layer::Depth => "depth",
            Layer::Cost => "cost",
        }
    }

    /// What its numbers are.
    pub fn unit(self) -> &'static str {
        match self {
            Layer::Sampling => "half the confidence interval, linear light",
            Layer::Truncation => "light that may be missing, linear",
            Layer::Rounding => "difference to f64, linear light",
            Layer::Samples => "samples",
            Layer::Depth => "rays in the longest path",
            Layer::Cost => "rays traced",
        }
    }
}

impl std::str::FromStr for Layer {
    type Err = String;

    fn from_str(text: &str) -> Result<Layer, String> {
        let names = || Layer::ALL.map(Layer::name).join(", ");
        Layer::ALL.into_iter().find(|l| l.name() == text).ok_or_else(|| format!("one of {}", names()))
    }
}

impl Known {
    /// The numbers of a layer, rows from the top; NaN where a pixel has none.
    pub fn layer(&self, layer: Layer) -> Vec<f64> {
        let confidence = self.report.error.as_ref().map_or(0.95, |e| e.confidence);
        let marks = || self.samples.marks.iter();
        match layer {
            Layer::Sampling => self.samples.half_widths(confidence),
            Layer::Truncation => self.samples.hidden(&self.limit),
            Layer::Rounding => {
                self.rounding.clone().unwrap_or_else(|| vec![f64::NAN; self.samples.samples.len()])
            }
            Layer::Samples => self.samples.samples.iter().map(|n| f64::from(*n)).collect(),
            Layer::Depth => marks().map(|m| f64::from(m.depth)).collect(),
            Layer::Cost => marks().map(|m| f64::from(m.rays)).collect(),
        }
    }
}

impl Task<'_> {
    /// The image with its budget, all of whose samples may have been compared with f64.
    pub(super) fn known(
        self,
        image: Gathered,
        survey: Survey,
        rounding: Option<Rounding>,
        prepared: Duration,
        render: Duration,
    ) -> Result<Known, RenderError> {
        let part = rounding.as_ref().map(|r| (r.rmse, r.ways));
        self.known_with(image, survey, rounding.map(|r| r.pixels), part, prepared, render)
    }

    /// The image with its budget.
    pub(super) fn known_with(
        self,
        image: Gathered,
        survey: Survey,
        pixels: Option<Vec<f64>>,
        rounding: Option<(f64, u64)>,
        prepared: Duration,
        render: Duration,
    ) -> Result<Known, RenderError> {
        let mut report = survey.report();
        report.device = self.renderer.device().info();
        report.warnings = survey.warnings.clone();
        report.warnings.extend(coincident::warnings(self.scene));
        let traced: u64 = image.samples.iter().map(|n| u64::from(*n)).sum();
        let mean = traced as f64 / image.samples.len().max(1) as f64;
        report.settings.samples = mean.round() as u32;
        report.settings.crop = self.settings.crop;
        report.time.build = survey.built.as_secs_f64();
        report.time.first_dispatch = prepared.as_secs_f64();
        report.time.device = report.passes.iter().map(|p| p.seconds).sum();
        report.time.render = render.as_secs_f64();
        report.error = Some(budget::budget(&image, &self.limit, rounding, self.request.confidence));
        let done = image.done();
        let height = image.samples.len() as u32 / image.width.max(1);
        let cancelled = self.observer.cancelled();
        Ok(Known { samples: image, height, limit: self.limit, rounding: pixels, report, done, cancelled })
    }
}

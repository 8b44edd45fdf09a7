//! An image with an error bound, and its layers.

use super::longer_paths::{Measured, sampling_confidence};
use super::{Bounded, Request, Task};
use crate::accuracy::budget::{self, Rounding};
use crate::accuracy::pixel_sums::PixelSums;
use crate::accuracy::radiance_bound::RadianceLimit;
use crate::image::{self, Format, SaveError, View, linear_sha256};
use crate::render::{Observer, Rendered, ResumeState, Survey, not_finite};
use crate::report::{ErrorInfo, Report, TimeInfo};
use std::path::Path;

/// An image with an upper bound on its error, in [`Report::error`].
#[derive(Debug, Clone)]
pub struct BoundedImage {
    /// The samples; a row is as wide as the region rendered. No rows where nothing is known of the error.
    #[doc(hidden)]
    pub samples: PixelSums,
    /// Rows of the region rendered.
    pub height: u32,
    /// Greatest radiance of a ray in this scene.
    #[doc(hidden)]
    pub limit: RadianceLimit,
    /// Comparison with the same samples in f64, rows from the top; `None` unless all samples were compared.
    #[doc(hidden)]
    pub rounding: Option<Rounding>,
    /// Box and primitive tests of each pixel, rows from the top; `None` unless counted by
    /// [`Renderer::tests_per_pixel`](crate::Renderer::tests_per_pixel).
    pub tests: Option<Vec<f64>>,
    /// Confidence of the error bound, in (0, 1).
    pub confidence: f64,
    /// Everything that was counted, timed, asked for and reached; without an error bound if some pixels have no samples.
    pub report: Report,
    /// Share of the pixels that have samples; 1 unless cancelled or short of time.
    pub done: f64,
    /// True if sampled from coarse to fine, so that pixels without samples can be filled in.
    coarse: bool,
    /// The image of a render that kept nothing else of its samples.
    plain: Option<Vec<[f32; 3]>>,
    /// Format of the file that the error bound is of; its bits may have been chosen.
    pub file: Option<Format>,
    /// True if it was cancelled.
    pub cancelled: bool,
    /// The state for [`Renderer::resume_bounded`](crate::Renderer::resume_bounded), if it was cancelled and can be
    /// resumed.
    pub unfinished: Option<ResumeState<Bounded>>,
}

/// A layer of `--aov`: one number per pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Layer {
    /// Half-width of the pixel's confidence interval.
    Sampling,
    /// Upper bound on the light of rays that were not traced, added to the clamped pixel.
    Truncation,
    /// Difference in value from the same samples in f64; NaN where a sample takes another path.
    Rounding,
    /// 1 where a sample takes another path in f64, else 0.
    RoundingPaths,
    /// Number of samples.
    Samples,
    /// Length of the longest path, rays.
    Depth,
    /// Rays traced, shadow rays included.
    Cost,
    /// Box and primitive tests.
    Tests,
}

impl Layer {
    /// All layers.
    pub const ALL: [Layer; 8] = [
        Layer::Sampling,
        Layer::Truncation,
        Layer::Rounding,
        Layer::RoundingPaths,
        Layer::Samples,
        Layer::Depth,
        Layer::Cost,
        Layer::Tests,
    ];

    /// Its name on the command line and in file names.
    pub fn name(self) -> &'static str {
        match self {
            Layer::Sampling => "sampling",
            Layer::Truncation => "truncation",
            Layer::Rounding => "rounding",
            Layer::RoundingPaths => "rounding-paths",
            Layer::Samples => "samples",
            Layer::Depth => "depth",
            Layer::Cost => "cost",
            Layer::Tests => "tests",
        }
    }

    /// Its quantity and unit, for a legend.
    pub fn unit(self) -> &'static str {
        match self {
            Layer::Sampling => "half-width of the confidence interval, linear light",
            Layer::Truncation => "upper bound on light from rays not traced, linear light",
            Layer::Rounding => "difference from f64 where all samples take the same paths, linear light",
            Layer::RoundingPaths => "1 where a sample takes another path in f64, else 0",
            Layer::Samples => "samples per pixel",
            Layer::Depth => "length of the longest path, rays",
            Layer::Cost => "rays traced per pixel",
            Layer::Tests => "box and primitive tests per pixel",
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

impl BoundedImage {
    /// The image of a plain render: its pixels are known, their errors are not.
    pub(super) fn plain(
        rendered: Rendered,
        limit: RadianceLimit,
        request: &Request,
        cancelled: bool,
    ) -> BoundedImage {
        BoundedImage {
            samples: PixelSums::new(rendered.width, 0, 1),
            height: rendered.height,
            limit,
            rounding: None,
            tests: None,
            confidence: request.confidence,
            report: rendered.report,
            done: rendered.done,
            coarse: false,
            plain: Some(rendered.linear),
            file: request.file,
            cancelled,
            unfinished: None,
        }
    }

    /// Columns of the region rendered.
    pub fn width(&self) -> u32 {
        self.samples.width
    }

    /// Writes the image as [`Rendered::save`](crate::Rendered::save) does.
    ///
    /// # Errors
    /// If the extension is none of `.png`, `.exr`, `.hdr`, or the file cannot be written.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), SaveError> {
        let view = View { width: self.width(), height: self.height, linear: &self.linear() };
        image::save(path.as_ref(), view, &self.report, self.done)
    }

    /// The image, linear RGB, rows from the top. Pixels without samples copy their nearest neighbour with samples if the image was
    /// sampled from coarse to fine; otherwise they are black.
    pub fn linear(&self) -> Vec<[f32; 3]> {
        match &self.plain {
            Some(linear) => linear.clone(),
            None if self.coarse && self.done > 0.0 => self.samples.filled(),
            None => self.samples.linear(),
        }
    }

    /// The values of a layer, rows from the top; NaN if unknown.
    pub fn layer(&self, layer: Layer) -> Vec<f64> {
        let marks = || self.samples.marks.iter();
        let rounding = self.rounding.as_ref();
        let pixels = self.width() as usize * self.height as usize;
        let unknown = || vec![f64::NAN; pixels];
        if self.plain.is_some() {
            let samples = f64::from(self.report.settings.samples);
            return if layer == Layer::Samples { vec![samples; pixels] } else { unknown() };
        }
        match layer {
            Layer::Sampling => self.samples.half_widths(self.confidence),
            Layer::Truncation => self.samples.hidden(&self.limit),
            Layer::Rounding => rounding.map_or_else(unknown, Rounding::value_differences),
            Layer::RoundingPaths => rounding.map_or_else(unknown, Rounding::path_differences),
            Layer::Tests => self.tests.clone().unwrap_or_else(unknown),
            Layer::Samples => self.samples.samples.iter().map(|n| f64::from(*n)).collect(),
            Layer::Depth => marks().map(|m| f64::from(m.depth)).collect(),
            Layer::Cost => marks().map(|m| f64::from(m.rays)).collect(),
        }
    }
}

/// Samples of a render, with their times.
pub(super) struct Image {
    pub(super) samples: PixelSums,
    /// Rounding part, and the number of pixels with a sample whose path differs in f64.
    pub(super) rounding: Option<(f64, u64)>,
    /// Truncation part from longer paths; `None` for what is certain.
    pub(super) measured: Option<Measured>,
    pub(super) took: TimeInfo,
    /// Times of an earlier, interrupted part.
    pub(super) before: TimeInfo,
    /// True if sampled from coarse to fine.
    pub(super) coarse: bool,
}

impl Task<'_> {
    /// The image with its error bound; without one if pixels have no samples.
    pub(super) fn known(self, image: Image, survey: &Survey) -> BoundedImage {
        let Image { samples, rounding, measured, took, before, coarse } = image;
        let mut report = survey.report();
        report.device = self.renderer.device().info();
        report.warnings = survey.warnings().to_vec();
        let traced: u64 = samples.samples.iter().map(|n| u64::from(*n)).sum();
        let mean = traced as f64 / samples.samples.len().max(1) as f64;
        report.settings.samples = mean.round() as u32;
        report.settings.crop = self.settings.crop;
        report.scene.file = self.scene.file.display().to_string();
        report.scene.notes = self.scene.notes.lines();
        let read = self.scene.read_time.0;
        report.time = TimeInfo {
            wall: before.wall + read.as_secs_f64() + took.wall,
            scene: before.scene + read.as_secs_f64(),
            build: before.build + took.build,
            first_dispatch: before.first_dispatch + took.first_dispatch,
            device: report.passes.iter().map(|p| p.seconds).sum(),
            render: before.render + took.render,
        };
        let done = samples.done();
        let confidence = self.request.confidence;
        let least = samples.samples.iter().min().copied().unwrap_or(0);
        let lost = report.counters.lost();
        report.error = (done == 1.0 && least > 0).then(|| {
            let linear = samples.linear();
            let height = linear.len() as u32 / samples.width.max(1);
            let view = View { width: samples.width, height, linear: &linear };
            let encoding = self.request.file.map(|format| format.encoding_error(view));
            let others = (rounding, encoding);
            let sampling = measured.map_or(confidence, |_| sampling_confidence(confidence));
            let certain = budget::budget(&samples, &self.limit, &self.caps, others, sampling);
            let error = match measured {
                None => certain,
                Some(measured) => measured.into_error(certain, confidence),
            };
            ErrorInfo { void: lost.or_else(|| not_finite(&linear)), ..error }
        });
        let file = self.request.file;
        let height = samples.height();
        let cancelled = self.observer.cancelled();
        let limit = self.limit;
        let (rounding, unfinished) = (None, None);
        let mut image = BoundedImage {
            samples,
            height,
            limit,
            rounding,
            tests: None,
            confidence,
            report,
            done,
            coarse,
            plain: None,
            cancelled,
            unfinished,
            file,
        };
        image.report.image.linear_sha256 = linear_sha256(&image.linear());
        image
    }
}

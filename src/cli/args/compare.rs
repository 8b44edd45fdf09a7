//! `whitted compare`.

use super::values;
use clap::{Args, ValueEnum};
use std::path::PathBuf;

const COMPARE_HELP: &str = "\
Pictures are compared in linear light, clamped to [0, 1] as a screen shows them. PNG and PPM codes (8 or 16 \
bits) are decoded from sRGB; EXR, HDR and PFM hold linear values. The table goes to standard output, and to \
standard error under --json -.

--statistical tests blocks of 8x8 and 32x32 pixels and the whole picture: the mean difference of a block \
over its standard error, which the differences themselves give. All tests together raise a false alarm \
with at most the probability --significance. That needs independent noise: pictures with the same \
settings and different seeds. --diff then shows each block in standard errors. Too few differing pixels \
for noise, and the pictures are compared exactly.

Two folders are compared picture by picture: those with the same name below both are a pair; all others, \
and pairs that cannot be compared, are failures. --significance then holds for all pairs together.

Examples:
  whitted compare new.png old.png
  whitted compare new.exr truth.exr --diff where.png --threshold 0.001
  whitted compare new.png old.png --metric flip --diff flip.png --json -
  whitted compare seed1.exr seed2.exr --statistical
  whitted compare new-pictures old-pictures --threshold 0.001 -o page.html";

/// `whitted compare`.
#[derive(Debug, Args)]
#[command(after_help = super::notes(COMPARE_HELP))]
pub struct CompareArgs {
    /// Picture to judge: PNG, EXR, HDR, PPM or PFM; or a folder of pictures
    pub a: PathBuf,

    /// Picture to compare it with, of the same size; or a folder with pictures of the same names
    pub b: PathBuf,

    /// Write a false-colour picture of the difference, with its scale (PNG)
    #[arg(long, value_name = "OUT.png", value_parser = values::png())]
    pub diff: Option<PathBuf>,

    /// For two folders: write one page with all metrics and pictures, which needs no other file (HTML)
    #[arg(short, long, value_name = "PAGE.html", value_parser = values::html())]
    pub output: Option<PathBuf>,

    /// Difference that --diff shows in its lightest colour [default: the largest]
    #[arg(long, value_name = "X", value_parser = values::above_zero, requires = "diff")]
    pub full_scale: Option<f64>,

    /// Write all metrics as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,

    /// Metric that --threshold tests and --diff shows
    #[arg(long, value_name = "WHICH", default_value = "rmse")]
    pub metric: Metric,

    /// Exit with 6 if the metric is above X; for psnr, below
    #[arg(long, value_name = "X", value_parser = values::not_negative)]
    pub threshold: Option<f64>,

    /// For noisy pictures: exit with 6 if blocks of pixels differ by more than noise; render both with equal settings and different seeds
    #[arg(long, conflicts_with_all = ["threshold", "metric"])]
    pub statistical: bool,

    /// Rate of false alarms of --statistical, in (0, 1) [default: 0.01]
    #[arg(long, value_name = "P", value_parser = values::significance, requires = "statistical")]
    pub significance: Option<f64>,

    /// Print only errors
    #[arg(short, long)]
    pub quiet: bool,
}

impl CompareArgs {
    /// The significance of a statistical test; None without one.
    pub fn significance(&self) -> Option<f64> {
        self.statistical.then(|| self.significance.unwrap_or(0.01))
    }
}

/// A metric of `whitted compare`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Metric {
    /// Root mean square error
    Rmse,
    /// Mean absolute error
    Mean,
    /// Largest error
    Max,
    /// 99.9th percentile of the pixels' errors
    P999,
    /// Peak signal-to-noise ratio, decibels
    Psnr,
    /// Mean LDR-FLIP: perceived difference
    Flip,
    /// Share of pixels that differ
    Pixels,
    /// Largest difference in 8-bit sRGB codes
    Codes,
}

impl Metric {
    /// Its name on the command line and in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Metric::Rmse => "rmse",
            Metric::Mean => "mean",
            Metric::Max => "max",
            Metric::P999 => "p999",
            Metric::Psnr => "psnr",
            Metric::Flip => "flip",
            Metric::Pixels => "pixels",
            Metric::Codes => "codes",
        }
    }
}

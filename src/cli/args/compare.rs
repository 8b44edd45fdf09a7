//! `whitted compare`.

use super::values;
use clap::{Args, ValueEnum};
use std::path::PathBuf;

const COMPARE_HELP: &str = concat!(
    "\
Both pictures are taken in linear light, clamped to [0, 1] as they will be shown: PNG codes (8 or 16 \
bits) are decoded from sRGB, EXR and HDR hold linear values. The table goes to standard output, or to \
standard error where --json - has standard output.

Examples:
  whitted compare new.png old.png
  whitted compare new.exr truth.exr --diff where.png --threshold 0.001
  whitted compare new.png old.png --metric flip --diff flip.png --json -

",
    exit_codes!()
);

/// `whitted compare`.
#[derive(Debug, Args)]
#[command(after_help = COMPARE_HELP)]
pub struct CompareArgs {
    /// Picture to judge: PNG, EXR or HDR
    pub a: PathBuf,

    /// Picture to judge it by, of the same size
    pub b: PathBuf,

    /// Write a false-colour picture of the difference, with its scale (PNG)
    #[arg(long, value_name = "OUT.png", value_parser = values::png())]
    pub diff: Option<PathBuf>,

    /// Difference that --diff shows in its lightest colour [default: the largest]
    #[arg(long, value_name = "X", value_parser = values::above_zero, requires = "diff")]
    pub full_scale: Option<f64>,

    /// Write all figures as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,

    /// Figure that --threshold judges, and --diff shows
    #[arg(long, value_name = "WHICH", default_value = "rmse")]
    pub metric: Metric,

    /// Exit with 6 if the figure is above X; for psnr, below
    #[arg(long, value_name = "X", value_parser = values::not_negative)]
    pub threshold: Option<f64>,

    /// Say nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
}

/// A figure of `whitted compare`.
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
    /// Mean LDR-FLIP: how different they look
    Flip,
    /// Share of the pixels that differ
    Pixels,
    /// Largest difference in 8-bit sRGB codes
    Codes,
}

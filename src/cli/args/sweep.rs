//! `whitted sweep`.

use super::values::{self, Size};
use super::{DeviceArgs, ReadArgs, Verbosity};
use crate::lab::sweep::axes::Axis;
use clap::Args;
use std::path::PathBuf;
use std::sync::LazyLock;

static SWEEP_HELP: LazyLock<String> = LazyLock::new(|| {
    format!(
        "\
Values are separated by commas. Settings that no axis names are those of the scene and the defaults of `render`.

Axes:
{}

DIR receives sweep.json and sweep.csv (one row per point), index.html (plots, tables and pictures in one file), the plots \
as SVG and PNG, the picture of each point (linear EXR), and the reference that they were compared with. Ctrl-C stops after \
the work in flight; the same command continues.

Example:
  whitted sweep scenes/cornell.toml --size 150x125 --over samples=1..64 sampler=all depth=1..6 -o out/sweep",
        crate::lab::sweep::axes::listing()
    )
});

/// `whitted sweep`.
#[derive(Debug, Args)]
#[command(after_help = super::notes(&SWEEP_HELP))]
pub struct SweepArgs {
    /// Scene text (TOML), or a model; `-` for a scene on standard input
    pub scene: PathBuf,

    /// Settings to vary; all combinations are rendered. The axes are listed below
    #[arg(long, value_name = "AXIS=VALUES", num_args = 1.., required = true)]
    pub over: Vec<Axis>,

    /// Folder to write to; created if missing
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,

    /// Image size in pixels [default: the scene's]
    #[arg(long, value_name = "WxH")]
    pub size: Option<Size>,

    /// Timed renders of each point after a warm-up; a point that takes over 10 s is rendered once
    #[arg(long, value_name = "N", value_parser = values::positive(), default_value_t = 5)]
    pub repeats: u32,

    /// Errors (RMSE) for which to list the cheapest point
    #[arg(long, value_name = "E,E", value_delimiter = ',', value_parser = values::above_zero, default_value = "0.1,0.03,0.01,0.003,0.001,0.0003,0.0001")]
    pub error: Vec<f64>,

    /// Samples per pixel of the reference, at most; fewer once its error is a tenth of every point's
    #[arg(long, value_name = "N", value_parser = values::samples(), default_value_t = 4096)]
    pub truth_samples: u32,

    /// Use the CPU oracle as reference, which shares only the sampler with the kernels, instead of f64 on the device; slow
    #[arg(long)]
    pub oracle: bool,

    /// Discard the results of an earlier sweep in DIR
    #[arg(long)]
    pub fresh: bool,

    /// How files are read.
    #[command(flatten)]
    pub read: ReadArgs,

    /// Device to use.
    #[command(flatten)]
    pub device: DeviceArgs,

    /// Messages.
    #[command(flatten)]
    pub verbosity: Verbosity,
}

//! `whitted sweep`.

use super::values::{self, Size};
use super::{DeviceArgs, Verbosity};
use crate::lab::sweep::axes::Axis;
use clap::Args;
use std::path::PathBuf;
use std::sync::LazyLock;

static SWEEP_HELP: LazyLock<String> = LazyLock::new(|| {
    format!(
        "\
Axes (values separated by commas; what no axis names is the scene's own or the default of `render`):
{}

In DIR: sweep.json and sweep.csv (a row a point), index.html (plots, tables and pictures in one file), the plots as \
SVG and PNG, the pictures behind the points (linear, EXR), and the truth that judged them. Ctrl-C stops \
after the work in flight; the same command goes on from there.

Example:
  whitted sweep scenes/cornell.toml --size 150x125 --over samples=1..64 sampler=all depth=1..6 -o out/sweep",
        crate::lab::sweep::axes::listing()
    )
});
/// `whitted sweep`.
#[derive(Debug, Args)]
#[command(after_help = SWEEP_HELP.as_str())]
pub struct SweepArgs {
    /// Scene text (TOML)
    pub scene: PathBuf,

    /// What to vary: all combinations are rendered; the axes are below
    #[arg(long, value_name = "AXIS=VALUES", num_args = 1.., required = true)]
    pub over: Vec<Axis>,

    /// Folder to write to; made if it is not there
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,

    /// Image size in pixels [default: the scene's]
    #[arg(long, value_name = "WxH")]
    pub size: Option<Size>,

    /// Renders of each point after a warm-up; one that takes over 10 s is rendered once
    #[arg(long, value_name = "N", value_parser = values::positive(), default_value_t = 5)]
    pub repeats: u32,

    /// Errors (RMSE) to name the cheapest point for
    #[arg(long, value_name = "E,E", value_delimiter = ',', value_parser = values::above_zero, default_value = "0.1,0.03,0.01,0.003,0.001,0.0003,0.0001")]
    pub error: Vec<f64>,

    /// Most samples of a pixel of the truth; it stops earlier once it is ten times better than every point
    #[arg(long, value_name = "N", value_parser = values::positive(), default_value_t = 4096)]
    pub truth_samples: u32,

    /// Judge by the oracle on the CPU, which shares only the sampler with the kernels, also where the device has f64; slow
    #[arg(long)]
    pub oracle: bool,

    /// Forget what an earlier sweep left in DIR
    #[arg(long)]
    pub fresh: bool,

    /// Device to use.
    #[command(flatten)]
    pub device: DeviceArgs,

    /// How much to say.
    #[command(flatten)]
    pub verbosity: Verbosity,
}

//! `whitted plan`.

use super::{DeviceArgs, PictureArgs, ReadArgs, ScheduleArgs, Verbosity, values};
use clap::Args;
use std::path::PathBuf;

const PLAN_HELP: &str = "\
Shows the features of the scene and what follows from them: how deep light can travel, which kernels run and how they are \
specialised, queues and buffers with their bytes, tiles and batches, and the predicted time on this device. The prediction \
comes from a trial that traces bands of the image, an eighth of it at most. --from takes the times from a report of the same \
scene instead, if that render ran the planned kernels and was deep enough. If the render does not fit the device, the \
message says what would fit, and the exit code is that of the render.

Examples:
  whitted plan scenes/cornell.toml
  whitted plan scenes/cornell.toml --size 8192x8192 --samples 64 --no-trial
  whitted render scenes/cornell.toml -o a.png --report a.json
  whitted plan scenes/cornell.toml --samples 40 --depth 5 --from a.json
  whitted plan scenes/cornell.toml --error 0.01 --json plan.json
  whitted render scenes/cornell.toml --as plan.json --share 1/8 -o 1.share";

/// `whitted plan`.
#[derive(Debug, Args)]
#[command(after_help = super::notes(PLAN_HELP))]
pub struct PlanArgs {
    /// Scene text (TOML), or a model; `-` for a scene on standard input
    pub scene: PathBuf,

    /// Size, samples, depth and the like.
    #[command(flatten)]
    pub picture: PictureArgs,

    /// Predict from the times in the report of an earlier render instead of a trial
    #[arg(long, value_name = "REPORT.json", conflicts_with = "no_trial")]
    pub from: Option<PathBuf>,

    /// Trace nothing; predict no time
    #[arg(long)]
    pub no_trial: bool,

    /// Write the plan as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,

    /// How files are read.
    #[command(flatten)]
    pub read: ReadArgs,

    /// Choose samples, depth and precision for an RMSE of at most E, in linear light from 0 to 1, for `render --as`
    #[arg(long, value_name = "E", value_parser = values::above_zero, conflicts_with_all = ["samples", "cutoff"])]
    pub error: Option<f64>,

    /// Device to use.
    #[command(flatten)]
    pub device: DeviceArgs,

    /// How the work is divided.
    #[command(flatten)]
    pub schedule: ScheduleArgs,

    /// Messages.
    #[command(flatten)]
    pub verbosity: Verbosity,
}

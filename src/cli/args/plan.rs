//! `whitted plan`.

use super::{DeviceArgs, PictureArgs, ScheduleArgs, Verbosity};
use clap::Args;
use std::path::PathBuf;

const PLAN_HELP: &str = concat!(
    "\
Tells, before anything is rendered, what the scene has and what follows from it: how deep light can travel, which kernels \
run and how they are specialised, queues and other buffers with their bytes, tiles and batches, and how long the render will \
take on this device. For the time it traces a few bands of the image, an eighth at most; --from takes the times of a report of \
the same scene instead, where its kernels are those planned and it was deep enough; and --no-trial leaves them out. A plan that the device cannot hold is told with what would fit, and the \
exit code is that of the render.

Examples:
  whitted plan scenes/cornell.toml
  whitted plan scenes/cornell.toml --size 8192x8192 --samples 64 --no-trial
  whitted render scenes/cornell.toml -o a.png --report a.json
  whitted plan scenes/cornell.toml --samples 40 --depth 5 --from a.json

",
    exit_codes!()
);

/// `whitted plan`.
#[derive(Debug, Args)]
#[command(after_help = PLAN_HELP)]
pub struct PlanArgs {
    /// Scene text (TOML)
    pub scene: PathBuf,

    /// What the picture is made of.
    #[command(flatten)]
    pub picture: PictureArgs,

    /// Predict from the times of this report of an earlier render, not from a trial
    #[arg(long, value_name = "REPORT.json", conflicts_with = "no_trial")]
    pub from: Option<PathBuf>,

    /// Trace nothing: no predicted time
    #[arg(long)]
    pub no_trial: bool,

    /// Write all as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,

    /// Device to use.
    #[command(flatten)]
    pub device: DeviceArgs,

    /// How the work is cut.
    #[command(flatten)]
    pub schedule: ScheduleArgs,

    /// How much to say.
    #[command(flatten)]
    pub verbosity: Verbosity,
}

//! `whitted profile`.

use super::values::{self, Size};
use super::{DeviceArgs, ScheduleArgs, Verbosity};
use crate::settings::Precision;
use clap::Args;
use std::path::PathBuf;

const PROFILE_HELP: &str = concat!(
    "\
Renders once to warm up and then N times, and tells medians and the range between the quartiles. The \
table goes to standard output, or to standard error where --json - has standard output. A trace opens \
in Perfetto or chrome://tracing. It is of one more frame, with one batch to a submit, so that the \
items of every dispatch are known; its passes are placed by the device's own timestamps.

Bytes are those that one item's structs take in the buffers that hold one element per ray, sample or \
pixel, as the pass table lists them: each read and each write once, new rays by their number. An upper \
bound, as a pass may leave an item early. The scene, counters and caches are not counted.

Examples:
  whitted profile scenes/cornell.toml
  whitted profile scenes/cornell_glass.toml --size 300x200 --repeats 9 --json profile.json
  whitted profile scenes/cornell.toml --samples 4 --trace trace.json

",
    exit_codes!()
);

/// `whitted profile`.
#[derive(Debug, Args)]
#[command(after_help = PROFILE_HELP)]
pub struct ProfileArgs {
    /// Scene text (TOML)
    pub scene: PathBuf,

    /// Renders that are timed
    #[arg(long, value_name = "N", value_parser = values::positive(), default_value_t = 5)]
    pub repeats: u32,

    /// Write all figures as JSON: the report of the run of median time, and the quartiles; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,

    /// Write one frame as Chrome trace events
    #[arg(long, value_name = "FILE.json")]
    pub trace: Option<PathBuf>,

    /// Image size in pixels [default: the scene's]
    #[arg(long, value_name = "WxH")]
    pub size: Option<Size>,

    /// Samples per pixel [default: the scene's]
    #[arg(long, value_name = "N", value_parser = values::positive())]
    pub samples: Option<u32>,

    /// Rays in the longest path; 1 = neither reflection nor refraction [default: the scene's]
    #[arg(long, value_name = "D", value_parser = values::positive())]
    pub depth: Option<u32>,

    /// Seed of the sampler
    #[arg(long, value_name = "K", default_value_t = 0)]
    pub seed: u32,

    /// Arithmetic: `fast` f32, `robust` f32 with exact rechecks, or `f64`
    #[arg(long, value_name = "WHICH", default_value = "robust")]
    pub precision: Precision,

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

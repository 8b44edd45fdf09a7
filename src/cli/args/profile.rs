//! `whitted profile`.

use super::values::{self, Size};
use super::{DeviceArgs, ReadArgs, ScheduleArgs, Verbosity};
use crate::settings::Precision;
use clap::Args;
use std::path::PathBuf;

const PROFILE_HELP: &str = "\
Renders once to warm up and then N times; prints medians and the range between the quartiles. The \
table goes to standard output, and to standard error under --json -. --trace records one more frame, \
with one batch to a submit so that the items of every dispatch are known; the file opens in Perfetto or \
chrome://tracing.

Bytes: the structs that a pass reads and writes per ray, sample and pixel, each read and each write \
counted once. An upper bound, since a pass may skip an item. Scene data, counters and caches are not \
counted.

--tests: a box test is the box of one child of a node for one ray that still looks for a hit; a packet of rays tests \
the children of each node that it enters for each of these rays. A primitive test is one triangle or sphere for one \
such ray.

Examples:
  whitted profile scenes/cornell.toml
  whitted profile scenes/cornell_glass.toml --size 300x200 --repeats 9 --json profile.json
  whitted profile scenes/cornell.toml --samples 4 --trace trace.json
  whitted profile scenes/cornell.toml --samples 4 --tests";

/// `whitted profile`.
#[derive(Debug, Args)]
#[command(after_help = super::notes(PROFILE_HELP))]
pub struct ProfileArgs {
    /// Scene text (TOML), or a model; `-` for a scene on standard input
    pub scene: PathBuf,

    /// Timed renders, after one to warm up
    #[arg(long, value_name = "N", value_parser = values::positive(), default_value_t = 5)]
    pub repeats: u32,

    /// Write JSON: the report of the run with the median time, and the quartiles; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,

    /// Write one page with picture, passes and settings, which needs no other file (HTML)
    #[arg(long, value_name = "OUT.html", value_parser = values::html())]
    pub page: Option<PathBuf>,

    /// Write one frame as Chrome trace events
    #[arg(long, value_name = "FILE.json")]
    pub trace: Option<PathBuf>,

    /// Count box and primitive tests of each kind of ray at each depth, in one more render by kernels that count
    #[arg(long)]
    pub tests: bool,

    /// Image size in pixels [default: the scene's]
    #[arg(long, value_name = "WxH", help_heading = "Picture")]
    pub size: Option<Size>,

    /// Samples per pixel [default: the scene's]
    #[arg(long, value_name = "N", value_parser = values::samples(), help_heading = "Picture")]
    pub samples: Option<u32>,

    /// Rays in the longest path; 1 = neither reflection nor refraction [default: the scene's]
    #[arg(long, value_name = "D", value_parser = values::depth(), help_heading = "Picture")]
    pub depth: Option<u32>,

    /// Seed of the sampler
    #[arg(long, value_name = "K", default_value_t = 0, help_heading = "Picture")]
    pub seed: u32,

    /// Arithmetic: `fast` f32, `robust` f32 with exact rechecks, `f64`, or `auto`: robust, or f64 where the scene needs it
    #[arg(long, value_name = "WHICH", default_value = "auto", help_heading = "Picture")]
    pub precision: Precision,

    /// How files are read.
    #[command(flatten)]
    pub read: ReadArgs,

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

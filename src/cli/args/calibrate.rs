//! `whitted calibrate`.

use super::values::{self, Size};
use super::{DeviceArgs, Verbosity};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

const CALIBRATE_HELP: &str = "\
Each image is compared with a reference in f64 whose own standard error is at most a tenth of the smallest error measured. \
The tables are Markdown. They go to standard output unless -o names a file, and to standard error under --json -. Ctrl-C \
ends the work and keeps the finished trials. A promise that was not kept appears in the tables; the command still exits \
with 0.

Examples:
  whitted calibrate
  whitted calibrate scenes/cornell.toml --only error --errors 0.02,0.01,0.005 --seeds 100
  whitted calibrate --size 300x200 --times 1,5 -o calibration.md --json calibration.json";

/// `whitted calibrate`.
#[derive(Debug, Args)]
#[command(after_help = super::notes(CALIBRATE_HELP))]
pub struct CalibrateArgs {
    /// Scene texts (TOML) [default: scenes/*.toml]
    pub scenes: Vec<PathBuf>,

    /// Trials of --budget and of --error for each scene and setting
    #[arg(long, value_name = "N", value_parser = values::positive(), default_value_t = 20)]
    pub seeds: u32,

    /// Timed runs of --time for each scene and setting
    #[arg(long, value_name = "N", value_parser = values::positive(), default_value_t = 5)]
    pub runs: u32,

    /// Samples per pixel to try --budget with, at least 2
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = values::two_or_more(), default_value = "16,64")]
    pub samples: Vec<u32>,

    /// Errors to try --error with
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = values::above_zero, default_value = "0.02,0.01")]
    pub errors: Vec<f64>,

    /// Seconds to try --time with
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = values::above_zero, default_value = "0.5")]
    pub times: Vec<f64>,

    /// Try only these promises
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub only: Vec<Promise>,

    /// Size of all images in pixels
    #[arg(long, value_name = "WxH", default_value = "96x72")]
    pub size: Size,

    /// Confidence of the promises, in (0, 1)
    #[arg(long, value_name = "P", value_parser = values::confidence, default_value_t = 0.95)]
    pub confidence: f64,

    /// Write the tables to this file instead of standard output
    #[arg(short, long, value_name = "FILE.md")]
    pub output: Option<PathBuf>,

    /// Write every trial as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,

    /// Device to use.
    #[command(flatten)]
    pub device: DeviceArgs,

    /// Messages.
    #[command(flatten)]
    pub verbosity: Verbosity,
}

/// A promise of `whitted render`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Promise {
    /// --budget: the stated error is not exceeded
    Budget,
    /// --error: the image has at most this error
    Error,
    /// --time: the image is finished in time
    Time,
}

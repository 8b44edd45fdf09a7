//! `whitted calibrate`.

use super::values::{self, Size};
use super::{DeviceArgs, ReadArgs, Verbosity};
use crate::scene::procedural::families::Family;
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use std::sync::LazyLock;

static CALIBRATE_HELP: LazyLock<String> = LazyLock::new(|| {
    let lines = Family::ALL.map(|f| format!("  {:<13} {}", f.name(), f.what()));
    HELP.replace("{FAMILIES}", &lines.join("\n"))
});

const HELP: &str = "\
Each image is compared with a reference in f64 whose own standard error is at most a tenth of the smallest error measured. \
The tables are Markdown. They go to standard output unless -o names a file. With -o FILE.md the records of all scenes go to \
FILE.jsonl beside it, one line when a scene is done; the same command goes on where an earlier one ended. A promise that was \
not kept appears in the tables; the command still exits with 0.

--families draws scenes at random: scene texts that anybody can draw anew with another --seed. --keep writes them to a \
folder; without -o nothing else is done.

Families:
{FAMILIES}

Examples:
  whitted calibrate
  whitted calibrate scenes/cornell.toml --only error --errors 0.02,0.01,0.005 --seeds 100
  whitted calibrate --size 300x200 --times 1,5 -o calibration.md
  whitted calibrate --families all --scenes 10 --seeds 4 --seed 2026 -o families.md --page families.html
  whitted calibrate --families wires,dim:3 --keep out/scenes";

/// `whitted calibrate`.
#[derive(Debug, Args)]
#[command(after_help = super::notes(&CALIBRATE_HELP))]
pub struct CalibrateArgs {
    /// Scene texts (TOML) [default: scenes/*.toml; none with --families]
    pub scenes: Vec<PathBuf>,

    /// Draw scenes from these families: `all`, or names separated by commas; `wires:3` is one scene
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub families: Vec<String>,

    /// Scenes to draw from each family
    #[arg(long = "scenes", value_name = "N", value_parser = values::positive(), default_value_t = 10, requires = "families")]
    pub draws: u32,

    /// Seed that scenes are drawn with
    #[arg(long, value_name = "S", default_value_t = 1, requires = "families")]
    pub seed: u64,

    /// Most rays for the truth of a scene
    #[arg(long, value_name = "N", value_parser = values::above_zero, default_value_t = 5e6)]
    pub truth_rays: f64,

    /// Write the drawn scenes to this folder
    #[arg(long, value_name = "DIR", requires = "families")]
    pub keep: Option<PathBuf>,

    /// Write a page with plots as well
    #[arg(long, value_name = "FILE.html", requires = "output")]
    pub page: Option<PathBuf>,

    /// Trials of each promise for each scene and setting
    #[arg(long, value_name = "N", value_parser = values::positive(), default_value_t = 4)]
    pub seeds: u32,

    /// Samples per pixel to try --budget with, at least 2 [default: 4,16,64]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = values::two_or_more())]
    pub samples: Vec<u32>,

    /// Errors to try --error with [default: 0.01,0.003]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = values::above_zero)]
    pub errors: Vec<f64>,

    /// Seconds to try --time with [default: none; with --only time 0.5]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = values::above_zero)]
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

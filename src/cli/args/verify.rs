//! `whitted verify`.

use super::{DeviceArgs, Verbosity, values};
use clap::Args;
use std::path::PathBuf;

const VERIFY_HELP: &str = "\
Draws again what a report, or a picture's metadata, describes, on this machine's device, and compares it with the hash in the report and with the \
picture. On the same device and driver every bit must be the same. On another one the pictures may differ by rounding: \
the bound on that comes from drawing the same samples in f64 here. What differs otherwise is listed pixel by pixel.

Pictures of --error and --time cannot be drawn again from their report, since their samples were chosen pixel by pixel.

Examples:
  whitted render scenes/cornell.toml -o a.exr --report a.json
  whitted verify a.json
  whitted verify a.exr
  whitted verify a.json --picture copies/a.exr --diff wrong.png";

/// `whitted verify`.
#[derive(Debug, Args)]
#[command(after_help = super::notes(VERIFY_HELP))]
pub struct VerifyArgs {
    /// Report of `whitted render` or `whitted merge` (JSON), or a picture with metadata: PNG, EXR, HDR or PPM
    #[arg(value_name = "REPORT.json")]
    pub report: PathBuf,

    /// Scene text (TOML) [default: the report's]
    #[arg(long, value_name = "FILE")]
    pub scene: Option<PathBuf>,

    /// Picture to look at [default: the report's, if it is there]
    #[arg(long, value_name = "FILE")]
    pub picture: Option<PathBuf>,

    /// Write the difference of each pixel in false colours, if there are any
    #[arg(long, value_name = "OUT.png", value_parser = values::png())]
    pub diff: Option<PathBuf>,

    /// Device to use.
    #[command(flatten)]
    pub device: DeviceArgs,

    /// Messages.
    #[command(flatten)]
    pub verbosity: Verbosity,
}

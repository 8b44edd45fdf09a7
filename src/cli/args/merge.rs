//! `whitted merge`.

use super::{Verbosity, values};
use crate::image::Format;
use clap::Args;
use std::path::PathBuf;

const MERGE_HELP: &str = "\
Shares of one render, in any order, become the picture with the bytes that one render would have written, and a report \
with the same counts; its times are the sums of the shares' times. Shares of other scenes, settings, programs or drivers \
are refused, missing ones are named, and each can be rendered anew by itself.

Examples:
  whitted render scenes/cornell.toml --share 1/2 -o 1.share
  whitted render scenes/cornell.toml --share 2/2 -o 2.share
  whitted merge 1.share 2.share -o cornell.exr --report cornell.json";

/// `whitted merge`.
#[derive(Debug, Args)]
#[command(after_help = super::notes(MERGE_HELP))]
pub struct MergeArgs {
    /// Files that `whitted render --share` wrote, all shares of a picture
    #[arg(required = true, value_name = "SHARE")]
    pub shares: Vec<PathBuf>,

    /// Image to write: .png, .exr or .hdr
    #[arg(short, long, value_name = "FILE", value_parser = values::image(), help_heading = "Output")]
    pub output: (PathBuf, Format),

    /// Bits per channel of a PNG [default: 8]
    #[arg(long, value_parser = ["8", "16"], help_heading = "Output")]
    pub bits: Option<String>,

    /// Write times, rays and settings as JSON
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub report: Option<PathBuf>,

    /// Also write OUT.state, from which `render --continue` adds samples
    #[arg(long, help_heading = "Output")]
    pub keep_state: bool,

    /// Join shares of different devices, whose bits may differ; the picture's metadata and the report say so
    #[arg(long)]
    pub mixed_devices: bool,

    /// Messages.
    #[command(flatten)]
    pub verbosity: Verbosity,
}

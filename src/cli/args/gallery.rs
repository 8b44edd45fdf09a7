//! `whitted gallery`.

use super::values;
use super::{DeviceArgs, Verbosity};
use clap::Args;
use std::path::PathBuf;

const GALLERY_HELP: &str = "\
Pictures:
  samples_01, _02, _04, _10   1 to 10 samples per pixel, at the scene's depth
  depth_1 to depth_4          1 to 4 rays in the longest path, at up to 4 samples per pixel
  depth_STEM_1 to _4          the same of the sibling
  final_STEM                  the scene at its own settings; also its sibling, if there is one:
                              STEM_glass.toml beside STEM.toml, or the other way round
  contact_sheet.png           all of them, with samples, depth, time and rays
  gallery.json                the report of each

Samples are independent (`--sampler random` of `whitted render`), so that counts are compared and nothing else.

Example:
  whitted gallery scenes/cornell.toml -o out/gallery";

/// `whitted gallery`.
#[derive(Debug, Args)]
#[command(after_help = GALLERY_HELP)]
pub struct GalleryArgs {
    /// Scene text (TOML)
    pub scene: PathBuf,

    /// Folder to write to; made if it is not there
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,

    /// Factor on the width and height of every picture, in (0, 1]
    #[arg(long, value_name = "S", default_value_t = 1.0, value_parser = values::scale)]
    pub scale: f64,

    /// Seed of the sampler
    #[arg(long, value_name = "K", default_value_t = 0)]
    pub seed: u32,

    /// Device to use.
    #[command(flatten)]
    pub device: DeviceArgs,

    /// How much to say.
    #[command(flatten)]
    pub verbosity: Verbosity,
}

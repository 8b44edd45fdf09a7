//! `whitted gallery`.

use super::values;
use super::{DeviceArgs, ReadArgs, Verbosity};
use clap::Args;
use std::path::PathBuf;

const GALLERY_HELP: &str = "\
Pictures:
  samples_01, _02, _04, _10   1 to 10 samples per pixel, at the scene's depth
  depth_1 to depth_4          1 to 4 rays in the longest path, at up to 4 samples per pixel
  depth_STEM_1 to _4          the same for the sibling scene
  final_STEM                  the scene at its own settings, and its sibling if there is one:
                              STEM_glass.toml beside STEM.toml, or the reverse
  contact_sheet.png           all pictures, with samples, depth, time and rays, and enlarged below each
                              the parts in which neighbours in its row differ most
  gallery.json                the report of each picture

Samples are independent (as with `whitted render --sampler random`), so only the counts differ.

Example:
  whitted gallery scenes/cornell.toml -o out/gallery";

/// `whitted gallery`.
#[derive(Debug, Args)]
#[command(after_help = super::notes(GALLERY_HELP))]
pub struct GalleryArgs {
    /// Scene text (TOML), or a model; `-` for a scene on standard input
    pub scene: PathBuf,

    /// Folder to write to; created if missing
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,

    /// Factor on the width and height of every picture, in (0, 1]
    #[arg(long, value_name = "S", default_value_t = 1.0, value_parser = values::scale)]
    pub scale: f64,

    /// Seed of the sampler
    #[arg(long, value_name = "K", default_value_t = 0)]
    pub seed: u32,

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

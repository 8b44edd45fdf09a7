//! `whitted import`.

use super::values::Size;
use crate::scene::Axis;
use clap::Args;
use std::path::PathBuf;

const IMPORT_HELP: &str = "\
The scene has the file's own camera and lights; where it has none, a camera that sees all of the model and two lights. It \
renders to the same picture as the model itself.

Examples:
  whitted import model.obj -o scene.toml
  whitted import model.obj -o - --size 800x600";

/// `whitted import`.
#[derive(Debug, Args)]
#[command(after_help = super::notes(IMPORT_HELP))]
pub struct ImportArgs {
    /// Model
    pub model: PathBuf,

    /// Scene to write (TOML); `-` for standard output
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,

    /// Image size in pixels that the model is framed for [default: that of the file's camera, or 600x500]
    #[arg(long, value_name = "WxH")]
    pub size: Option<Size>,

    /// What points up in the model: x, y, z, -x, -y or -z; its own camera is then left out [default: z in PLY, STL and NFF, else y]
    #[arg(long, value_name = "AXIS", allow_hyphen_values = true)]
    pub up: Option<Axis>,

    /// Refuse what the file leaves open or gets wrong, instead of saying what is assumed
    #[arg(long)]
    pub strict: bool,

    /// Print only errors
    #[arg(short, long)]
    pub quiet: bool,
}

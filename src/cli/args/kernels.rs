//! `whitted kernels`.

use super::{DeviceArgs, PictureArgs, ReadArgs, ScheduleArgs, Verbosity};
use clap::Args;
use std::path::PathBuf;

const KERNELS_HELP: &str = "\
Compiles what a render of the scene would run and prints what the driver says of it: registers, spills, scratch memory, \
waves at a time, code size, estimates. Names and units are the driver's. Kernels marked `in parts` run only where a walk \
takes longer than one dispatch. Nothing is rendered, so the hardware may be absent: Mesa's RADV compiles for any GPU that \
RADV_FORCE_FAMILY names.

Examples:
  whitted kernels scenes/mesh_glass.toml
  whitted kernels scenes/mesh_glass.toml --precision f64 --json kernels.json
  whitted kernels scenes/cornell.toml --isa > cornell.s
  RADV_FORCE_FAMILY=navi21 whitted kernels scenes/cornell.toml --device navi21";

/// `whitted kernels`.
#[derive(Debug, Args)]
#[command(after_help = super::notes(KERNELS_HELP))]
pub struct KernelsArgs {
    /// Scene text (TOML), or a model; `-` for a scene on standard input
    pub scene: PathBuf,

    /// Size, samples, depth and the like.
    #[command(flatten)]
    pub picture: PictureArgs,

    /// Print the code as well: what the driver gives, down to the machine's
    #[arg(long)]
    pub isa: bool,

    /// Write it as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,

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

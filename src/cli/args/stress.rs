//! `whitted stress`.

use super::{DeviceArgs, Verbosity};
use crate::settings::Precision;
use clap::Args;
use std::path::PathBuf;

const STRESS_HELP: &str = "\
Each case measures one figure and compares it with a bound that docs/numerics.md derives. A case above its \
bound exits with 1.

Examples:
  whitted stress
  whitted stress --only watertight --only horizon --precision fast
  whitted stress --report stress.json
  whitted stress --page extremes.md";

/// `whitted stress`.
#[derive(Debug, Args)]
#[command(after_help = super::notes(STRESS_HELP))]
pub struct StressArgs {
    /// Run only this case; may be repeated
    #[arg(long, value_name = "NAME")]
    pub only: Vec<String>,

    /// List the cases
    #[arg(long)]
    pub list: bool,

    /// Arithmetic: `fast`, `robust` or `f64`
    #[arg(long, value_name = "WHICH", default_value = "robust")]
    pub precision: Precision,

    /// Write figures, bounds and verdicts as JSON
    #[arg(long, value_name = "FILE")]
    pub report: Option<PathBuf>,

    /// Also measure a fixed epsilon, f32 against f64, and the cost of each protection; write all as Markdown with plots beside it
    #[arg(long, value_name = "FILE.md")]
    pub page: Option<PathBuf>,

    /// Run under the Vulkan validation layer; any message is a failure
    #[arg(long, help_heading = "Device")]
    pub validate: bool,

    /// Device to use.
    #[command(flatten)]
    pub device: DeviceArgs,

    /// Messages.
    #[command(flatten)]
    pub verbosity: Verbosity,
}

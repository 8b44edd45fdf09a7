//! `whitted stress`.

use super::{DeviceArgs, Verbosity};
use crate::settings::Precision;
use clap::Args;
use std::path::PathBuf;

/// `whitted stress`.
#[derive(Debug, Args)]
pub struct StressArgs {
    /// Run only these cases
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

    /// Measure more (a fixed epsilon, f32 against f64, the cost of protections) and write all as a page of Markdown with pictures beside it
    #[arg(long, value_name = "FILE.md")]
    pub page: Option<PathBuf>,

    /// Run under the Vulkan validation layer; any message is a failure
    #[arg(long)]
    pub validate: bool,

    /// Device to use.
    #[command(flatten)]
    pub device: DeviceArgs,

    /// How much to say.
    #[command(flatten)]
    pub verbosity: Verbosity,
}

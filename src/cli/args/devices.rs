//! `whitted devices`.

use clap::Args;

const DEVICES_HELP: &str = "\
Choose a device with --device or the environment variable WHITTED_DEVICE: by index, UUID, part of the \
name, or `cpu` for the first software device.

Examples:
  whitted devices
  whitted devices --json
  WHITTED_DEVICE=cpu whitted render scenes/cornell.toml -o cornell.png";

/// `whitted devices`.
#[derive(Debug, Args)]
#[command(after_help = super::notes(DEVICES_HELP))]
pub struct DevicesArgs {
    /// Print a JSON array
    #[arg(long)]
    pub json: bool,
}

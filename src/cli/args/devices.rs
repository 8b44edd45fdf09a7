//! `whitted devices`.

use clap::Args;

const DEVICES_HELP: &str = "\
Any of index, UUID, part of the name, or `cpu` (the first software device) is good for --device and \
for the environment variable WHITTED_DEVICE.";

/// `whitted devices`.
#[derive(Debug, Args)]
#[command(after_help = DEVICES_HELP)]
pub struct DevicesArgs {
    /// As a JSON array on standard output
    #[arg(long)]
    pub json: bool,
}

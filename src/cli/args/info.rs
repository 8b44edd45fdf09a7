//! `whitted info`.

use super::ReadArgs;
use clap::Args;
use std::path::PathBuf;

const INFO_HELP: &str = "\
The table goes to standard output, and to standard error under --json -.

Examples:
  whitted info model.obj
  whitted info scenes/cornell.toml --json -
  whitted info cornell.png";

/// `whitted info`.
#[derive(Debug, Args)]
#[command(after_help = super::notes(INFO_HELP))]
pub struct InfoArgs {
    /// Scene, model or picture; `-` for a scene on standard input
    pub file: PathBuf,

    /// Write all figures as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,

    /// How files are read.
    #[command(flatten)]
    pub read: ReadArgs,

    /// Print only errors
    #[arg(short, long)]
    pub quiet: bool,
}

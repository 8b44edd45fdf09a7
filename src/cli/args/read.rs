//! How scene files are read.

use crate::scene::ReadOptions;
use clap::Args;

/// How a scene and the files that it names are read.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Reading")]
pub struct ReadArgs {
    /// Refuse what files leave open or get wrong, instead of saying what is assumed
    #[arg(long)]
    pub strict: bool,
}

impl ReadArgs {
    /// As the reader takes them.
    pub fn options(&self) -> ReadOptions {
        ReadOptions { strict: self.strict }
    }
}

//! `whitted completions` and `whitted man`.

use clap::Args;
use clap_complete::Shell;
use std::path::PathBuf;

const COMPLETIONS_HELP: &str = "\
Examples:
  whitted completions bash > ~/.local/share/bash-completion/completions/whitted
  whitted completions zsh > ~/.zfunc/_whitted
  whitted completions fish > ~/.config/fish/completions/whitted.fish";

const MAN_HELP: &str = "\
Examples:
  whitted man | man -l -
  whitted man -o ~/.local/share/man/man1";

/// `whitted completions`.
#[derive(Debug, Args)]
#[command(after_help = super::notes(COMPLETIONS_HELP))]
pub struct CompletionsArgs {
    /// Shell that will read the script
    pub shell: Shell,
}

/// `whitted man`.
#[derive(Debug, Args)]
#[command(after_help = super::notes(MAN_HELP))]
pub struct ManArgs {
    /// Write the pages of all commands to this folder; created if missing
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

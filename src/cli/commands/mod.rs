//! What the commands do. Standard output gets images and listings only; all else goes to standard error.

mod bounded_image;
mod frames;
pub mod calibrate;
pub mod compare;
pub mod devices;
pub mod gallery;
pub mod generate;
pub mod import;
pub mod info;
pub mod kernels;
mod manual;
pub mod merge;
mod reference;
pub mod render;
pub mod plan;
pub mod profile;
pub mod stress;
pub mod sweep;
pub mod verify;

use crate::cli::args::{Cli, Command, Verbosity};
use crate::cli::console::Console;
use crate::cli::failure::Failure;
use std::time::Instant;

/// Runs one command; `started` is when the process did.
pub fn run(cli: &Cli, started: Instant) -> Result<(), Failure> {
    match &cli.command {
        Command::Render(args) => render::run(args, started, &mut Console::new(args.verbosity)),
        Command::Merge(args) => merge::run(args, started, &mut Console::new(args.verbosity)),
        Command::Verify(args) => verify::run(args, &mut Console::new(args.verbosity)),
        Command::Devices(args) => devices::run(args),
        Command::Gallery(args) => gallery::run(args, started, &mut Console::new(args.verbosity)),
        Command::Import(args) => {
            import::run(args, &mut Console::new(Verbosity { quiet: args.quiet, verbose: false }))
        }
        Command::Info(args) => {
            info::run(args, &mut Console::new(Verbosity { quiet: args.quiet, verbose: false }))
        }
        Command::Kernels(args) => kernels::run(args, &mut Console::new(args.verbosity)),
        Command::Plan(args) => plan::run(args, &mut Console::new(args.verbosity)),
        Command::Profile(args) => profile::run(args, started, &mut Console::new(args.verbosity)),
        Command::Generate(shape) => generate::run(shape),
        Command::Sweep(args) => sweep::run(args, &mut Console::new(args.verbosity)),
        Command::Compare(args) => {
            compare::run(args, &mut Console::new(Verbosity { quiet: args.quiet, verbose: false }))
        }
        Command::Calibrate(args) => calibrate::run(args, &mut Console::new(args.verbosity)),
        Command::Completions(args) => manual::completions(args),
        Command::Man(args) => manual::man(args),
        Command::Stress(args) => stress::run(args, &mut Console::new(args.verbosity)),
    }
}

/// The command line as it was given.
pub(super) fn command_line() -> String {
    let quoted = |word: String| if word.contains(' ') { format!("'{word}'") } else { word };
    // Names of files need not be UTF-8.
    let words = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned());
    std::iter::once("whitted".to_owned()).chain(words.map(quoted)).collect::<Vec<_>>().join(" ")
}

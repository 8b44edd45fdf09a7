//! The command line: arguments, commands, delivery of files, progress, exit codes.

pub mod args;
pub mod commands;
pub mod console;
mod delivery;
pub mod failure;
pub(crate) mod progress;
mod read;
mod state;

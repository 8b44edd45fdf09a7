//! The command line: arguments, commands, delivery of files, progress, exit codes.

pub mod args;
pub mod commands;
pub mod console;
mod delivery;
pub mod failure;
mod files;
pub(crate) mod progress;
mod read;
mod state;
mod surfaces;
pub mod threads;

//! The command line: parse, run, map the error to an exit code.

use clap::Parser;
use std::io::{self, Write};
use std::process::ExitCode;
use std::time::Instant;
use whitted::cli::args::Cli;
use whitted::cli::commands;
use whitted::cli::failure::Failure;

fn main() -> ExitCode {
    let started = Instant::now();
    whitted::vk::environment::prepare();
    match commands::run(&Cli::parse(), started) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            // A closed standard error leaves the exit code to tell.
            let _ = match &failure {
                Failure::Interrupted(_) | Failure::AboveThreshold(_) => {
                    writeln!(io::stderr(), "{}", failure.message())
                }
                _ => writeln!(io::stderr(), "error: {}", failure.message()),
            };
            ExitCode::from(failure.exit_code())
        }
    }
}

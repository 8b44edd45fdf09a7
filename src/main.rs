//! The command line: parse, run, map the error to an exit code.

use clap::Parser;
use std::io::{self, Write};
use std::process::ExitCode;
use std::time::Instant;
use whitted::cli::args::Cli;
use whitted::cli::commands;
use whitted::cli::failure::Failure;
use whitted::cli::threads;

fn main() -> ExitCode {
    let started = Instant::now();
    let cli = Cli::parse();
    threads::start();
    match commands::run(&cli, started) {
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

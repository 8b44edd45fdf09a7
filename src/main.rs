//! The command line: parse, run, map the error to an exit code.

use clap::Parser;
use std::io::{self, Write};
use std::process::ExitCode;
use std::time::Instant;
use whitted::cli::args::Cli;
use whitted::cli::commands;
use whitted::cli::failure::Code;
use whitted::vk;

fn main() -> ExitCode {
    let started = Instant::now();
    vk::environment::prepare();
    let code = match commands::run(&Cli::parse(), started) {
        Ok(()) => Code::Done,
        Err(failure) => {
            // Whatever fails after a driver was left fails for the interrupt.
            let code = if vk::is_abandoned() { Code::Interrupted } else { failure.code() };
            // A closed standard error leaves the exit code to tell.
            let _ = match code {
                Code::Interrupted | Code::AboveThreshold => writeln!(io::stderr(), "{}", failure.message()),
                _ => writeln!(io::stderr(), "error: {}", failure.message()),
            };
            code
        }
    };
    if vk::is_abandoned() {
        // A closed standard output leaves the exit code to tell.
        let _ = io::stdout().flush();
        vk::end(code as u8);
    }
    ExitCode::from(code as u8)
}

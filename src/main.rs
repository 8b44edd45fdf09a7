//! The command line: parse, run, map the error to an exit code.

use clap::Parser;
use std::io::{self, Write};
use std::process::ExitCode;
use std::thread;
use std::time::Instant;
use whitted::cli::args::Cli;
use whitted::cli::commands;
use whitted::cli::failure::Code;
use whitted::cli::threads;
use whitted::vk;

/// Bytes of stack for the program's work, whatever `ulimit -s` leaves the first thread: what systems usually give.
const STACK: usize = 8 << 20;
/// Exit code of a panic.
const PANICKED: u8 = 101;

fn main() -> ExitCode {
    let started = Instant::now();
    vk::environment::prepare();
    match thread::Builder::new().name("whitted".into()).stack_size(STACK).spawn(move || run(started)) {
        Ok(work) => work.join().unwrap_or(ExitCode::from(PANICKED)),
        // Not one thread may be started.
        Err(_) => run(started),
    }
}

fn run(started: Instant) -> ExitCode {
    let cli = Cli::parse();
    threads::start();
    let code = match commands::run(&cli, started) {
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

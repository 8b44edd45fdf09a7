//! Listings on standard output, messages on standard error. A closed pipe there is no reason to stop, so
//! writing messages cannot fail.

use super::failure::Failure;
use crate::cli::args::Verbosity;
use anyhow::Context;
use std::io::{self, Write};

/// Writes a listing to standard output; a reader who has seen enough (`| head -1`) is no error.
pub fn print(text: &str) -> Result<(), Failure> {
    match io::stdout().lock().write_all(text.as_bytes()) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => Ok(other.context("cannot write to standard output")?),
    }
}

/// How much to say, and where.
pub struct Console {
    err: Box<dyn Write>,
    quiet: bool,
    verbose: bool,
}

impl Console {
    /// Messages to standard error.
    pub fn new(verbosity: Verbosity) -> Console {
        Console::on(Box::new(io::stderr()), verbosity)
    }

    /// Messages to any writer.
    pub fn on(err: Box<dyn Write>, Verbosity { quiet, verbose }: Verbosity) -> Console {
        Console { err, quiet, verbose }
    }

    /// True with `-q`.
    pub fn is_quiet(&self) -> bool {
        self.quiet
    }

    /// True with `-v`.
    pub fn is_verbose(&self) -> bool {
        self.verbose
    }

    /// A line for everyone but `-q`.
    pub fn say(&mut self, text: &str) {
        if !self.quiet {
            self.error(text);
        }
    }

    /// A line even with `-q`.
    pub fn error(&mut self, text: &str) {
        let _ = writeln!(self.err, "{}", text.trim_end_matches('\n'));
    }
}

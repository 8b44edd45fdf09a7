//! Listings on standard output, messages on standard error. A closed pipe there is no reason to stop, so
//! writing messages cannot fail.

use super::failure::Failure;
use crate::cli::args::Verbosity;
use anyhow::Context;
use std::io::{self, Write};

/// Writes a listing to standard output; a reader who has seen enough (`| head -1`) is no error.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => Ok(other.context("cannot write to standard output")?),
    }
}

/// True if standard output was closed when the process began. Rust's runtime then opens the null device in its place,
/// for reading and writing, and all that is written would be lost without a word. `> /dev/null` opens it for writing
/// alone.
#[cfg(unix)]
pub(super) fn is_closed() -> bool {
    use rustix::fs::{OFlags, fcntl_getfl, fstat, stat};
    let out = io::stdout();
    let is_null = match (fstat(&out), stat("/dev/null")) {
        (Ok(out), Ok(null)) => (out.st_rdev, out.st_mode) == (null.st_rdev, null.st_mode),
        // It is closed indeed.
        (Err(_), _) => return true,
        _ => false,
    };
    is_null && fcntl_getfl(&out).is_ok_and(|flags| flags & OFlags::RWMODE == OFlags::RDWR)
}

/// True if there is no standard output.
#[cfg(not(unix))]
pub(super) fn is_closed() -> bool {
    false
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

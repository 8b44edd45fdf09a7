//! Progress on standard error, and Ctrl-C.

use crate::cli::failure::Code;
use crate::render::Observer;
use anyhow::{Context, Result};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{self, IsTerminal, Write};
use std::str::FromStr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

static STOP: AtomicBool = AtomicBool::new(false);

/// Makes the first Ctrl-C (or SIGTERM, SIGHUP) ask the render to stop, and the second end the process.
/// Once per process.
pub fn catch_interrupts() -> Result<()> {
    ctrlc::set_handler(|| {
        if STOP.swap(true, Ordering::SeqCst) {
            std::process::exit(Code::Interrupted as i32);
        }
        // Standard error may be gone; stopping matters more than saying so.
        let _ = writeln!(
            io::stderr(),
            "\nstopping after the work in flight; press Ctrl-C again to end at once and save nothing"
        );
    })
    .context("cannot watch for Ctrl-C")
}

/// True after a Ctrl-C.
pub fn interrupted() -> bool {
    STOP.load(Ordering::SeqCst)
}

/// How progress is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Style {
    /// Not at all.
    Hidden,
    /// A bar that redraws itself.
    Bar,
    /// One plain line a second at most.
    Lines,
    /// The same as JSON objects.
    Json,
    /// Messages of Open Job Description, on standard output.
    OpenJd,
}

impl FromStr for Style {
    type Err = String;

    fn from_str(text: &str) -> Result<Style, String> {
        Ok(match text {
            "bar" => Style::Bar,
            "plain" => Style::Lines,
            "json" => Style::Json,
            "openjd" => Style::OpenJd,
            "none" => Style::Hidden,
            _ => return Err("write bar, plain, json, openjd or none".into()),
        })
    }
}

impl Style {
    /// A bar on a terminal; elsewhere lines, if asked for.
    pub fn choose(quiet: bool, verbose: bool) -> Style {
        match (quiet, io::stderr().is_terminal(), verbose) {
            (true, _, _) | (false, false, false) => Style::Hidden,
            (false, true, _) => Style::Bar,
            (false, false, true) => Style::Lines,
        }
    }
}

/// Shows one render's progress; stops it on Ctrl-C.
pub struct Progress {
    style: Style,
    bar: ProgressBar,
    label: String,
    spoke: Instant,
}

impl Progress {
    /// `label` says what is rendered.
    pub fn new(style: Style, label: &str) -> Progress {
        let bar = match style {
            Style::Bar => ProgressBar::with_draw_target(Some(1), ProgressDrawTarget::stderr()),
            Style::Hidden | Style::Lines | Style::Json | Style::OpenJd => ProgressBar::hidden(),
        };
        if let Ok(look) = ProgressStyle::with_template("{msg} [{bar:40}] {percent:>3}% {elapsed}, {eta} left")
        {
            bar.set_style(look.progress_chars("=> "));
        }
        bar.set_message(label.to_owned());
        Progress { style, bar, label: label.to_owned(), spoke: Instant::now() }
    }
}

impl Observer for Progress {
    fn progress(&mut self, done: u64, total: u64) {
        self.bar.set_length(total);
        self.bar.set_position(done);
        let lines = matches!(self.style, Style::Lines | Style::Json | Style::OpenJd);
        // Readers of messages wait for the last one.
        let last = done == total && self.style != Style::Lines;
        if lines && (last || self.spoke.elapsed() >= Duration::from_secs(1)) {
            self.spoke = Instant::now();
            // A closed stream must not end the render.
            let _ = match self.style {
                Style::Json => writeln!(io::stderr(), "{}", json(&self.label, done, total)),
                Style::OpenJd => writeln!(io::stdout(), "{}", openjd(done, total)),
                _ => writeln!(io::stderr(), "{}", line(&self.label, done, total)),
            };
        }
    }

    fn cancelled(&self) -> bool {
        interrupted()
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

fn line(label: &str, done: u64, total: u64) -> String {
    format!("{label}: {:.1} %", 100.0 * done as f64 / total.max(1) as f64)
}

/// Share that is done.
fn share(done: u64, total: u64) -> f64 {
    (done as f64 / total.max(1) as f64).min(1.0)
}

/// An object with what is rendered, and how much of it is done: of `total` units of work, and of 1.
fn json(label: &str, done: u64, total: u64) -> serde_json::Value {
    serde_json::json!({ "progress": share(done, total), "done": done, "total": total, "label": label })
}

/// Percent, as Open Job Description reads it from a task's output ("How Jobs Are Run", 2023-09).
fn openjd(done: u64, total: u64) -> String {
    format!("openjd_progress: {:.1}", 100.0 * share(done, total))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_say_the_share() {
        assert_eq!(line("cornell", 1, 8), "cornell: 12.5 %");
        assert_eq!(line("cornell", 0, 0), "cornell: 0.0 %");
    }

    #[test]
    fn messages_for_programs() {
        let object = json("a \"b\"", 1, 8).to_string();
        let read: serde_json::Value = serde_json::from_str(&object).unwrap();
        assert_eq!((&read["progress"], &read["label"]), (&0.125.into(), &"a \"b\"".into()));
        assert_eq!(
            (openjd(1, 8), openjd(9, 8)),
            ("openjd_progress: 12.5".into(), "openjd_progress: 100.0".into())
        );
        assert_eq!("openjd".parse(), Ok(Style::OpenJd));
        assert!("loud".parse::<Style>().is_err());
    }

    #[test]
    fn quiet_hides_everything() {
        assert_eq!(Style::choose(true, false), Style::Hidden);
    }
}

//! Progress on standard error, and Ctrl-C.

use crate::cli::failure::Code;
use crate::cli::threads;
use crate::render::Observer;
use crate::vk::{self, Watch};
use anyhow::{Context, Result};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{self, IsTerminal, Write};
use std::str::FromStr;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// When the first signal came.
static STOPPED: OnceLock<Instant> = OnceLock::new();
/// True once the work has seen the signal: it ends by itself.
static SEEN: AtomicBool = AtomicBool::new(false);
/// True once there are results to save.
static WORKED: AtomicBool = AtomicBool::new(false);

/// Signals that come within this time of the first are the same request: `timeout` signals the process and then its
/// group, and a shell's Ctrl-C reaches a process and whoever started it, who passes it on.
const SAME: Duration = Duration::from_secs(1);
/// Time in which work without results must see a signal. Reading, building and compiling look for none.
const DEAF: Duration = Duration::from_millis(1500);

/// What a signal asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Request {
    /// To stop and save.
    Stop,
    /// Nothing new.
    Same,
    /// To end at once.
    End,
}

/// What a signal asks for that comes so long after the first; None for the first.
fn request(since_first: Option<Duration>) -> Request {
    match since_first {
        None => Request::Stop,
        Some(time) if time < SAME => Request::Same,
        Some(_) => Request::End,
    }
}

/// To be called before a device is opened. Makes the first Ctrl-C (or SIGTERM, SIGHUP) ask the render to stop, and one that comes later end the process. Once
/// per process.
pub fn catch_interrupts() -> Result<()> {
    threads::check()?;
    vk::watch(Watch { stopped: interrupted, long: tell_of_wait });
    ctrlc::set_handler(|| match request(STOPPED.get().map(Instant::elapsed)) {
        Request::Same => {}
        Request::End => end("ended at once; nothing more was saved"),
        Request::Stop => {
            STOPPED.get_or_init(Instant::now);
            // Standard error may be gone; stopping matters more than saying so.
            let _ = writeln!(
                io::stderr(),
                "\nstopping after the work in flight; press Ctrl-C again to end at once and save nothing"
            );
            // Without a thread to spare the work is waited for.
            let _ = thread::Builder::new().spawn(|| {
                thread::sleep(DEAF);
                if !SEEN.load(Ordering::SeqCst) && !WORKED.load(Ordering::SeqCst) {
                    end("interrupted before the first pixel; nothing was written");
                }
            });
        }
    })
    .context("cannot watch for Ctrl-C, which needs a thread")
}

fn end(why: &str) {
    let _ = writeln!(io::stderr(), "{why}");
    vk::end(Code::Interrupted as u8);
}

/// True after a Ctrl-C.
pub fn interrupted() -> bool {
    let stopped = STOPPED.get().is_some();
    if stopped {
        SEEN.store(true, Ordering::SeqCst);
    }
    stopped
}

/// What is on standard error now.
struct Shown {
    style: Style,
    bar: Option<ProgressBar>,
}

static SHOWN: Mutex<Shown> = Mutex::new(Shown { style: Style::Hidden, bar: None });

/// Says what a driver has been at for a long time: most often a kernel that it compiles.
fn tell_of_wait(at: &str, waited: Duration) {
    let shown = SHOWN.lock().unwrap_or_else(PoisonError::into_inner);
    let text = format!("the driver has been at {at} for {} s", waited.as_secs());
    match (&shown.bar, shown.style) {
        (Some(bar), Style::Bar) => bar.println(text),
        (_, Style::Hidden) => {}
        // A closed standard error must not end the render.
        _ => drop(writeln!(io::stderr(), "{text}")),
    }
}

fn show(bar: Option<ProgressBar>) {
    SHOWN.lock().unwrap_or_else(PoisonError::into_inner).bar = bar;
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
        let style = match (quiet, io::stderr().is_terminal(), verbose) {
            (true, _, _) | (false, false, false) => Style::Hidden,
            (false, true, _) => Style::Bar,
            (false, false, true) => Style::Lines,
        };
        SHOWN.lock().unwrap_or_else(PoisonError::into_inner).style = style;
        style
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
        show(Some(bar.clone()));
        Progress { style, bar, label: label.to_owned(), spoke: Instant::now() }
    }
}

impl Observer for Progress {
    fn progress(&mut self, done: u64, total: u64) {
        WORKED.store(true, Ordering::SeqCst);
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
        show(None);
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
    fn a_signal_at_once_is_the_same_one() {
        let after = |seconds| request(Some(Duration::from_secs_f64(seconds)));
        assert_eq!((request(None), after(0.0), after(0.9)), (Request::Stop, Request::Same, Request::Same));
        assert_eq!((after(1.1), after(60.0)), (Request::End, Request::End));
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

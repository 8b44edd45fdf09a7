//! The state files next to an image: `OUT.partial`, of a render on its way, and `OUT.state`, of a finished one.

use super::console::Console;
use super::failure::Failure;
use crate::atomic_file;
use crate::render::{
    Checkpoints, Observer, Payload, RenderError, ResumeState, State, Sums, Write as WriteState,
};
use crate::report::Report;
use anyhow::{Context, anyhow};
use std::fmt::Display;
use std::fs::{self, File};
use std::io::{self, BufReader, Write};
use std::path::{Path, PathBuf};

/// Reads a state of any kind of render.
fn read<P: Payload>(path: &Path) -> io::Result<ResumeState<P>> {
    File::open(path).and_then(|file| ResumeState::read(&mut BufReader::new(file)))
}

/// A state file, which need not exist.
pub(super) struct StateFile {
    /// Where `--resume` looks: `OUT.partial`.
    path: PathBuf,
    /// Where this render writes: `path`, or beside it if that holds an unfinished render that this one does not
    /// continue.
    to: PathBuf,
}

impl StateFile {
    /// The state file of an image file, for a render that continues what is there or starts anew.
    pub(super) fn of(image: &Path, resume: bool) -> StateFile {
        let path = named(image, ".partial");
        let to = match resume || !exists(&path) {
            true => path.clone(),
            false => free(image),
        };
        StateFile { path, to }
    }

    /// The file that this render may write.
    pub(super) fn to(&self) -> &Path {
        &self.to
    }

    /// True if there is an unfinished render.
    pub(super) fn exists(&self) -> bool {
        exists(&self.path)
    }

    /// The stored state if `resume` is set; otherwise only warns if there is one.
    pub(super) fn earlier<P: Payload>(
        &self,
        resume: bool,
        console: &mut Console,
    ) -> Result<Option<ResumeState<P>>, Failure> {
        let name = self.path.display();
        match (exists(&self.path), resume) {
            (true, true) => Ok(Some(read(&self.path).map_err(|error| self.refuse(&error))?)),
            (true, false) => {
                console.say(&format!(
                    "warning: {name} holds an unfinished render; --resume continues it, this render leaves it as it is"
                ));
                Ok(None)
            }
            (false, true) => {
                console.say(&format!("there is no {name} to continue: starting from the beginning"));
                Ok(None)
            }
            (false, false) => Ok(None),
        }
    }

    /// A render's error, with a remedy if this file is the cause.
    pub(super) fn explain(&self, error: RenderError) -> Failure {
        match error {
            RenderError::Mismatch(why) => self.refuse(&why),
            other => other.into(),
        }
    }

    fn refuse(&self, why: &dyn Display) -> Failure {
        Failure::Other(anyhow!(
            "cannot continue {}: {why}; restore what differs, or leave out --resume to start from the beginning",
            self.path.display()
        ))
    }

    /// Writes `state` with the times of `report`, whole or not at all; says how to continue.
    pub(super) fn save<P: Payload>(
        &self,
        mut state: ResumeState<P>,
        report: &Report,
    ) -> Result<String, Failure> {
        state.time = report.time.clone();
        let name = self.to.display();
        self.write(&state).with_context(|| format!("cannot write {name}"))?;
        Ok(match self.to == self.path {
            true => format!("continue with --resume (state in {name})"),
            false => format!(
                "the state is in {name}: rename it to {} to continue it with --resume",
                self.path.display()
            ),
        })
    }

    fn write(&self, state: &dyn State) -> io::Result<()> {
        atomic_file::write(&self.to, |out| state.write(out))
    }

    /// Removes what this render wrote or continued, once the image is whole.
    pub(super) fn remove(&self) -> Result<(), Failure> {
        remove(&self.to)
    }
}

/// The path of an image with `end` appended to its name.
fn named(image: &Path, end: &str) -> PathBuf {
    let mut name = image.as_os_str().to_owned();
    name.push(end);
    name.into()
}

/// The first of `IMAGE.partial.2`, `IMAGE.partial.3` and so on that does not exist.
fn free(image: &Path) -> PathBuf {
    let mut number = 2u64;
    loop {
        let path = named(image, &format!(".partial.{number}"));
        if !exists(&path) {
            return path;
        }
        number += 1;
    }
}

/// A link that leads nowhere is there as well.
fn exists(path: &Path) -> bool {
    path.symlink_metadata().is_ok()
}

/// Removes a file that may be missing.
pub(super) fn remove(path: &Path) -> Result<(), Failure> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => {
            Err(anyhow!("cannot remove {}: {error}", path.display()).into())
        }
        _ => Ok(()),
    }
}

/// An observer that writes the state of long work to `file` every `seconds`; not at all if there is no file, or `seconds` is
/// 0. A state that cannot be written is a warning, once: the render may yet be finished.
pub(super) fn checkpoints<'a>(
    observer: &'a mut dyn Observer,
    file: Option<&'a StateFile>,
    seconds: f64,
) -> Checkpoints<'a> {
    let write = file.map(|file| {
        let mut failed = false;
        let write: WriteState<'a> = Box::new(move |state| {
            if let Err(error) = file.write(state)
                && !failed
            {
                failed = true;
                // A closed standard error must not end the render either.
                let name = file.to.display();
                let _ = writeln!(io::stderr(), "warning: the state cannot be kept in {name}: {error}");
            }
        });
        write
    });
    Checkpoints::new(observer, write, seconds)
}

/// The state of a finished image: `OUT.state`, or a share, which is its own.
pub(super) struct KeptState(PathBuf);

impl KeptState {
    /// `OUT.state` of an image.
    pub(super) fn of(image: &Path) -> KeptState {
        KeptState(named(image, ".state"))
    }

    /// A share.
    pub(super) fn share(path: &Path) -> KeptState {
        KeptState(path.to_owned())
    }

    /// Its path.
    pub(super) fn path(&self) -> &Path {
        &self.0
    }

    /// Reads it.
    pub(super) fn read(&self) -> Result<ResumeState<Sums>, Failure> {
        read(&self.0).map_err(|error| match error.kind() {
            io::ErrorKind::NotFound => Failure::Other(anyhow!(
                "there is no {}: {}",
                self.0.display(),
                match self.0.extension().is_some_and(|e| e == "share") {
                    true => "render it with --share",
                    false => "a render with --keep-state writes it, and --continue adds samples to it",
                }
            )),
            _ => Failure::Other(anyhow!("cannot read {}: {error}", self.0.display())),
        })
    }

    /// A render's error, with a remedy if this file is the cause.
    pub(super) fn explain(&self, error: RenderError) -> Failure {
        match error {
            RenderError::Mismatch(why) => Failure::Other(anyhow!(
                "cannot add samples to {}: {why}; restore what differs, or leave out --continue to start from the beginning",
                self.0.display()
            )),
            other => other.into(),
        }
    }

    /// Writes it, whole or not at all.
    pub(super) fn write(&self, state: &dyn State) -> Result<(), Failure> {
        Ok(atomic_file::write(&self.0, |out| state.write(out))
            .with_context(|| format!("cannot write {}", self.0.display()))?)
    }
}

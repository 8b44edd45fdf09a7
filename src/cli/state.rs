//! The state file next to an image, `OUT.partial`: the finished part of an interrupted render.

use super::console::Console;
use super::failure::Failure;
use crate::atomic_file;
use crate::render::{Payload, RenderError, ResumeState};
use crate::report::Report;
use anyhow::{Context, anyhow};
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

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
        let path = named(image, "");
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
            (true, true) => {
                let read = File::open(&self.path).and_then(|mut file| ResumeState::read(&mut file));
                Ok(Some(read.map_err(|error| self.refuse(&error))?))
            }
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

    fn refuse(&self, why: &dyn std::fmt::Display) -> Failure {
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
        atomic_file::write(&self.to, |out| state.write(out))
            .with_context(|| format!("cannot write {name}"))?;
        Ok(match self.to == self.path {
            true => format!("continue with --resume (state in {name})"),
            false => format!(
                "the state is in {name}: rename it to {} to continue it with --resume",
                self.path.display()
            ),
        })
    }

    /// Removes it once the image is whole.
    pub(super) fn remove(&self) -> Result<(), Failure> {
        remove(&self.path)
    }
}

/// `IMAGE.partial`, and what follows it.
fn named(image: &Path, end: &str) -> PathBuf {
    let mut name = image.as_os_str().to_owned();
    name.push(format!(".partial{end}"));
    name.into()
}

/// The first of `IMAGE.partial.2`, `IMAGE.partial.3` and so on that does not exist.
fn free(image: &Path) -> PathBuf {
    let mut number = 2u64;
    loop {
        let path = named(image, &format!(".{number}"));
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

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

/// Path of a state file, which need not exist.
pub(super) struct StateFile(PathBuf);

impl StateFile {
    /// The state file of an image file.
    pub(super) fn of(image: &Path) -> StateFile {
        let mut name = image.as_os_str().to_owned();
        name.push(".partial");
        StateFile(name.into())
    }

    /// True if there is an unfinished render.
    pub(super) fn exists(&self) -> bool {
        self.0.exists()
    }

    /// The stored state if `resume` is set; otherwise only warns if there is one.
    pub(super) fn earlier<P: Payload>(
        &self,
        resume: bool,
        console: &mut Console,
    ) -> Result<Option<ResumeState<P>>, Failure> {
        let name = self.0.display();
        match (self.0.exists(), resume) {
            (true, true) => {
                let read = File::open(&self.0).and_then(|mut file| ResumeState::read(&mut file));
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
            self.0.display()
        ))
    }

    /// Writes `state` with the times of `report`, whole or not at all; says how to continue.
    pub(super) fn save<P: Payload>(
        &self,
        mut state: ResumeState<P>,
        report: &Report,
    ) -> Result<String, Failure> {
        state.time = report.time.clone();
        let name = self.0.display();
        atomic_file::write(&self.0, |out| state.write(out))
            .with_context(|| format!("cannot write {name}"))?;
        Ok(format!("continue with --resume (state in {name})"))
    }

    /// Removes it once the image is whole.
    pub(super) fn remove(&self) -> Result<(), Failure> {
        match fs::remove_file(&self.0) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                Err(anyhow!("cannot remove {}: {error}", self.0.display()).into())
            }
            _ => Ok(()),
        }
    }
}

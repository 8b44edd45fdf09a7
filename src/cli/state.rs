//! The state file next to an image, `OUT.partial`: the finished part of an interrupted render.

use super::console::Console;
use super::failure::Failure;
use crate::atomic_file;
use crate::render::RenderError;
use anyhow::{Context, anyhow};
use std::fs::{self, File};
use std::io::{self, BufRead, BufReader, Write};
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

    /// The stored state if `resume` is set; otherwise only warns if there is one.
    pub(super) fn earlier<T>(
        &self,
        resume: bool,
        read: impl FnOnce(&mut dyn BufRead) -> io::Result<T>,
        console: &mut Console,
    ) -> Result<Option<T>, Failure> {
        let name = self.0.display();
        match (self.0.exists(), resume) {
            (true, true) => {
                let read = File::open(&self.0).and_then(|file| read(&mut BufReader::new(file)));
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

    /// Writes it whole or not at all.
    pub(super) fn save(&self, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), Failure> {
        Ok(atomic_file::write(&self.0, |out| write(out))
            .with_context(|| format!("cannot write {}", self.0.display()))?)
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

    /// Its path.
    pub(super) fn path(&self) -> &Path {
        &self.0
    }
}

//! What readers assumed, replaced or left out: one line a kind, with a count and the first place.

use super::error::{SceneError, Source};
use std::fmt;
use std::path::{Path, PathBuf};

/// Notes of one reading, in the order in which their kinds first came up.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Notes(Vec<Note>);

/// One kind of assumption.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Note {
    /// What was assumed, without the place: "faces without a material get the default material, diffuse 0.8".
    pub message: String,
    /// How often, at least 1.
    pub count: usize,
    /// The file of the first place.
    pub file: PathBuf,
    /// Line of the first place, from 1; 0 if the file has no lines.
    pub line: usize,
}

impl Notes {
    /// True if nothing had to be assumed.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The notes.
    pub fn iter(&self) -> impl Iterator<Item = &Note> {
        self.0.iter()
    }

    /// One line of text for each.
    pub fn lines(&self) -> Vec<String> {
        self.0.iter().map(Note::to_string).collect()
    }

    /// Counts one more of `message`; `line` is used if it is the first.
    pub(super) fn add(&mut self, message: &str, file: &Path, line: usize) {
        self.add_count(message, 1, file, line);
    }

    /// Counts `count` more of `message`.
    pub(super) fn add_count(&mut self, message: &str, count: usize, file: &Path, line: usize) {
        if count == 0 {
            return;
        }
        match self.0.iter_mut().find(|note| note.message == message) {
            Some(note) => note.count += count,
            None => self.0.push(Note { message: message.to_owned(), count, file: file.to_owned(), line }),
        }
    }
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if self.line > 0 {
            write!(f, ":{}", self.line)?;
        }
        write!(f, ": {}", self.message)?;
        if self.count > 1 {
            write!(f, " ({} times)", crate::units::grouped(self.count as u64))?;
        }
        Ok(())
    }
}

/// How strictly files are read, and where their notes go.
pub(super) struct Reading {
    /// Whatever would be a note is an error (`--strict`).
    pub strict: bool,
    /// What was assumed so far.
    pub notes: Notes,
}

impl Reading {
    /// Notes `message` at byte `offset` of `source`, or fails with it if the reading is strict.
    pub fn assume(
        &mut self,
        source: Source,
        offset: usize,
        object: &str,
        message: &str,
        remedy: &str,
    ) -> Result<(), SceneError> {
        let error = source.error(offset, object, message, remedy);
        if self.strict {
            return Err(error);
        }
        self.notes.add(message, source.file, error.line);
        Ok(())
    }
}

//! What readers assumed, replaced or left out: one line a kind, with a count and the first place.

use super::error::{SceneError, Source, printable};
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

/// Kinds that are listed; what comes up later is counted as one more.
const MAX_KINDS: usize = 50;

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

    /// True if a note of this `message` has its place already, or gets none.
    fn is_placed(&self, message: &str) -> bool {
        self.0.len() >= MAX_KINDS || self.0.iter().any(|note| note.message == message)
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
        let full = self.0.len() >= MAX_KINDS;
        if let Some(note) = self.0.iter_mut().find(|note| note.message == message) {
            note.count += count;
        } else if let (true, Some(last)) = (full, self.0.last_mut()) {
            // A file of nothing but oddities does not make a list without end.
            last.message = "and more of other kinds".to_owned();
            last.count += count;
        } else {
            self.0.push(Note { message: message.to_owned(), count, file: file.to_owned(), line });
        }
    }
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", printable(&self.file.display().to_string()))?;
        if self.line > 0 {
            write!(f, ":{}", self.line)?;
        }
        write!(f, ": {}", printable(&self.message))?;
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
        if self.strict {
            return Err(source.error(offset, object, message, remedy));
        }
        self.count(source, offset, message, 1);
        Ok(())
    }

    /// Counts `count` more of `message`, which is first met at byte `offset` of `source` if it is new.
    pub fn count(&mut self, source: Source, offset: usize, message: &str, count: usize) {
        // The line is counted from the start of the text: not for each of many.
        let line = if self.notes.is_placed(message) { 0 } else { source.place(offset).0 };
        self.notes.add_count(message, count, source.file, line);
    }
}

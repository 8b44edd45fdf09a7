//! A file of shapes as its reader sees it: its bytes, what messages call it, errors and notes about all of it.

use super::error::{SceneError, Source};
use super::notes::Reading;

/// Most characters of a file's own words in a message.
const SHOWN: usize = 60;

/// One file of shapes.
#[derive(Clone, Copy)]
pub(super) struct ModelFile<'a> {
    /// Path and bytes.
    pub source: Source<'a>,
    /// What messages call it: "mesh `cube.glb`".
    pub object: &'a str,
}

impl ModelFile<'_> {
    /// An error without a line: the file is binary, or all of it is meant.
    pub fn error(&self, message: impl Into<String>, remedy: impl Into<String>) -> SceneError {
        SceneError {
            file: self.source.file.to_owned(),
            line: 0,
            column: 0,
            object: self.object.to_owned(),
            message: message.into(),
            remedy: remedy.into(),
            cause: None,
        }
    }

    /// An error at byte `offset` of a text.
    pub fn error_at(
        &self,
        offset: usize,
        message: impl Into<String>,
        remedy: impl Into<String>,
    ) -> SceneError {
        self.source.error(offset, self.object, message, remedy)
    }

    /// Notes `count` times that `message` was assumed, without a line; fails with it if the reading is strict.
    pub fn assume(
        &self,
        reading: &mut Reading,
        count: usize,
        message: &str,
        remedy: &str,
    ) -> Result<(), SceneError> {
        if count > 0 && reading.strict {
            return Err(self.error(message, remedy));
        }
        reading.notes.add_count(message, count, self.source.file, 0);
        Ok(())
    }

    /// Notes how something of the file is shown here; never an error.
    pub fn inform(&self, reading: &mut Reading, message: &str) {
        reading.notes.add(message, self.source.file, 0);
    }
}

/// A file's own word for a message: control characters escaped, long ones cut.
pub(super) fn shown(word: &str) -> String {
    let mut text = String::new();
    for (i, c) in word.chars().enumerate() {
        if i == SHOWN {
            text.push_str("...");
            break;
        }
        if c.is_control() { text.extend(c.escape_default()) } else { text.push(c) }
    }
    text
}

/// At most eight of `names`, as a list for a message.
pub(super) fn some<S: AsRef<str>>(names: &[S]) -> String {
    const MOST: usize = 8;
    let listed: Vec<_> = names.iter().take(MOST).map(|n| format!("`{}`", shown(n.as_ref()))).collect();
    let more = names.len().saturating_sub(MOST);
    let rest = if more > 0 { format!(" and {more} more") } else { String::new() };
    listed.join(", ") + &rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_cannot_drive_a_terminal() {
        assert_eq!(shown("a\u{1b}[31mb\n"), "a\\u{1b}[31mb\\n");
        assert_eq!(shown(&"x".repeat(100)), "x".repeat(60) + "...");
        assert_eq!(some(&["a"; 10]), "`a`, `a`, `a`, `a`, `a`, `a`, `a`, `a` and 2 more");
    }
}

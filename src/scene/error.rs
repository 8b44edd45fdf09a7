//! What is wrong with a scene, where, and what to write instead.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// One mistake in a scene's text or in a file it names.
#[derive(Debug)]
pub struct SceneError {
    /// The file with the mistake.
    pub file: PathBuf,
    /// Line, from 1; 0 if the whole file is meant (it cannot be read).
    pub line: usize,
    /// Column in characters, from 1; 0 if the whole file is meant.
    pub column: usize,
    /// The object concerned: "sphere 3", "material `glass`", "mesh `cube.obj`".
    pub object: String,
    /// What is wrong.
    pub message: String,
    /// What to write instead.
    pub remedy: String,
    /// What the system says, if the file cannot be read.
    pub cause: Option<io::Error>,
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:", printable(&self.file.display().to_string()))?;
        if self.line > 0 {
            write!(f, "{}:{}:", self.line, self.column)?;
        }
        let [object, message, remedy] = [&self.object, &self.message, &self.remedy].map(|t| printable(t));
        write!(f, " {object}: {message}\n  help: {remedy}")
    }
}

impl std::error::Error for SceneError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        self.cause.as_ref().map(|cause| cause as _)
    }
}

/// A text with its file's name: turns byte offsets into lines and columns.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub file: &'a Path,
    pub text: &'a [u8],
}

impl Source<'_> {
    /// An error at byte `offset`.
    pub fn error(
        &self,
        offset: usize,
        object: impl Into<String>,
        message: impl Into<String>,
        remedy: impl Into<String>,
    ) -> SceneError {
        let (line, column) = self.place(offset);
        SceneError {
            file: self.file.to_owned(),
            line,
            column,
            object: object.into(),
            message: message.into(),
            remedy: remedy.into(),
            cause: None,
        }
    }

    /// Line and column of byte `offset`, both from 1, the column in characters.
    pub fn place(&self, offset: usize) -> (usize, usize) {
        let before = &self.text[..offset.min(self.text.len())];
        let start = before.iter().rposition(|b| *b == b'\n').map_or(0, |at| at + 1);
        let line = 1 + before.iter().filter(|b| **b == b'\n').count();
        // Bytes 10xxxxxx continue a UTF-8 character.
        let column = 1 + before[start..].iter().filter(|b| **b & 0xc0 != 0x80).count();
        (line, column)
    }
}

/// Longest part of a message, characters: room for a dozen long names.
const LONGEST: usize = 1000;

/// `text` for people: control characters, and those that turn the direction of writing, as `\u{1b}`; no longer than
/// [`LONGEST`].
pub(super) fn printable(text: &str) -> String {
    let mut shown = String::with_capacity(text.len().min(LONGEST));
    for (i, c) in text.chars().enumerate() {
        if i == LONGEST {
            shown.push('…');
            break;
        }
        let turns = matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
        if c.is_control() || turns { shown.extend(c.escape_unicode()) } else { shown.push(c) }
    }
    shown
}

/// A file that cannot be read at all.
pub(super) fn unreadable(file: &Path, object: &str, cause: io::Error) -> SceneError {
    SceneError {
        file: file.to_owned(),
        line: 0,
        column: 0,
        object: object.to_owned(),
        message: "cannot be read".to_owned(),
        remedy: "give the path of a file that exists and may be read".to_owned(),
        cause: Some(cause),
    }
}

/// "; did you mean `x`?" for the known word nearest to `word`, or nothing if none is near.
pub(super) fn did_you_mean<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    // A third of the letters may differ: the usual bound (rustc's) that still catches two slips in a
    // word of six.
    let limit = (word.chars().count() / 3).max(1);
    // The distance takes time and memory of the product of the lengths: no name is that long.
    if limit > 50 {
        return String::new();
    }
    known
        .into_iter()
        .filter(|k| k.len() <= 2 * word.len() + 2)
        .map(|k| (strsim::osa_distance(&word.to_lowercase(), &k.to_lowercase()), k))
        .min()
        .filter(|(distance, _)| *distance <= limit)
        .map_or(String::new(), |(_, k)| format!("; did you mean `{k}`?"))
}

/// Words as a list for a remedy: `a`, `b`, `c`; of many the first.
pub(super) fn list<'a>(words: impl IntoIterator<Item = &'a str>) -> String {
    const MOST: usize = 20;
    let mut words = words.into_iter();
    let mut list = words.by_ref().take(MOST).map(|w| format!("`{w}`")).collect::<Vec<_>>().join(", ");
    let more = words.count();
    if more > 0 {
        list += &format!(" and {} more", crate::units::grouped(more as u64));
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_count_characters() {
        let source = Source { file: Path::new("f"), text: "a\né = x".as_bytes() };
        assert_eq!(source.place(0), (1, 1));
        assert_eq!(source.place(2), (2, 1));
        assert_eq!(source.place(4), (2, 2));
        assert_eq!(source.place(1000), (2, 6));
    }

    #[test]
    fn near_words_are_proposed() {
        assert_eq!(did_you_mean("raduis", ["radius", "center"]), "; did you mean `radius`?");
        assert_eq!(did_you_mean("xyz", ["radius", "center"]), "");
    }

    #[test]
    fn nothing_reaches_the_terminal_but_text() {
        let source = Source { file: Path::new("a\u{1b}[2J.obj"), text: b"x" };
        let error = source.error(0, "mesh", "a\u{1b}]0;title\u{7}\u{202e}é", "\0").to_string();
        assert_eq!(error, "a\\u{1b}[2J.obj:1:1: mesh: a\\u{1b}]0;title\\u{7}\\u{202e}é\n  help: \\u{0}");
        assert!(source.error(0, "", "x".repeat(1 << 20), "").to_string().len() < 2 * LONGEST);
    }

    #[test]
    fn display_has_the_compilers_form() {
        let source = Source { file: Path::new("a.toml"), text: b"x" };
        let error = source.error(0, "sphere 1", "bad", "write good");
        assert_eq!(error.to_string(), "a.toml:1:1: sphere 1: bad\n  help: write good");
    }
}

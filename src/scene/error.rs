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
        write!(f, "{}:", self.file.display())?;
        if self.line > 0 {
            write!(f, "{}:{}:", self.line, self.column)?;
        }
        write!(f, " {}: {}\n  help: {}", self.object, self.message, self.remedy)
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
    fn place(&self, offset: usize) -> (usize, usize) {
        let before = &self.text[..offset.min(self.text.len())];
        let start = before.iter().rposition(|b| *b == b'\n').map_or(0, |at| at + 1);
        let line = 1 + before.iter().filter(|b| **b == b'\n').count();
        // Bytes 10xxxxxx continue a UTF-8 character.
        let column = 1 + before[start..].iter().filter(|b| **b & 0xc0 != 0x80).count();
        (line, column)
    }
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
    known
        .into_iter()
        .map(|k| (strsim::osa_distance(&word.to_lowercase(), &k.to_lowercase()), k))
        .min()
        .filter(|(distance, _)| *distance <= limit)
        .map_or(String::new(), |(_, k)| format!("; did you mean `{k}`?"))
}

/// Words as a list for a remedy: `a`, `b`, `c`.
pub(super) fn list<'a>(words: impl IntoIterator<Item = &'a str>) -> String {
    words.into_iter().map(|w| format!("`{w}`")).collect::<Vec<_>>().join(", ")
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
    fn display_has_the_compilers_form() {
        let source = Source { file: Path::new("a.toml"), text: b"x" };
        let error = source.error(0, "sphere 1", "bad", "write good");
        assert_eq!(error.to_string(), "a.toml:1:1: sphere 1: bad\n  help: write good");
    }
}

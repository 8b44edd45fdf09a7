//! Words of line-based texts (OBJ, MTL): blanks divide them, `#` starts a comment, a backslash at the
//! end of a line continues it.

use super::error::{SceneError, Source};
use super::table::MAX_LENGTH;
use glam::DVec3;

/// Walks over a text. Holds byte offsets only, so places in errors are exact and cost nothing before.
pub(super) struct Words<'a> {
    pub source: Source<'a>,
    /// What the text describes, for messages.
    pub object: String,
    at: usize,
}

/// A word and where it starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Word<'a> {
    pub bytes: &'a [u8],
    pub offset: usize,
}

impl<'a> Words<'a> {
    pub fn new(source: Source<'a>, object: String) -> Words<'a> {
        // A byte order mark is no part of the first word.
        let at = if source.text.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        Words { source, object, at }
    }

    /// From byte `at`, the start of a line.
    pub fn starting(source: Source<'a>, object: String, at: usize) -> Words<'a> {
        Words { source, object, at }
    }

    /// An error at byte `offset`.
    pub fn error(&self, offset: usize, message: impl Into<String>, remedy: impl Into<String>) -> SceneError {
        self.source.error(offset, &self.object, message, remedy)
    }

    /// Moves to the first word of the next line that has one; `None` at the end of the text.
    pub fn keyword(&mut self) -> Option<Word<'a>> {
        while self.at < self.source.text.len() {
            if let Some(word) = self.word() {
                return Some(word);
            }
            self.end_line();
        }
        None
    }

    /// The next word of this line.
    pub fn word(&mut self) -> Option<Word<'a>> {
        let text = self.source.text;
        loop {
            match *text.get(self.at)? {
                b'\n' | b'#' => return None,
                b'\\' if self.continuation() > 0 => self.at += self.continuation(),
                b if b.is_ascii_whitespace() => self.at += 1,
                _ => break,
            }
        }
        let offset = self.at;
        while let Some(&b) = text.get(self.at) {
            if b.is_ascii_whitespace() || (b == b'\\' && self.continuation() > 0) {
                break;
            }
            self.at += 1;
        }
        Some(Word { bytes: &text[offset..self.at], offset })
    }

    /// Length of the backslash and line end at the current place, or 0.
    fn continuation(&self) -> usize {
        match &self.source.text[self.at..] {
            [b'\\', b'\n', ..] => 2,
            [b'\\', b'\r', b'\n', ..] => 3,
            _ => 0,
        }
    }

    /// Skips the rest of this line, with its continuations.
    pub fn end_line(&mut self) {
        let text = self.source.text;
        loop {
            let Some(length) = text[self.at..].iter().position(|b| *b == b'\n') else {
                self.at = text.len();
                return;
            };
            let line = &text[self.at..self.at + length];
            self.at += length + 1;
            let continued = line.ends_with(b"\\") || line.ends_with(b"\\\r");
            if !continued || line.contains(&b'#') {
                return;
            }
        }
    }

    /// The rest of this line without outer blanks, comment signs and all: a name may hold anything.
    pub fn line(&mut self) -> Option<Word<'a>> {
        let text = self.source.text;
        let length = text[self.at..].iter().position(|b| *b == b'\n').unwrap_or(text.len() - self.at);
        let bytes = text[self.at..self.at + length].trim_ascii();
        let offset = self.at + text[self.at..].iter().position(|b| !b.is_ascii_whitespace()).unwrap_or(0);
        self.at += length;
        (!bytes.is_empty()).then_some(Word { bytes, offset })
    }

    /// A finite number.
    pub fn number(&self, word: Word) -> Result<f64, SceneError> {
        let number = std::str::from_utf8(word.bytes).ok().and_then(|text| text.parse::<f64>().ok());
        number.filter(|x| x.is_finite()).ok_or_else(|| {
            self.error(
                word.offset,
                format!("`{}` is no finite number", word.text()),
                "write a number such as `1.5`",
            )
        })
    }

    /// The next three words of the line opened by `keyword` as numbers.
    pub fn vector(&mut self, keyword: Word) -> Result<DVec3, SceneError> {
        let mut v = [0.0; 3];
        for x in &mut v {
            let Some(word) = self.word() else {
                let name = keyword.text();
                return Err(self.error(
                    keyword.offset,
                    format!("`{name}` needs three numbers"),
                    format!("write it as `{name} 0 1 0`"),
                ));
            };
            *x = self.number(word)?;
            if x.abs() > MAX_LENGTH {
                return Err(self.error(
                    word.offset,
                    format!("`{}` is larger than {MAX_LENGTH:e}", word.text()),
                    "use a larger unit of length",
                ));
            }
        }
        Ok(DVec3::from_array(v))
    }
}

impl Word<'_> {
    /// For messages: as [`name`], the first 60 characters.
    pub fn text(&self) -> String {
        const LONGEST: usize = 60;
        // No character is longer than 4 bytes.
        let text = name(&self.bytes[..self.bytes.len().min(4 * LONGEST)]);
        match text.char_indices().nth(LONGEST) {
            Some((end, _)) => format!("{}…", &text[..end]),
            None => text,
        }
    }
}

/// Bytes as text; those that are not UTF-8 as `\xb2`, so that different bytes stay different.
pub(super) fn name(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len());
    for chunk in bytes.utf8_chunks() {
        text += chunk.valid();
        chunk.invalid().iter().for_each(|byte| text += &format!("\\x{byte:02x}"));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn lines(text: &str) -> Vec<Vec<String>> {
        let source = Source { file: Path::new("t"), text: text.as_bytes() };
        let mut words = Words::new(source, String::new());
        let mut lines = Vec::new();
        while let Some(first) = words.keyword() {
            let mut line = vec![first.text()];
            while let Some(word) = words.word() {
                line.push(word.text());
            }
            words.end_line();
            lines.push(line);
        }
        lines
    }

    #[test]
    fn comments_continuations_and_line_ends() {
        assert_eq!(
            lines("\u{feff}a b\\\n c # d\\\ne\r\n\r\n  f\\g#h\\\r\ni\n#\nj"),
            [vec!["a", "b", "c"], vec!["e"], vec!["f\\g#h", "i"], vec!["j"]]
        );
    }

    #[test]
    fn lines_keep_everything() {
        let source = Source { file: Path::new("t"), text: b"newmtl  Paint #1\\ \r\nnewmtl \n" };
        let mut words = Words::new(source, String::new());
        words.keyword().unwrap();
        assert_eq!(words.line(), Some(Word { bytes: b"Paint #1\\", offset: 8 }));
        words.end_line();
        words.keyword().unwrap();
        assert_eq!(words.line(), None);
    }

    #[test]
    fn names_of_other_encodings_stay_different() {
        assert_eq!(name(b"\xba\xec"), "\\xba\\xec");
        assert_ne!(name(b"\xba\xec"), name(b"\xc0\xb6"));
        assert_eq!(Word { bytes: "é".repeat(100).as_bytes(), offset: 0 }.text(), "é".repeat(60) + "…");
    }
}

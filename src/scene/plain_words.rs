//! Words of texts in which line ends mean no more than blanks (STL, the body of PLY).

use super::error::SceneError;
use super::model_file::{ModelFile, shown};

/// Walks over a text by byte offsets.
pub(super) struct PlainWords<'a> {
    pub file: ModelFile<'a>,
    /// Byte offset of what follows.
    pub at: usize,
}

/// A word and the byte where it starts.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlainWord<'a> {
    pub bytes: &'a [u8],
    pub offset: usize,
}

impl<'a> PlainWords<'a> {
    /// The next word, on this line or a later one.
    pub fn next(&mut self) -> Option<PlainWord<'a>> {
        let text = self.file.source.text;
        let blank = |b: &u8| b.is_ascii_whitespace() || *b == 0;
        let offset = self.at + text[self.at..].iter().position(|b| !blank(b))?;
        let length = text[offset..].iter().position(blank).unwrap_or(text.len() - offset);
        self.at = offset + length;
        Some(PlainWord { bytes: &text[offset..self.at], offset })
    }

    /// Skips the rest of the line.
    pub fn end_line(&mut self) {
        let rest = &self.file.source.text[self.at..];
        self.at += rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(rest.len());
    }

    /// A number; NaN for the ways in which C libraries print what is no number.
    pub fn number(&self, word: PlainWord) -> Result<f64, SceneError> {
        let text = String::from_utf8_lossy(word.bytes);
        if let Ok(number) = text.parse() {
            return Ok(number);
        }
        let lower = text.to_ascii_lowercase();
        if lower.contains("nan") || lower.contains("#ind") || lower.contains("#inf") {
            return Ok(f64::NAN);
        }
        Err(self.file.error_at(
            word.offset,
            format!("`{}` is no number", shown(&text)),
            "write a number such as `1.5`",
        ))
    }
}

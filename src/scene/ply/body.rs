//! The numbers after the header of a PLY file.

use super::header::{Element, Encoding, Number};
use crate::scene::error::SceneError;
use crate::scene::model_file::ModelFile;
use crate::scene::plain_words::PlainWords;

/// Walks over the numbers.
pub struct Body<'a> {
    encoding: Encoding,
    words: PlainWords<'a>,
}

impl<'a> Body<'a> {
    /// From byte `at`.
    pub fn new(file: ModelFile<'a>, encoding: Encoding, at: usize) -> Body<'a> {
        Body { encoding, words: PlainWords { file, at } }
    }

    /// Bytes left.
    fn left(&self) -> usize {
        self.words.file.source.text.len() - self.words.at
    }

    /// Checks that the rest of the file can hold all of `element`: nothing is allocated for a count that it cannot.
    pub fn check(&self, element: &Element) -> Result<(), SceneError> {
        let least = |number: Number| match self.encoding {
            // A digit and what divides it from the next.
            Encoding::Ascii => 2,
            _ => number.size(),
        };
        let bytes: usize = element.properties.iter().map(|p| least(p.length.unwrap_or(p.number))).sum();
        // The last number of a text needs no end.
        let left = self.left() + usize::from(self.encoding == Encoding::Ascii);
        if element.count.checked_mul(bytes).is_some_and(|needed| needed <= left) {
            return Ok(());
        }
        Err(self.words.file.error_at(
            element.offset,
            format!(
                "{} elements `{}` are announced, more than the file can hold",
                element.count, element.name
            ),
            "the file is cut short, or its header is wrong: export or download it again",
        ))
    }

    /// The next number.
    pub fn number(&mut self, number: Number) -> Result<f64, SceneError> {
        if self.encoding == Encoding::Ascii {
            let word = self.words.next().ok_or_else(|| self.ended())?;
            return self.words.number(word);
        }
        Ok(match number {
            Number::I8 => f64::from(i8::from_le_bytes(self.bytes()?)),
            Number::U8 => f64::from(u8::from_le_bytes(self.bytes()?)),
            Number::I16 => f64::from(i16::from_le_bytes(self.bytes()?)),
            Number::U16 => f64::from(u16::from_le_bytes(self.bytes()?)),
            Number::I32 => f64::from(i32::from_le_bytes(self.bytes()?)),
            Number::U32 => f64::from(u32::from_le_bytes(self.bytes()?)),
            Number::F32 => f64::from(f32::from_le_bytes(self.bytes()?)),
            Number::F64 => f64::from_le_bytes(self.bytes()?),
        })
    }

    /// The next number, as the length of a list that the rest of the file can hold.
    pub fn length(&mut self, length: Number, item: Number) -> Result<usize, SceneError> {
        let offset = self.words.at;
        let written = self.number(length)?;
        let least = if self.encoding == Encoding::Ascii { 1 } else { item.size() };
        let fits = written >= 0.0 && written.fract() == 0.0 && written * least as f64 <= self.left() as f64;
        if fits {
            return Ok(written as usize);
        }
        Err(self.error_at(
            offset,
            &format!("a list of {written} items, which the file cannot hold"),
            "the file is cut short or damaged: export or download it again",
        ))
    }

    /// An error at byte `offset`, with its line if the file is a text.
    pub fn error_at(&self, offset: usize, message: &str, remedy: &str) -> SceneError {
        match self.encoding {
            Encoding::Ascii => self.words.file.error_at(offset, message, remedy),
            _ => self.words.file.error(format!("byte {offset}: {message}"), remedy),
        }
    }

    /// Where the next number starts, at most a few blanks earlier.
    pub fn at(&self) -> usize {
        self.words.at
    }

    fn ended(&self) -> SceneError {
        self.words.file.error(
            "the file ends before all that its header announces",
            "it is cut short: export or download it again",
        )
    }

    /// The next N bytes, least significant first.
    fn bytes<const N: usize>(&mut self) -> Result<[u8; N], SceneError> {
        let rest = &self.words.file.source.text[self.words.at..];
        let Some(bytes) = rest.first_chunk::<N>() else { return Err(self.ended()) };
        let mut bytes = *bytes;
        if self.encoding == Encoding::BigEndian {
            bytes.reverse();
        }
        self.words.at += N;
        Ok(bytes)
    }
}

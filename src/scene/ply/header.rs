//! The header of a PLY file: which elements follow, with which properties, in which encoding.

use crate::scene::error::SceneError;
use crate::scene::model_file::{ModelFile, shown};
use crate::scene::notes::Reading;

/// How the body is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// Type of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Number {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Number {
    fn named(word: &str) -> Option<Number> {
        Some(match word {
            "char" | "int8" => Number::I8,
            "uchar" | "uint8" => Number::U8,
            "short" | "int16" => Number::I16,
            "ushort" | "uint16" => Number::U16,
            "int" | "int32" => Number::I32,
            "uint" | "uint32" => Number::U32,
            "float" | "float32" => Number::F32,
            "double" | "float64" => Number::F64,
            _ => return None,
        })
    }

    /// Bytes of a binary one.
    pub fn size(self) -> usize {
        match self {
            Number::I8 | Number::U8 => 1,
            Number::I16 | Number::U16 => 2,
            Number::I32 | Number::U32 | Number::F32 => 4,
            Number::F64 => 8,
        }
    }

    /// True for whole numbers.
    pub fn is_whole(self) -> bool {
        !matches!(self, Number::F32 | Number::F64)
    }
}

/// One property of an element.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Property {
    pub name: String,
    /// Type of the value, or of a list's items.
    pub number: Number,
    /// Type of a list's length; absent for a single value.
    pub length: Option<Number>,
}

/// One kind of element.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Element {
    pub name: String,
    pub count: usize,
    pub properties: Vec<Property>,
    /// Byte offset of its line.
    pub offset: usize,
}

/// All of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// Byte offset of the body.
    pub body: usize,
    /// A comment names a texture.
    pub textured: bool,
}

/// Reads the header.
pub fn read(file: ModelFile, reading: &mut Reading) -> Result<Header, SceneError> {
    let bytes = file.source.text;
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    let mut textured = false;
    let mut at = 0;
    loop {
        let offset = at;
        let Some(line) = line(bytes, &mut at) else {
            return Err(file.error_at(
                bytes.len(),
                "the header has no end",
                "end it with the line `end_header`; the file may be cut short",
            ));
        };
        let text = String::from_utf8_lossy(line);
        let words: Vec<&str> = text.split_ascii_whitespace().collect();
        let wrong = |remedy: &str| {
            let message = format!("`{}` cannot be read in the header of a PLY file", shown(text.trim()));
            file.error_at(offset, message, remedy)
        };
        match words[..] {
            [] | ["ply" | "obj_info", ..] => {}
            ["comment", "TextureFile", ..] => textured = true,
            ["comment", ..] => {}
            ["format", name, ..] => {
                encoding = Some(match name {
                    "ascii" => Encoding::Ascii,
                    "binary_little_endian" => Encoding::LittleEndian,
                    "binary_big_endian" => Encoding::BigEndian,
                    _ => return Err(wrong("write `format ascii 1.0`, or `binary_little_endian`")),
                });
            }
            ["element", name, count] => {
                let count = count.parse().map_err(|_| wrong("write it as `element vertex 8`"))?;
                elements.push(Element { name: name.to_owned(), count, properties: Vec::new(), offset });
            }
            ["property", ..] => {
                let property = property(&words[1..]).ok_or_else(|| {
                    wrong("write `property float x`, or `property list uchar int vertex_indices`")
                })?;
                let element = elements.last_mut().ok_or_else(|| wrong("put an `element` line above it"))?;
                element.properties.push(property);
            }
            ["end_header"] => break,
            _ => reading.assume(
                file.source,
                offset,
                file.object,
                "unknown lines of the header are skipped",
                "use `format`, `comment`, `element`, `property`, `end_header`",
            )?,
        }
    }
    let encoding = encoding.ok_or_else(|| {
        file.error_at(0, "the header does not state the format", "add the line `format ascii 1.0`")
    })?;
    Ok(Header { encoding, elements, body: at, textured })
}

/// What follows the word `property`.
fn property(words: &[&str]) -> Option<Property> {
    let (length, number, name) = match *words {
        ["list", length, number, name] => (Some(Number::named(length)?), number, name),
        [number, name] => (None, number, name),
        _ => return None,
    };
    if length.is_some_and(|length| !length.is_whole()) {
        return None;
    }
    Some(Property { name: name.to_owned(), number: Number::named(number)?, length })
}

/// The line at `at`, which moves past its end: `\n`, `\r\n`, or `\r` alone.
fn line<'a>(bytes: &'a [u8], at: &mut usize) -> Option<&'a [u8]> {
    let rest = &bytes[*at..];
    let length = rest.iter().position(|b| matches!(b, b'\n' | b'\r'))?;
    let end = if rest[length..].starts_with(b"\r\n") { 2 } else { 1 };
    *at += length + end;
    Some(&rest[..length])
}

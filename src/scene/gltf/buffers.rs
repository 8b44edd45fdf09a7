//! Bytes behind a glTF document: files beside it, data URIs, the binary part of a GLB. Each is read when first used.

use super::json::Root;
use crate::scene::error::SceneError;
use crate::scene::model_file::{ModelFile, shown};
use std::borrow::Cow;
use std::io::Read;
use std::path::Path;

/// All buffers of a document.
pub struct Buffers<'a> {
    file: ModelFile<'a>,
    bin: Option<&'a [u8]>,
    loaded: Vec<Option<Cow<'a, [u8]>>>,
}

impl<'a> Buffers<'a> {
    /// None is read yet.
    pub fn new(file: ModelFile<'a>, bin: Option<&'a [u8]>, root: &Root) -> Buffers<'a> {
        Buffers { file, bin, loaded: root.buffers.iter().map(|_| None).collect() }
    }

    /// The bytes of buffer view `index`, and its stride if it states one.
    pub fn view(&mut self, root: &Root, index: usize) -> Result<(&[u8], Option<usize>), SceneError> {
        let file = self.file;
        let view = root
            .buffer_views
            .get(index)
            .ok_or_else(|| missing(file, "buffer view", index, root.buffer_views.len()))?;
        if view.extensions.meshopt.is_some() && self.is_placeholder(root, view.buffer) {
            return Err(super::extensions::compressed(file, "EXT_meshopt_compression"));
        }
        let bytes = self.buffer(root, view.buffer)?;
        let range = view.byte_offset.checked_add(view.byte_length).map(|end| view.byte_offset..end);
        let bytes = range.and_then(|range| bytes.get(range)).ok_or_else(|| {
            file.error(
                format!("buffer view {index} reaches beyond buffer {}", view.buffer),
                "the file or its buffer is cut short or damaged: export or download it again",
            )
        })?;
        Ok((bytes, view.byte_stride.filter(|stride| *stride > 0)))
    }

    /// True for a buffer that stands for compressed data and has none itself.
    fn is_placeholder(&self, root: &Root, index: usize) -> bool {
        root.buffers.get(index).is_some_and(|b| b.uri.is_none()) && !(index == 0 && self.bin.is_some())
    }

    /// All bytes of buffer `index`.
    fn buffer(&mut self, root: &Root, index: usize) -> Result<&[u8], SceneError> {
        let file = self.file;
        let buffer =
            root.buffers.get(index).ok_or_else(|| missing(file, "buffer", index, root.buffers.len()))?;
        if self.loaded[index].is_none() {
            let bytes = match &buffer.uri {
                Some(uri) => {
                    Cow::Owned(resource(file, uri, Some(buffer.length), &format!("buffer {index}"))?)
                }
                // By the specification it is the first; a GLB has no other.
                None => Cow::Borrowed(self.bin.ok_or_else(|| {
                    file.error(
                        format!("buffer {index} has no `uri`, and the file has no binary part"),
                        "export the model again, as GLB or as glTF with its .bin file",
                    )
                })?),
            };
            self.loaded[index] = Some(bytes);
        }
        Ok(self.loaded[index].as_deref().unwrap_or_default())
    }
}

/// Item `index` of `count` is named, but there is none.
pub fn missing(file: ModelFile, what: &str, index: usize, count: usize) -> SceneError {
    file.error(
        format!("{what} {index} is named, but the file has {count} of them, from 0"),
        "the file is damaged: export it again",
    )
}

/// The bytes that `uri` names, the first `most` of them: a data URI, or a file relative to the document's folder.
pub fn resource(file: ModelFile, uri: &str, most: Option<usize>, what: &str) -> Result<Vec<u8>, SceneError> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (kind, text) = data.split_once(',').unwrap_or((data, ""));
        let bytes = if kind.ends_with(";base64") { base64(text.as_bytes()) } else { Some(percent(text)) };
        return bytes.ok_or_else(|| {
            file.error(format!("the data URI of {what} is no base64"), "the file is damaged: export it again")
        });
    }
    if uri.contains("://") {
        return Err(file.error(
            format!("{what} is at `{}`; nothing is fetched from a network", shown(uri)),
            "put the file beside the glTF file and name it there",
        ));
    }
    let folder = file.source.file.parent().unwrap_or(Path::new(""));
    let decoded = String::from_utf8_lossy(&percent(uri)).into_owned();
    let candidates = [decoded.clone(), uri.to_owned(), decoded.replace('\\', "/")];
    // Not every program escapes blanks and percent signs.
    let path = candidates.iter().map(|name| folder.join(name)).find(|path| path.is_file());
    let Some(path) = path else {
        let path = folder.join(&decoded);
        return Err(file.error(
            format!("{what} is in `{}`, but there is no such file", shown(&path.display().to_string())),
            "put the file there; a glTF file needs all the files that came with it",
        ));
    };
    let mut bytes = Vec::new();
    let read = std::fs::File::open(&path)
        .and_then(|f| f.take(most.map_or(u64::MAX, |most| most as u64)).read_to_end(&mut bytes));
    match read {
        Ok(_) => Ok(bytes),
        Err(cause) => {
            let message = format!("{what}: `{}` cannot be read", shown(&path.display().to_string()));
            let error = file.error(message, "give permission to read it");
            Err(SceneError { cause: Some(cause), ..error })
        }
    }
}

/// Resolves `%20` and the like.
fn percent(text: &str) -> Vec<u8> {
    let bytes = text.as_bytes();
    let digit = |at: usize| bytes.get(at).and_then(|b| char::from(*b).to_digit(16));
    let mut decoded = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        match (bytes[at], digit(at + 1), digit(at + 2)) {
            (b'%', Some(high), Some(low)) => {
                decoded.push((high * 16 + low) as u8);
                at += 3;
            }
            (byte, ..) => {
                decoded.push(byte);
                at += 1;
            }
        }
    }
    decoded
}

/// Decodes base64 (RFC 4648, both alphabets), with or without padding.
fn base64(text: &[u8]) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3 + 3);
    let (mut bits, mut held) = (0u32, 0);
    for &b in text {
        let six = match b {
            b'A'..=b'Z' => b - b'A',
            b'a'..=b'z' => b - b'a' + 26,
            b'0'..=b'9' => b - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            b'=' => break,
            _ if b.is_ascii_whitespace() => continue,
            _ => return None,
        };
        bits = bits << 6 | u32::from(six);
        held += 6;
        if held >= 8 {
            held -= 8;
            bytes.push((bits >> held) as u8);
        }
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_of_the_standard() {
        // RFC 4648, section 10.
        for (text, bytes) in
            [("", ""), ("Zg==", "f"), ("Zm8=", "fo"), ("Zm9v", "foo"), ("Zm9vYmFy", "foobar")]
        {
            assert_eq!(base64(text.as_bytes()).unwrap(), bytes.as_bytes());
        }
        assert_eq!(base64(b"_-8").unwrap(), base64(b"/+8=").unwrap());
        assert_eq!(base64(b"Zm9v!"), None);
    }

    #[test]
    fn percent_signs() {
        assert_eq!(percent("a%20b%2"), b"a b%2");
    }
}

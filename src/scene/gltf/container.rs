//! From a file's bytes to its JSON and the binary part of a GLB.

use super::json::Root;
use crate::scene::error::SceneError;
use crate::scene::model_file::{ModelFile, shown};

/// Bytes of a GLB's header: magic, version, length.
const HEADER: usize = 12;
/// Types of chunks, "JSON" and "BIN\0".
const JSON: u32 = 0x4e4f_534a;
const BIN: u32 = 0x004e_4942;

/// The document, and the first binary chunk if it is a GLB that has one.
pub fn open<'a>(file: ModelFile<'a>) -> Result<(Root, Option<&'a [u8]>), SceneError> {
    let bytes = file.source.text;
    let glb = bytes.starts_with(b"glTF");
    let (json, bin) = if glb { chunks(file, bytes)? } else { (bytes, None) };
    let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
    // Chunks are filled up with blanks; some programs take zeros.
    let end = json.iter().rposition(|b| *b != 0).map_or(0, |at| at + 1);
    let json = &json[..end];
    let root: Root = serde_json::from_slice(json).map_err(|e| wrong_json(file, json, glb, &e))?;
    match root.asset.version.as_str() {
        version if version == "2" || version.starts_with("2.") => Ok((root, bin)),
        version if version.starts_with('1') => Err(version_1(file)),
        "" => Err(file.error("no glTF file: it has no `asset.version`", "export the model as glTF 2.0")),
        version => Err(file
            .error(format!("glTF version `{}` is not read", shown(version)), "export the model as glTF 2.0")),
    }
}

/// Divides a GLB into its JSON and its binary chunk.
fn chunks<'a>(file: ModelFile<'a>, bytes: &'a [u8]) -> Result<(&'a [u8], Option<&'a [u8]>), SceneError> {
    match word(bytes, 4) {
        Some(2) => {}
        Some(1) => return Err(version_1(file)),
        Some(version) => {
            return Err(
                file.error(format!("GLB version {version} is not read"), "export the model as glTF 2.0")
            );
        }
        None => return Err(cut_short(file)),
    }
    let (mut json, mut bin) = (None, None);
    let mut at = HEADER;
    while let (Some(length), Some(kind)) = (word(bytes, at), word(bytes, at + 4)) {
        let start = at + 8;
        let rest = bytes.get(start..).unwrap_or_default();
        let Some(chunk) = rest.get(..length as usize) else { return Err(cut_short(file)) };
        match kind {
            JSON if json.is_none() => json = Some(chunk),
            BIN if bin.is_none() => bin = Some(chunk),
            _ => {}
        }
        // Chunks begin at multiples of four bytes.
        at = start + chunk.len().next_multiple_of(4);
    }
    match json {
        Some(json) => Ok((json, bin)),
        None => Err(cut_short(file)),
    }
}

/// The little-endian word at byte `at`.
fn word(bytes: &[u8], at: usize) -> Option<u32> {
    let bytes = bytes.get(at..)?.first_chunk::<4>()?;
    Some(u32::from_le_bytes(*bytes))
}

fn cut_short(file: ModelFile) -> SceneError {
    file.error(
        "the GLB ends before the lengths that it states",
        "it is cut short or damaged: export or download it again",
    )
}

fn version_1(file: ModelFile) -> SceneError {
    file.error(
        "a file of glTF 1.0, whose materials are programs for WebGL",
        "convert it to 2.0: `npx gltf-pipeline@4 -i old.gltf -o new.gltf`",
    )
}

/// The JSON does not parse, or has a wrong type somewhere.
fn wrong_json(file: ModelFile, json: &[u8], glb: bool, error: &serde_json::Error) -> SceneError {
    // Version 1 has other types nearly everywhere, so it rarely comes as far as its version.
    let value = serde_json::from_slice::<serde_json::Value>(json).unwrap_or_default();
    let version = &value["asset"]["version"];
    if version.to_string().trim_start_matches('"').starts_with('1') {
        return version_1(file);
    }
    // serde_json ends its message with the place, which is told apart here.
    let text = error.to_string();
    let message = text.split(" at line ").next().unwrap_or(&text);
    let (line, column) = (error.line(), error.column());
    let place = if glb { format!(" (line {line}, column {column} of its JSON)") } else { String::new() };
    let wrong = file.error(
        format!("its JSON is no glTF 2.0: {}{place}", shown_long(message)),
        "correct the file, or export the model again; https://github.khronos.org/glTF-Validator lists all mistakes",
    );
    if glb { wrong } else { SceneError { line, column, ..wrong } }
}

/// A message that may quote the file.
fn shown_long(message: &str) -> String {
    message
        .chars()
        .take(200)
        .flat_map(|c| if c.is_control() { c.escape_default().collect() } else { vec![c] })
        .collect()
}

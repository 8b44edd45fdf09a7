//! OBJ meshes: `v`, `vn`, `f` (any number of corners; negative indices), `s`, `mtllib`, `usemtl`, and `o` and `g` where a
//! part is asked for. What the format has beyond that is skipped.
//!
//! A text becomes a [`raw::Raw`], by pieces side by side or from start to end, and that a mesh.

mod chunks;
mod materials;
mod raw;
mod serial;
mod smooth;

pub(super) use raw::is_flat;

use super::error::{SceneError, Source};
use super::library::Library;
use super::model::{Model, Wanted};
use super::notes::Reading;
use super::{Mesh, text};

/// Reads an OBJ text and puts what is wanted of it in its place.
pub(super) fn read(
    source: Source,
    wanted: Wanted,
    library: &mut Library,
    reading: &mut Reading,
) -> Result<Model, SceneError> {
    let lines = text::lines(source, wanted.object)?;
    let source = Source { text: &lines, ..source };
    let mesh = match in_pieces(source, wanted, library, reading, chunks::PIECE)? {
        Some(mesh) => Some(mesh),
        None => from_start(source, wanted, library, reading)?,
    };
    Ok(Model { meshes: mesh.into_iter().collect(), ..Model::default() })
}

/// Reads the text in pieces of some `piece` bytes; none if it is small, or if it holds what only the other reader reads.
fn in_pieces(
    source: Source,
    wanted: Wanted,
    library: &mut Library,
    reading: &mut Reading,
    piece: usize,
) -> Result<Option<Mesh>, SceneError> {
    if source.text.len() <= piece || wanted.node.is_some() {
        return Ok(None);
    }
    let notes = reading.notes.clone();
    match chunks::read(source, wanted, library, reading, piece)? {
        Some(raw) => raw.mesh(source, wanted.object, wanted.place.mirrors(), reading).map(Some),
        None => {
            // The other reader says it again.
            reading.notes = notes;
            Ok(None)
        }
    }
}

/// Reads the text from its start to its end or its first mistake; none if it has nothing but lines, points or curves.
fn from_start(
    source: Source,
    wanted: Wanted,
    library: &mut Library,
    reading: &mut Reading,
) -> Result<Option<Mesh>, SceneError> {
    let notes = reading.notes.clone();
    let raw = serial::read(source, wanted, library, reading, None)?;
    let raw = if raw.is_in_range() {
        raw
    } else {
        // Once more, with the number of vertices known: the first face that is wrong is the error.
        reading.notes = notes;
        serial::read(source, wanted, library, reading, Some(raw.vertices.len()))?
    };
    if raw.faces.is_empty() {
        return Ok(None);
    }
    raw.mesh(source, wanted.object, wanted.place.mirrors(), reading).map(Some)
}

#[cfg(test)]
mod tests;

//! STL meshes, binary and ASCII: triangles with a normal each, which is ignored for the triangle's own, and without
//! a material. Corners at the same position become one vertex, so that a closed surface is closed.
//!
//! A binary file may begin with `solid` as well, so the size decides: 84 bytes and 50 for each of the number of facets
//! at byte 80.

use super::error::SceneError;
use super::library::Library;
use super::material;
use super::mesh_builder::MeshBuilder;
use super::model::{Model, Wanted};
use super::model_file::{ModelFile, shown};
use super::notes::Reading;
use super::plain_words::PlainWords;
use glam::DVec3;
use std::collections::HashMap;

/// Bytes before the facets of a binary file: 80 of anything, then their number.
const HEADER: usize = 84;
/// Bytes of a facet: twelve floats, two bytes of attributes.
const FACET: usize = 50;

/// Number of facets that a binary file's header states.
fn stated(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(80..HEADER)?;
    Some(u32::from_le_bytes([count[0], count[1], count[2], count[3]]) as usize)
}

/// True if the size is just that of a binary file with one or more facets.
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    stated(bytes).is_some_and(|n| n > 0 && bytes.len() == HEADER + FACET * n)
}

/// True if it begins as an ASCII file does.
pub(super) fn is_ascii(bytes: &[u8]) -> bool {
    let start = bytes.trim_ascii_start();
    start.len() >= 5 && start[..5].eq_ignore_ascii_case(b"solid") && {
        // Names and comments of any length may come first, but not binary ones.
        let head = &start[..start.len().min(4096)];
        !head.contains(&0) && (head.windows(5).any(|w| w.eq_ignore_ascii_case(b"facet")) || ends_empty(start))
    }
}

/// True for a text that ends its solid without a facet.
fn ends_empty(text: &[u8]) -> bool {
    text.len() < 4096 && text.windows(8).any(|w| w.eq_ignore_ascii_case(b"endsolid"))
}

/// Corners by their position.
struct Corners {
    builder: MeshBuilder,
    known: HashMap<[u64; 3], u32>,
}

impl Corners {
    fn index(&mut self, position: DVec3) -> u32 {
        // 0 and -0 are one place.
        let key = (position + DVec3::ZERO).to_array().map(f64::to_bits);
        let next = self.builder.vertex_count() as u32;
        let index = *self.known.entry(key).or_insert(next);
        if index == next {
            self.builder.vertex(position);
        }
        index
    }
}

/// Reads an STL file.
pub(super) fn read(
    file: ModelFile,
    wanted: Wanted,
    library: &mut Library,
    reading: &mut Reading,
) -> Result<Model, SceneError> {
    let bytes = file.source.text;
    let material = match wanted.material {
        Some(material) => material,
        None => {
            file.assume(
                reading,
                1,
                "STL files have no materials: it gets the default one, diffuse 0.8",
                "give `material` in the scene's [[mesh]]",
            )?;
            library.materials.push(material::plain("default"));
            library.materials.len() - 1
        }
    };
    let mut corners = Corners { builder: MeshBuilder::new(wanted.place), known: HashMap::new() };
    if !is_binary(bytes) && is_ascii(bytes) {
        ascii(file, material, &mut corners)?;
    } else {
        binary(file, material, &mut corners, reading)?;
    }
    let (mesh, lost) = corners.builder.finish(file.source.file.display().to_string());
    file.assume(
        reading,
        lost,
        "facets with a corner that is not finite are left out",
        "export the file again, or repair it",
    )?;
    if mesh.faces.is_empty() {
        return Err(file.error("the file has no facets", "export the model as triangles"));
    }
    Ok(Model { meshes: vec![mesh], ..Model::default() })
}

fn binary(
    file: ModelFile,
    material: usize,
    corners: &mut Corners,
    reading: &mut Reading,
) -> Result<(), SceneError> {
    let bytes = file.source.text;
    let Some(stated) = stated(bytes) else {
        return Err(file.error(
            format!(
                "{} bytes are no STL file: a binary one has 84 or more, a text begins with `solid`",
                bytes.len()
            ),
            "export the model as STL again",
        ));
    };
    let held = (bytes.len() - HEADER) / FACET;
    // Programs that write as they go leave 0 or all ones.
    let open = stated == 0 || stated == u32::MAX as usize;
    if stated > held && !open {
        return Err(file.error(
            format!("the header announces {stated} facets, but the file ends after {held}"),
            "the file is cut short, or no STL file: export or download it again",
        ));
    }
    let count = if open { held } else { stated };
    let rest = bytes.len() - HEADER - FACET * count;
    let remedy = "export the file again";
    if open && held > 0 {
        file.assume(reading, 1, "the header states no number of facets: all are read", remedy)?;
    }
    if rest > 0 {
        file.assume(reading, 1, &format!("{rest} bytes after the last facet are skipped"), remedy)?;
    }
    let facets = bytes[HEADER..].chunks_exact(FACET).take(count);
    let mut coloured = 0;
    for facet in facets {
        let float = |i: usize| {
            let b = &facet[4 * i..];
            f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
        };
        let three = [3, 6, 9].map(|i| corners.index(DVec3::new(float(i), float(i + 1), float(i + 2))));
        corners.builder.triangle(three, None, material);
        coloured += usize::from(facet[48..] != [0, 0]);
    }
    file.assume(
        reading,
        coloured,
        "facets have attribute bytes (colours, in some programs), which are not read",
        "give `material` in the scene's [[mesh]], or export the colours as PLY or glTF",
    )
}

fn ascii(file: ModelFile, material: usize, corners: &mut Corners) -> Result<(), SceneError> {
    let mut words = PlainWords { file, at: 0 };
    let mut facet: Option<(usize, Vec<u32>)> = None;
    while let Some(word) = words.next() {
        match word.bytes.to_ascii_lowercase().as_slice() {
            b"solid" | b"endsolid" => words.end_line(),
            b"facet" => facet = Some((word.offset, Vec::with_capacity(3))),
            b"normal" => {
                for _ in 0..3 {
                    words.next();
                }
            }
            b"outer" | b"loop" | b"endloop" => {}
            b"vertex" => {
                let mut position = [0.0; 3];
                for x in &mut position {
                    let number = words.next().ok_or_else(|| ended(file))?;
                    *x = words.number(number)?;
                }
                let Some((_, facet)) = &mut facet else {
                    return Err(file.error_at(
                        word.offset,
                        "a vertex outside a facet",
                        "put it between `facet normal 0 0 1` and `endfacet`",
                    ));
                };
                facet.push(corners.index(DVec3::from_array(position)));
            }
            b"endfacet" => {
                let (offset, facet) = facet.take().unwrap_or((word.offset, Vec::new()));
                if facet.len() < 3 {
                    return Err(file.error_at(
                        offset,
                        format!("a facet with {} vertices", facet.len()),
                        "a facet needs three",
                    ));
                }
                corners.builder.polygon(&facet, None, material);
            }
            _ => {
                let text = String::from_utf8_lossy(word.bytes);
                return Err(file.error_at(
                    word.offset,
                    format!("unknown word `{}`", shown(&text)),
                    "use `solid`, `facet normal`, `outer loop`, `vertex`, `endloop`, `endfacet`, `endsolid`",
                ));
            }
        }
    }
    if facet.is_some() { Err(ended(file)) } else { Ok(()) }
}

fn ended(file: ModelFile) -> SceneError {
    file.error_at(
        file.source.text.len(),
        "the file ends inside a facet",
        "it is cut short: export or download it again",
    )
}

#[cfg(test)]
mod tests;

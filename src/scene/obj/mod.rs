//! OBJ meshes: `v`, `vn`, `f` (any number of corners, fanned from the first; negative indices),
//! `mtllib`, `usemtl`. Texture coordinates, groups, lines and points are skipped.

mod chunks;

use super::error::{SceneError, Source, did_you_mean};
use super::library::Library;
use super::polygon::NORMAL_LEAN;
use super::table::{MAX_LENGTH, unit};
use super::tokens::{Word, Words};
use super::{Face, Mesh, Transform};
use glam::DVec3;
use std::path::{Path, PathBuf};

/// Statements that say nothing about a surface's shape or material.
const SKIPPED: [&[u8]; 16] = [
    b"vt",
    b"o",
    b"g",
    b"s",
    b"l",
    b"p",
    b"mg",
    b"bevel",
    b"c_interp",
    b"d_interp",
    b"lod",
    b"usemap",
    b"maplib",
    b"shadow_obj",
    b"trace_obj",
    b"vp",
];

/// Statements of curves and free-form surfaces.
const FREE_FORM: [&[u8]; 6] = [b"cstype", b"deg", b"bmat", b"curv", b"curv2", b"surf"];

/// One corner of a face: vertex and normal, from 0.
type Corner = (u32, Option<u32>);

struct Reader<'a> {
    words: Words<'a>,
    place: Transform,
    /// The scene's material for the whole mesh.
    whole: Option<usize>,
    /// The material of the last `usemtl`.
    current: Option<usize>,
    libraries: Vec<PathBuf>,
    library: &'a mut Library,
    vertices: Vec<DVec3>,
    normals: Vec<DVec3>,
    faces: Vec<Face>,
    /// Corners of the face being read.
    corners: Vec<Corner>,
}

/// Reads an OBJ text and puts it in its `place`. `whole` is the material that the scene gives it; where
/// absent, the MTL files' are used.
pub(super) fn read(
    source: Source,
    object: &str,
    whole: Option<usize>,
    place: Transform,
    library: &mut Library,
) -> Result<Mesh, SceneError> {
    if source.text.len() > chunks::PIECE
        && let Some(mesh) = chunks::read(source, whole, place, library, chunks::PIECE)
    {
        return Ok(mesh);
    }
    read_whole(source, object, whole, place, library)
}

/// Reads the text from its start to its end or its first mistake.
fn read_whole(
    source: Source,
    object: &str,
    whole: Option<usize>,
    place: Transform,
    library: &mut Library,
) -> Result<Mesh, SceneError> {
    let mut reader = Reader::new(Words::new(source, object.to_owned()), whole, place, library);
    while let Some(keyword) = reader.words.keyword() {
        reader.statement(keyword)?;
        reader.words.end_line();
    }
    let Reader { vertices, mut normals, faces, words, .. } = reader;
    if faces.is_empty() {
        return Err(words.error(0, "the mesh has no faces", "add faces such as `f 1 2 3`"));
    }
    if faces.iter().all(|face| face.normals.is_none()) {
        normals = Vec::new();
    }
    Ok(Mesh { name: source.file.display().to_string(), vertices, normals, faces })
}

/// Follows the `usemtl` or `mtllib` at byte `offset`: changes the material in use and the files it is looked
/// for in.
fn library_statement(
    source: Source,
    offset: usize,
    current: &mut Option<usize>,
    libraries: &mut Vec<PathBuf>,
    library: &mut Library,
) -> Result<(), SceneError> {
    let unplaced = Transform::new(1.0, DVec3::ZERO, DVec3::ZERO);
    let mut reader = Reader::new(Words::starting(source, String::new(), offset), None, unplaced, library);
    reader.current = *current;
    reader.libraries = std::mem::take(libraries);
    if let Some(keyword) = reader.words.keyword() {
        reader.statement(keyword)?;
    }
    (*current, *libraries) = (reader.current, reader.libraries);
    Ok(())
}

/// True if the three normals are one that agrees with the triangle's plane up to its digits: the
/// plane's own normal, which is exact, then says it better.
pub(super) fn is_flat(
    vertices: &[DVec3],
    normals: &[DVec3],
    corners: [u32; 3],
    corner_normals: [u32; 3],
) -> bool {
    if corner_normals[0] != corner_normals[1] || corner_normals[0] != corner_normals[2] {
        return false;
    }
    let [a, b, c] = corners.map(|i| vertices[i as usize]);
    let size = (b - a).abs().max((c - a).abs()).max_element();
    unit(((b - a) / size).cross((c - a) / size))
        .is_some_and(|plane| plane.cross(normals[corner_normals[0] as usize]).length() <= NORMAL_LEAN)
}

impl<'a> Reader<'a> {
    fn new(words: Words<'a>, whole: Option<usize>, place: Transform, library: &'a mut Library) -> Reader<'a> {
        Reader {
            words,
            place,
            whole,
            current: whole,
            libraries: Vec::new(),
            library,
            vertices: Vec::new(),
            normals: Vec::new(),
            faces: Vec::new(),
            corners: Vec::new(),
        }
    }

    fn statement(&mut self, keyword: Word) -> Result<(), SceneError> {
        match keyword.bytes {
            b"v" => self.vertex(keyword),
            b"f" => self.face(keyword),
            b"vn" => self.normal(keyword),
            b"usemtl" if self.whole.is_none() => self.use_material(keyword),
            b"mtllib" if self.whole.is_none() => self.open_library(keyword),
            b"usemtl" | b"mtllib" => Ok(()),
            other if SKIPPED.contains(&other) => Ok(()),
            other if FREE_FORM.contains(&other) => Err(self.words.error(
                keyword.offset,
                format!("`{}`: free-form curves and surfaces are not supported", keyword.text()),
                "export the mesh as triangles",
            )),
            _ => {
                let name = keyword.text();
                let near = did_you_mean(&name, ["v", "vn", "vt", "f", "o", "g", "usemtl", "mtllib"]);
                Err(self.words.error(
                    keyword.offset,
                    format!("unknown statement `{name}`{near}"),
                    "use `v`, `vn`, `vt`, `f`, `usemtl`, `mtllib`, or start a comment with `#`",
                ))
            }
        }
    }

    fn vertex(&mut self, keyword: Word) -> Result<(), SceneError> {
        let vertex = self.place.point(self.words.vector(keyword)?);
        if vertex.abs().max_element() > MAX_LENGTH {
            return Err(self.words.error(
                keyword.offset,
                format!("the mesh's `scale` and `translate` put this vertex beyond {MAX_LENGTH:e}"),
                "use a larger unit of length",
            ));
        }
        // A weight or a colour may follow: neither has a meaning here.
        self.vertices.push(vertex);
        Ok(())
    }

    fn normal(&mut self, keyword: Word) -> Result<(), SceneError> {
        let Some(normal) = unit(self.words.vector(keyword)?) else {
            return Err(self.words.error(
                keyword.offset,
                "a normal of length 0",
                "write a direction, or remove the normals from the faces that use it",
            ));
        };
        self.normals.push(self.place.normal(normal));
        Ok(())
    }

    fn face(&mut self, keyword: Word) -> Result<(), SceneError> {
        let Some(material) = self.current else {
            return Err(self.words.error(
                keyword.offset,
                "a face without a material",
                "put `usemtl NAME` above it, or give `material` in the scene's [[mesh]]",
            ));
        };
        let mut corners = std::mem::take(&mut self.corners);
        corners.clear();
        while let Some(word) = self.words.word() {
            corners.push(self.corner(word)?);
        }
        if corners.len() < 3 {
            return Err(self.words.error(
                keyword.offset,
                format!("a face with {} corners", corners.len()),
                "a face needs at least three, `f 1 2 3`",
            ));
        }
        let with_normals = corners.iter().filter(|c| c.1.is_some()).count();
        if with_normals != 0 && with_normals != corners.len() {
            return Err(self.words.error(
                keyword.offset,
                "only some corners of this face have normals",
                "give all corners a normal (`v//n`), or none",
            ));
        }
        for i in 1..corners.len() - 1 {
            let (a, b, c) = (corners[0], corners[i], corners[i + 1]);
            let vertices = [a.0, b.0, c.0];
            let normals = match (a.1, b.1, c.1) {
                (Some(a), Some(b), Some(c))
                    if !is_flat(&self.vertices, &self.normals, vertices, [a, b, c]) =>
                {
                    Some([a, b, c])
                }
                _ => None,
            };
            self.faces.push(Face { vertices, normals, material });
        }
        self.corners = corners;
        Ok(())
    }

    /// `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    fn corner(&self, word: Word) -> Result<Corner, SceneError> {
        let mut parts = word.bytes.split(|b| *b == b'/');
        let vertex = parts.next().unwrap_or_default();
        let texture = parts.next().unwrap_or_default();
        let normal = parts.next();
        if parts.next().is_some() || (!texture.is_empty() && integer(texture).is_none()) {
            return Err(self.bad_corner(word));
        }
        let vertex = self.index(word, vertex, self.vertices.len(), "vertex")?;
        let normal = match normal {
            Some(normal) => Some(self.index(word, normal, self.normals.len(), "normal")?),
            None => None,
        };
        Ok((vertex, normal))
    }

    fn bad_corner(&self, word: Word) -> SceneError {
        self.words.error(
            word.offset,
            format!("`{}` is no corner", word.text()),
            "write it as `3`, `3/1`, `3//2` or `3/1/2`: numbers of the vertex, texture coordinate, normal",
        )
    }

    /// Turns the index written in `digits`, from 1 or backward from -1, into one from 0.
    fn index(&self, word: Word, digits: &[u8], count: usize, what: &str) -> Result<u32, SceneError> {
        let written = integer(digits).ok_or_else(|| self.bad_corner(word))?;
        let index = match written {
            1.. => Some(written - 1),
            0 => None,
            _ => Some(written + count as i64),
        };
        let index = index.filter(|i| (0..count as i64).contains(i)).and_then(|i| u32::try_from(i).ok());
        index.ok_or_else(|| {
            let message = match written {
                0 => format!("{what} 0: numbers start at 1"),
                _ => format!("{what} {written} of {count}: there is none above this line"),
            };
            let remedy = match count {
                0 => format!("write each {what} above the faces that use it"),
                _ => format!("write a number from 1 to {count}, or from -{count} to -1"),
            };
            self.words.error(word.offset, message, remedy)
        })
    }

    fn use_material(&mut self, keyword: Word) -> Result<(), SceneError> {
        let Some(name) = self.words.rest() else {
            return Err(self.words.error(keyword.offset, "`usemtl` without a name", "write `usemtl NAME`"));
        };
        self.current = self.library.find(&self.libraries, &name.text());
        if self.current.is_some() {
            return Ok(());
        }
        let (near, names) = self.library.proposals(&self.libraries, &name.text());
        let remedy = match names.as_str() {
            "" => "put `mtllib FILE.mtl` above it, or give `material` in the scene's [[mesh]]".to_owned(),
            names => format!("use one of {names}, or give `material` in the scene's [[mesh]]"),
        };
        Err(self.words.error(
            name.offset,
            format!("no material `{}` in the MTL files named above{near}", name.text()),
            remedy,
        ))
    }

    fn open_library(&mut self, keyword: Word) -> Result<(), SceneError> {
        let Some(first) = self.words.word() else {
            return Err(self.words.error(
                keyword.offset,
                "`mtllib` without a file",
                "write `mtllib FILE.mtl`",
            ));
        };
        let mut files = vec![first];
        while let Some(word) = self.words.word() {
            files.push(word);
        }
        let folder = self.words.source.file.parent().unwrap_or(Path::new(""));
        // Several files may be named, but one name may hold blanks as well.
        let last = files[files.len() - 1];
        let whole = &self.words.source.text[first.offset..last.offset + last.bytes.len()];
        let whole = Word { bytes: whole, offset: first.offset };
        if folder.join(whole.text()).is_file() {
            files = vec![whole];
        }
        for file in files {
            let path = folder.join(file.text());
            if !path.is_file() {
                return Err(self.words.error(
                    file.offset,
                    format!("there is no file `{}`", path.display()),
                    "correct the path (it starts at this file's folder), or give `material` in the [[mesh]]",
                ));
            }
            self.library.open(&path)?;
            self.libraries.push(path);
        }
        Ok(())
    }
}

/// A decimal integer with an optional sign.
fn integer(digits: &[u8]) -> Option<i64> {
    let (negative, digits) = match digits {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        all => (false, all),
    };
    // 18 digits cannot overflow an i64.
    if digits.is_empty() || digits.len() > 18 {
        return None;
    }
    let mut value = 0;
    for &digit in digits {
        if !digit.is_ascii_digit() {
            return None;
        }
        value = value * 10 + i64::from(digit - b'0');
    }
    Some(if negative { -value } else { value })
}

#[cfg(test)]
mod tests;

//! Reads a whole text, statement by statement: whatever is in it, with the errors and their places.

use super::materials::Materials;
use super::raw::{NO_NORMAL, Polygon, Raw, WRONG_NORMAL};
use crate::scene::error::{SceneError, Source, did_you_mean, list};
use crate::scene::library::Library;
use crate::scene::model::Wanted;
use crate::scene::notes::Reading;
use crate::scene::table::{MAX_LENGTH, unit};
use crate::scene::tokens::{Word, Words, name};
use crate::scene::{Face, Transform};
use glam::DVec3;

/// Statements that say nothing about a surface's shape or material.
const SKIPPED: [&[u8]; 15] = [
    b"vt",
    b"o",
    b"g",
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
const FREE_FORM: [&[u8]; 15] = [
    b"cstype", b"deg", b"bmat", b"step", b"curv", b"curv2", b"surf", b"parm", b"trim", b"hole", b"scrv",
    b"sp", b"end", b"con", b"ctech",
];

/// One corner of a face: vertex and normal, from 0.
type Corner = (u32, Option<u32>);

struct Reader<'a, 'b> {
    words: Words<'a>,
    place: Transform,
    materials: Materials<'b>,
    reading: &'b mut Reading,
    raw: Raw,
    /// Corners of the face being read.
    corners: Vec<Corner>,
    /// How many vertices there are in all, once that is known.
    total: Option<usize>,
    part: Option<Part<'b>>,
    /// Lines, points, curves were met.
    other_shapes: bool,
}

/// The part of a file that is wanted.
struct Part<'a> {
    name: &'a str,
    /// Faces are in it now, by `o`; by `g`.
    now: [bool; 2],
    /// Was met.
    found: bool,
    /// Other names, for a proposal; of many the first.
    others: Vec<String>,
}

/// Names that are kept for a proposal.
const PROPOSED: usize = 1000;

/// Reads the text. `total` is the number of its vertices where that is known from an earlier reading: faces that name others
/// are errors then. Where it is not, they may name what comes later.
pub(super) fn read(
    source: Source,
    wanted: Wanted,
    library: &mut Library,
    reading: &mut Reading,
    total: Option<usize>,
) -> Result<Raw, SceneError> {
    let part = wanted.node.map(|name| Part { name, now: [false; 2], found: false, others: Vec::new() });
    let mut reader = Reader {
        words: Words::new(source, wanted.object.to_owned()),
        place: wanted.place,
        materials: Materials::new(wanted.material, library),
        reading,
        raw: Raw { complete: part.is_none(), ..Raw::default() },
        corners: Vec::new(),
        total,
        part,
        other_shapes: false,
    };
    while let Some(keyword) = reader.words.keyword() {
        reader.statement(keyword)?;
        reader.words.end_line();
    }
    reader.finish()
}

impl Reader<'_, '_> {
    fn finish(mut self) -> Result<Raw, SceneError> {
        if let Some(part) = self.part.as_ref().filter(|part| !part.found) {
            let near = did_you_mean(part.name, part.others.iter().map(String::as_str));
            let message = format!("the file has no object or group `{}`{near}", part.name);
            let remedy = match list(part.others.iter().map(String::as_str)) {
                none if none.is_empty() => "leave out `node`: the file names no parts".to_owned(),
                names => format!("use one of {names}"),
            };
            return Err(self.words.error(0, message, remedy));
        }
        if self.raw.faces.is_empty() {
            let (message, remedy) = ("the mesh has no faces", "add faces such as `f 1 2 3`");
            if !self.other_shapes {
                return Err(self.words.error(0, message, remedy));
            }
            self.assume(0, "the file has no faces, only lines, points or curves", remedy)?;
        }
        Ok(self.raw)
    }

    /// Notes `message` at byte `offset`, or fails with it if the reading is strict.
    fn assume(&mut self, offset: usize, message: &str, remedy: &str) -> Result<(), SceneError> {
        self.reading.assume(self.words.source, offset, &self.words.object, message, remedy)
    }

    fn statement(&mut self, keyword: Word) -> Result<(), SceneError> {
        match keyword.bytes {
            b"v" => self.vertex(keyword),
            b"f" => self.face(keyword),
            b"vn" => self.normal(keyword),
            b"s" => {
                self.group();
                Ok(())
            }
            b"usemtl" | b"mtllib" => self.materials.statement(&mut self.words, keyword, self.reading),
            b"o" | b"g" => {
                self.enter(keyword);
                Ok(())
            }
            b"l" | b"p" => {
                self.other_shapes = true;
                Ok(())
            }
            other if SKIPPED.contains(&other) => Ok(()),
            other if FREE_FORM.contains(&other) => {
                self.other_shapes = true;
                if self.reading.strict {
                    return Err(self.words.error(
                        keyword.offset,
                        format!("`{}`: free-form curves and surfaces are not supported", keyword.text()),
                        "export the mesh as triangles",
                    ));
                }
                let message = "statements of free-form curves and surfaces are skipped";
                self.reading.count(self.words.source, keyword.offset, message, 1);
                Ok(())
            }
            _ => self.unknown(keyword),
        }
    }

    fn unknown(&mut self, keyword: Word) -> Result<(), SceneError> {
        if self.reading.strict {
            let name = keyword.text();
            let near = did_you_mean(&name, ["v", "vn", "vt", "f", "o", "g", "usemtl", "mtllib"]);
            return Err(self.words.error(
                keyword.offset,
                format!("unknown statement `{name}`{near}"),
                "use `v`, `vn`, `vt`, `f`, `usemtl`, `mtllib`, or start a comment with `#`",
            ));
        }
        self.reading.count(self.words.source, keyword.offset, "unknown statements are skipped", 1);
        Ok(())
    }

    /// Follows `o` and `g`: an object ends the groups of the one before it.
    fn enter(&mut self, keyword: Word) {
        let Some(part) = &mut self.part else { return };
        let by_object = keyword.bytes == b"o";
        let line = self.words.line().map_or(&b""[..], |line| line.bytes);
        let wanted = part.name.as_bytes();
        let here = line == wanted || (!by_object && line.split(u8::is_ascii_whitespace).any(|w| w == wanted));
        part.now = if by_object { [here, false] } else { [part.now[0], here] };
        part.found |= here;
        if !here && part.others.len() < PROPOSED {
            part.others.push(name(line));
        }
    }

    fn group(&mut self) {
        // A group is a number; `off` is 0. Whatever else there is means that there is a group.
        let group = match self.words.word().map_or(&b"0"[..], |word| word.bytes) {
            b"off" => 0,
            digits => integer(digits).map_or(1, |group| group as u32),
        };
        let at = self.raw.faces.len();
        self.raw.groups.push((at, group));
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
        self.raw.vertices.push(vertex);
        Ok(())
    }

    /// Normals without a direction matter only to the faces that use them.
    fn normal(&mut self, keyword: Word) -> Result<(), SceneError> {
        let normal = match self.words.vector(keyword) {
            Ok(written) => unit(written),
            Err(error) if self.reading.strict => return Err(error),
            Err(_) => None,
        };
        if normal.is_none() && self.reading.strict {
            return Err(self.words.error(
                keyword.offset,
                "a normal of length 0",
                "write a direction, or remove the normals from the faces that use it",
            ));
        }
        self.raw.normals.push(normal.map_or(DVec3::NAN, |normal| self.place.normal(normal)));
        Ok(())
    }

    fn face(&mut self, keyword: Word) -> Result<(), SceneError> {
        if self.reading.strict {
            // Before its corners are looked at: the material is what is missing first.
            let (source, object) = (self.words.source, &self.words.object);
            self.materials.of_faces(source, keyword.offset, object, 0, self.reading)?;
        }
        let mut corners = std::mem::take(&mut self.corners);
        corners.clear();
        while let Some(word) = self.words.word() {
            corners.push(self.corner(word)?);
        }
        if corners.len() < 3 {
            let message = match self.reading.strict {
                true => format!("a face with {} corners", corners.len()),
                false => "faces of less than three corners are skipped".to_owned(),
            };
            self.corners = corners;
            self.other_shapes = true;
            return self.assume(keyword.offset, &message, "a face needs at least three, `f 1 2 3`");
        }
        let with_normals = corners.iter().filter(|c| c.1.is_some()).count();
        let partly = with_normals != 0 && with_normals != corners.len();
        if partly && self.reading.strict {
            return Err(self.words.error(
                keyword.offset,
                "only some corners of this face have normals",
                "give all corners a normal (`v//n`), or none",
            ));
        }
        if self.part.as_ref().is_none_or(|part| part.now != [false; 2]) {
            self.fan(keyword, &corners, with_normals > 0)?;
        }
        self.corners = corners;
        Ok(())
    }

    fn fan(&mut self, keyword: Word, corners: &[Corner], with_normals: bool) -> Result<(), SceneError> {
        let count = corners.len() - 2;
        let (source, object) = (self.words.source, &self.words.object);
        let material = self.materials.of_faces(source, keyword.offset, object, count, self.reading)?;
        if self.raw.faces.len() + count > u32::MAX as usize {
            return Err(self.words.error(keyword.offset, "more than 2^32 triangles", "divide the mesh"));
        }
        if count > 1 {
            let (first, corners) = (self.raw.faces.len() as u32, corners.len() as u32);
            self.raw.polygons.push(Polygon { first, corners });
        }
        let number = |corner: Corner| corner.1.unwrap_or(NO_NORMAL);
        self.raw.faces.extend((1..=count).map(|i| {
            let fan = [corners[0], corners[i], corners[i + 1]];
            let normals = with_normals.then(|| fan.map(number));
            Face { vertices: fan.map(|corner| corner.0), normals, material }
        }));
        Ok(())
    }

    /// `v`, `v/vt`, `v//vn` or `v/vt/vn`; what is left empty is not there.
    fn corner(&self, word: Word) -> Result<Corner, SceneError> {
        let mut parts = word.bytes.split(|b| *b == b'/');
        let vertex = parts.next().unwrap_or_default();
        let texture = parts.next().unwrap_or_default();
        let normal = parts.next();
        if parts.next().is_some() || (!texture.is_empty() && integer(texture).is_none()) {
            return Err(self.bad_corner(word));
        }
        let vertex = self.index(word, vertex, self.raw.vertices.len(), "vertex")?;
        let normal = match normal {
            Some(normal) if self.reading.strict => {
                Some(self.index(word, normal, self.raw.normals.len(), "normal")?)
            }
            Some(b"") | None => None,
            Some(normal) => {
                let written = integer(normal).ok_or_else(|| self.bad_corner(word))?;
                let index = match written {
                    1.. => written - 1,
                    0 => -1,
                    _ => written + self.raw.normals.len() as i64,
                };
                Some(u32::try_from(index).map_or(WRONG_NORMAL, |index| index.min(WRONG_NORMAL)))
            }
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

    /// Turns the index written in `digits`, from 1 or backward from -1, into one from 0. `count` are above this line.
    fn index(&self, word: Word, digits: &[u8], count: usize, what: &str) -> Result<u32, SceneError> {
        let written = integer(digits).ok_or_else(|| self.bad_corner(word))?;
        let index = match written {
            1.. => Some(written - 1),
            0 => None,
            _ => Some(written + count as i64).filter(|i| *i >= 0),
        };
        let limit = match (self.reading.strict, self.total) {
            (true, _) => count,
            (false, total) => total.unwrap_or(u32::MAX as usize),
        };
        let index = index.filter(|i| *i < limit as i64).and_then(|i| u32::try_from(i).ok());
        index.ok_or_else(|| {
            let (known, where_) = match self.total {
                Some(total) if !self.reading.strict && written > 0 => (total, "the file"),
                _ => (count, "above this line"),
            };
            let message = match written {
                0 => format!("{what} 0: numbers start at 1"),
                _ if where_ == "the file" => format!("{what} {written} of {known}: the file has no more"),
                _ => format!("{what} {written} of {known}: there is none above this line"),
            };
            let remedy = match known {
                0 => format!("write each {what} above the faces that use it"),
                _ => format!("write a number from 1 to {known}, or from -{known} to -1"),
            };
            self.words.error(word.offset, message, remedy)
        })
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

//! Large OBJ texts in pieces, side by side. Only what is common is read here, and anything else is left to the
//! reader of whole texts, which has the errors and their places: `None` means "read it from the start".

use super::materials::Materials;
use super::raw::{Polygon, Raw, WRONG_NORMAL};
use crate::scene::error::{SceneError, Source};
use crate::scene::library::Library;
use crate::scene::model::Wanted;
use crate::scene::notes::Reading;
use crate::scene::table::{MAX_LENGTH, unit};
use crate::scene::tokens::Words;
use crate::scene::{Face, Transform};
use glam::DVec3;
use rayon::prelude::*;

/// Bytes of a piece: enough to be worth handing out, and some dozens in a text worth parting.
pub(super) const PIECE: usize = 1 << 19;

/// Reads a whole text in pieces of some `piece` bytes.
pub(super) fn read(
    source: Source,
    wanted: Wanted,
    library: &mut Library,
    reading: &mut Reading,
    piece: usize,
) -> Result<Option<Raw>, SceneError> {
    let strict = reading.strict;
    let read: Option<Vec<Piece>> = pieces(source.text, piece)
        .into_par_iter()
        .map(|(start, end)| Piece::read(source.text, start, end, wanted.place, strict))
        .collect();
    let Some(mut pieces) = read else { return Ok(None) };
    let Some(bases) = bases(&pieces, strict) else { return Ok(None) };
    let mut materials = Materials::new(wanted.material, library);
    for (piece, base) in pieces.iter_mut().zip(&bases) {
        for relative in &piece.relative {
            piece.faces[relative.face as usize].shift(relative, base.map(|n| n as u32));
        }
        piece.give_materials(source, wanted.object, &mut materials, reading)?;
    }
    let total = |count: fn(&Piece) -> usize| pieces.iter().map(count).sum::<usize>();
    let mut raw = Raw {
        vertices: Vec::with_capacity(total(|p| p.vertices.len())),
        normals: Vec::with_capacity(total(|p| p.normals.len())),
        faces: Vec::with_capacity(total(|p| p.faces.len())),
        polygons: Vec::with_capacity(total(|p| p.polygons.len())),
        groups: Vec::new(),
        complete: true,
    };
    for piece in pieces {
        let before = raw.faces.len();
        raw.vertices.extend(piece.vertices);
        raw.normals.extend(piece.normals);
        raw.faces.extend(piece.faces);
        let first = |p: Polygon| Polygon { first: p.first + before as u32, ..p };
        raw.polygons.extend(piece.polygons.into_iter().map(first));
        raw.groups.extend(piece.groups.into_iter().map(|(at, group)| (at + before, group)));
    }
    Ok((!raw.faces.is_empty() && raw.is_in_range()).then_some(raw))
}

/// Vertices, normals above each piece; `None` if faces name what is not there, or there are too many to count.
fn bases(pieces: &[Piece], strict: bool) -> Option<Vec<[i64; 2]>> {
    let (mut above, mut bases, mut faces) = ([0i64; 2], Vec::with_capacity(pieces.len()), 0usize);
    for piece in pieces {
        // Unless the reading is strict, a vertex may follow its faces, and a normal may be missing.
        let needs = if strict { piece.needs } else { [piece.back, 0] };
        if (0..2).any(|k| needs[k] > above[k]) {
            return None;
        }
        bases.push(above);
        above = [above[0] + piece.vertices.len() as i64, above[1] + piece.normals.len() as i64];
        faces += piece.faces.len();
    }
    let in_range = above.iter().all(|n| *n < i64::from(WRONG_NORMAL)) && faces < u32::MAX as usize;
    in_range.then_some(bases)
}

/// Where pieces begin and end: behind line ends that end a statement for sure.
fn pieces(text: &[u8], size: usize) -> Vec<(usize, usize)> {
    let (mut found, mut start) = (Vec::new(), 0);
    while start < text.len() {
        let mut end = (start + size).min(text.len());
        while end < text.len() && (text[end - 1] != b'\n' || is_continued(&text[..end - 1])) {
            end += 1;
        }
        found.push((start, end));
        start = end;
    }
    found
}

/// True for a line without its end that may go on in the next.
fn is_continued(line: &[u8]) -> bool {
    line.ends_with(b"\\") || line.ends_with(b"\\\r")
}

/// Of a face whose corners count backward: add what lies above the piece.
struct Relative {
    face: u32,
    /// Corners 0 to 2 whose vertex, bits 3 to 5 whose normal.
    corners: u8,
}

impl Face {
    fn shift(&mut self, relative: &Relative, base: [u32; 2]) {
        for corner in 0..3 {
            if relative.corners >> corner & 1 == 1 {
                self.vertices[corner] = self.vertices[corner].wrapping_add(base[0]);
            }
            if let (1, Some(normals)) = (relative.corners >> (3 + corner) & 1, &mut self.normals) {
                // Counted back beyond the first normal, it is none.
                normals[corner] = normals[corner].wrapping_add(base[1]).min(WRONG_NORMAL);
            }
        }
    }
}

/// What a piece holds.
struct Piece {
    vertices: Vec<DVec3>,
    normals: Vec<DVec3>,
    faces: Vec<Face>,
    relative: Vec<Relative>,
    polygons: Vec<Polygon>,
    /// Smoothing groups and the faces before each.
    groups: Vec<(usize, u32)>,
    /// Vertices, normals that must lie above the piece at least if faces follow what they name.
    needs: [i64; 2],
    /// Vertices that must lie above the piece since faces count back to them.
    back: i64,
    /// Missing values are an error, which this reader leaves to the other.
    strict: bool,
    /// Byte of the first face.
    first_face: usize,
    /// Where a `usemtl` or `mtllib` is, and the faces before it.
    statements: Vec<(usize, usize)>,
}

/// Number of a vertex or normal as written in a piece: its number from 0, or, where it counts backward,
/// from the first of the piece.
type Named = (u32, bool);

struct Cursor<'a> {
    text: &'a [u8],
    at: usize,
}

impl Piece {
    fn read(text: &[u8], start: usize, end: usize, place: Transform, strict: bool) -> Option<Piece> {
        // A line of a vertex or a face takes some 30 bytes.
        let room = (end - start) / 30;
        let mut piece = Piece {
            vertices: Vec::with_capacity(room / 2),
            normals: Vec::new(),
            faces: Vec::with_capacity(room),
            relative: Vec::new(),
            polygons: Vec::new(),
            groups: Vec::new(),
            needs: [0; 2],
            back: 0,
            strict,
            first_face: end,
            statements: Vec::new(),
        };
        let mut cursor = Cursor { text: &text[..end], at: start };
        if start == 0 && text.starts_with(b"\xef\xbb\xbf") {
            cursor.at = 3;
        }
        while cursor.at < end {
            cursor.blanks();
            let line = cursor.at;
            match cursor.word() {
                b"v" => {
                    let vertex = place.point(cursor.vector()?);
                    if vertex.abs().max_element() > MAX_LENGTH {
                        return None;
                    }
                    piece.vertices.push(vertex);
                }
                b"vn" => match cursor.vector().and_then(unit) {
                    Some(normal) => piece.normals.push(place.normal(normal)),
                    None if strict => return None,
                    None => piece.normals.push(DVec3::NAN),
                },
                b"f" => {
                    piece.first_face = piece.first_face.min(line);
                    piece.face(&mut cursor)?;
                }
                b"vt" | b"o" | b"g" | b"" => {}
                b"s" => piece.groups.push((piece.faces.len(), cursor.group()?)),
                b"usemtl" | b"mtllib" => piece.statements.push((line, piece.faces.len())),
                comment if comment[0] == b'#' => {}
                _ => return None,
            }
            cursor.end_line()?;
        }
        Some(piece)
    }

    fn face(&mut self, cursor: &mut Cursor) -> Option<()> {
        let first = self.faces.len();
        let mut fan = [(0, false); 2];
        let mut fan_normals = [None; 2];
        for i in 0.. {
            cursor.blanks();
            if cursor.at_end() {
                if i > 3 {
                    self.polygons.push(Polygon { first: first as u32, corners: i });
                }
                return (i > 2).then_some(());
            }
            let (vertex, normal) = self.corner(cursor)?;
            if i > 0 && normal.is_some() != fan_normals[0].is_some() {
                return None;
            }
            if i >= 2 {
                self.push(
                    [fan[0], fan[1], vertex],
                    match (fan_normals[0], fan_normals[1], normal) {
                        (Some(a), Some(b), Some(c)) => Some([a, b, c]),
                        _ => None,
                    },
                );
            }
            let slot = i.min(1) as usize;
            (fan[slot], fan_normals[slot]) = (vertex, normal);
        }
        None
    }

    fn corner(&mut self, cursor: &mut Cursor) -> Option<(Named, Option<Named>)> {
        let vertex = self.named(cursor.integer()?, 0)?;
        let mut normal = None;
        if cursor.take(b'/') {
            let ends = |cursor: &Cursor| cursor.byte().is_none_or(|b| b.is_ascii_whitespace());
            if !cursor.peek(b'/') && (self.strict || !ends(cursor)) {
                cursor.integer()?;
            }
            if cursor.take(b'/') && (self.strict || !ends(cursor)) {
                normal = Some(self.named(cursor.integer()?, 1)?);
            }
        }
        cursor.byte().is_none_or(|b| b.is_ascii_whitespace()).then_some((vertex, normal))
    }

    fn push(&mut self, vertices: [Named; 3], normals: Option<[Named; 3]>) {
        let bits = |named: [Named; 3]| (0..3).fold(0u8, |bits, i| bits | u8::from(named[i].1) << i);
        let corners = bits(vertices) | normals.map_or(0, bits) << 3;
        if corners != 0 {
            self.relative.push(Relative { face: self.faces.len() as u32, corners });
        }
        let number = |named: Named| named.0;
        self.faces.push(Face {
            vertices: vertices.map(number),
            normals: normals.map(|n| n.map(number)),
            material: 0,
        });
    }

    /// The vertex (kind 0) or normal (1) `written` in the text.
    fn named(&mut self, written: i64, kind: usize) -> Option<Named> {
        let here = [self.vertices.len(), self.normals.len()][kind] as i64;
        let need = match written {
            1.. => written - here,
            0 if kind == 1 && !self.strict => return Some((WRONG_NORMAL, false)),
            0 => return None,
            _ => -(here + written),
        };
        self.needs[kind] = self.needs[kind].max(need);
        if kind == 0 && written < 0 {
            self.back = self.back.max(need);
        }
        Some(if written > 0 {
            (u32::try_from(written - 1).ok().filter(|n| *n < WRONG_NORMAL)?, false)
        } else {
            ((here + written) as u32, true)
        })
    }

    /// Fills in the faces' materials.
    fn give_materials(
        &mut self,
        source: Source,
        object: &str,
        materials: &mut Materials,
        reading: &mut Reading,
    ) -> Result<(), SceneError> {
        let last = (source.text.len(), self.faces.len());
        let mut from = 0;
        for (offset, to) in self.statements.iter().copied().chain([last]) {
            if from < to {
                let material = materials.of_faces(source, self.first_face, object, to - from, reading)?;
                self.faces[from..to].iter_mut().for_each(|face| face.material = material);
            }
            from = to;
            if offset < source.text.len() {
                let mut words = Words::starting(source, object.to_owned(), offset);
                if let Some(keyword) = words.keyword() {
                    materials.statement(&mut words, keyword, reading)?;
                }
            }
        }
        Ok(())
    }
}

impl<'a> Cursor<'a> {
    fn byte(&self) -> Option<u8> {
        self.text.get(self.at).copied()
    }

    fn peek(&self, byte: u8) -> bool {
        self.byte() == Some(byte)
    }

    fn take(&mut self, byte: u8) -> bool {
        let there = self.peek(byte);
        self.at += usize::from(there);
        there
    }

    /// Skips blanks within the line.
    fn blanks(&mut self) {
        while self.byte().is_some_and(|b| b.is_ascii_whitespace() && b != b'\n') {
            self.at += 1;
        }
    }

    /// At the end of the line, or what follows is a comment.
    fn at_end(&self) -> bool {
        matches!(self.byte(), None | Some(b'\n' | b'#'))
    }

    fn word(&mut self) -> &'a [u8] {
        let start = self.at;
        while self.byte().is_some_and(|b| !b.is_ascii_whitespace()) {
            self.at += 1;
        }
        &self.text[start..self.at]
    }

    /// Skips the rest of the line, which must not go on in the next.
    fn end_line(&mut self) -> Option<()> {
        let rest = &self.text[self.at..];
        let length = rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len());
        let continued = is_continued(&rest[..length]);
        self.at = (self.at + length + 1).min(self.text.len());
        (!continued).then_some(())
    }

    /// The smoothing group: a plain number or `off`.
    fn group(&mut self) -> Option<u32> {
        self.blanks();
        match self.word() {
            b"off" => Some(0),
            digits => std::str::from_utf8(digits).ok()?.parse().ok(),
        }
    }

    fn vector(&mut self) -> Option<DVec3> {
        let mut v = [0.0; 3];
        for x in &mut v {
            self.blanks();
            *x = self.number()?;
            if !x.is_finite() || x.abs() > MAX_LENGTH {
                return None;
            }
        }
        Some(DVec3::from_array(v))
    }

    /// A decimal number: where its digits and its power of ten are exact in f64, one rounding gives the
    /// nearest number (Clinger, "How to Read Floating Point Numbers Accurately", 1990).
    fn number(&mut self) -> Option<f64> {
        let start = self.at;
        let negative = self.take(b'-');
        let (mut mantissa, mut digits, mut exponent) = (0u64, 0, 0i32);
        let mut after_point = false;
        loop {
            match self.byte() {
                Some(b @ b'0'..=b'9') => {
                    mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(b - b'0'));
                    digits += 1;
                    exponent -= i32::from(after_point);
                }
                Some(b'.') if !after_point => after_point = true,
                _ => break,
            }
            self.at += 1;
        }
        let ends = self.byte().is_none_or(|b| b.is_ascii_whitespace());
        // 15 digits are below 2^53, and powers of ten to 10^22 are exact.
        if ends && (1..=15).contains(&digits) && exponent >= -22 {
            let x = mantissa as f64 / POWERS_OF_TEN[-exponent as usize];
            return Some(if negative { -x } else { x });
        }
        self.at = start;
        std::str::from_utf8(self.word()).ok()?.parse().ok()
    }

    /// A decimal integer of at most 18 digits, with an optional sign.
    fn integer(&mut self) -> Option<i64> {
        let negative = self.take(b'-');
        if !negative {
            self.take(b'+');
        }
        let (start, mut value) = (self.at, 0i64);
        while let Some(b @ b'0'..=b'9') = self.byte() {
            value = value.wrapping_mul(10).wrapping_add(i64::from(b - b'0'));
            self.at += 1;
        }
        (1..=18).contains(&(self.at - start)).then_some(if negative { -value } else { value })
    }
}

const POWERS_OF_TEN: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19, 1e20, 1e21, 1e22,
];

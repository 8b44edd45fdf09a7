//! What a text holds, before its faces are checked and cut: the same from either reader.

use super::smooth;
use crate::scene::error::{SceneError, Source};
use crate::scene::notes::Reading;
use crate::scene::polygon::NORMAL_LEAN;
use crate::scene::table::unit;
use crate::scene::tokens::Words;
use crate::scene::triangulate::{self, Cut, Fault};
use crate::scene::{Face, Mesh};
use glam::DVec3;
use rayon::prelude::*;

/// In place of a normal's number: the corner has none, though others of its face do.
pub(super) const NO_NORMAL: u32 = u32::MAX;
/// In place of a normal's number: what is written can be none, such as 0.
pub(super) const WRONG_NORMAL: u32 = u32::MAX - 1;

/// A face with more than three corners.
#[derive(Debug, Clone, Copy)]
pub(super) struct Polygon {
    /// Number of its first triangle, by a fan from its first corner.
    pub first: u32,
    /// How many corners.
    pub corners: u32,
}

/// A mesh whose faces are fanned, with numbers of normals that may be wrong.
#[derive(Debug, Default)]
pub(super) struct Raw {
    /// In their place.
    pub vertices: Vec<DVec3>,
    /// Unit vectors; NaN where what is written has no direction.
    pub normals: Vec<DVec3>,
    pub faces: Vec<Face>,
    /// In the order of their triangles.
    pub polygons: Vec<Polygon>,
    /// Smoothing groups, 0 for none, each from a triangle on.
    pub groups: Vec<(usize, u32)>,
    /// True if all faces are in it: a triangle's number then leads back to its line.
    pub complete: bool,
}

impl Raw {
    /// True if no face names a vertex that is not there.
    pub fn is_in_range(&self) -> bool {
        let count = self.vertices.len();
        self.faces.par_iter().all(|f| f.vertices.iter().all(|v| (*v as usize) < count))
    }

    /// The mesh, with faces cut right and normals that can be used.
    ///
    /// # Errors
    /// A face whose border crosses itself, if the reading is strict.
    pub fn mesh(
        mut self,
        source: Source,
        object: &str,
        mirrored: bool,
        reading: &mut Reading,
    ) -> Result<Mesh, SceneError> {
        self.check_normals(source, reading);
        self.cut_polygons(source, object, reading)?;
        let (vertices, normals) = (&self.vertices, &self.normals);
        self.faces.par_iter_mut().for_each(|face| {
            if face.normals.is_some_and(|n| is_flat(vertices, normals, face.vertices, n)) {
                face.normals = None;
            }
        });
        if !reading.strict && self.groups.iter().any(|(_, group)| *group != 0) {
            let count = smooth::add_normals(&self.vertices, &mut self.normals, &mut self.faces, &self.groups);
            let first = self.groups.iter().find(|(_, group)| *group != 0).map_or(0, |(at, _)| *at);
            let message = "triangles of smoothing groups without `vn` are smoothed where they meet at less than 85 degrees";
            self.note(source, first, message, count, reading);
        }
        if mirrored {
            self.faces.par_iter_mut().for_each(|face| {
                face.vertices.swap(1, 2);
                face.normals.iter_mut().for_each(|n| n.swap(1, 2));
            });
        }
        if self.faces.par_iter().all(|face| face.normals.is_none()) {
            self.normals = Vec::new();
        }
        let Raw { vertices, normals, faces, .. } = self;
        Ok(Mesh { name: source.file.display().to_string(), vertices, normals, faces })
    }

    /// Counts `count` of `message`, first met at `triangle`.
    fn note(&self, source: Source, triangle: usize, message: &str, count: usize, reading: &mut Reading) {
        if count > 0 {
            reading.count(source, self.place(source, triangle), message, count);
        }
    }

    /// Byte of the face that `triangle` is of; the first of the text if that is not known.
    fn place(&self, source: Source, triangle: usize) -> usize {
        if !self.complete {
            return 0;
        }
        let mut words = Words::new(source, String::new());
        let mut before = 0;
        while let Some(keyword) = words.keyword() {
            if keyword.bytes == b"f" {
                let corners = std::iter::from_fn(|| words.word()).count();
                before += corners.saturating_sub(2);
                if before > triangle {
                    return keyword.offset;
                }
            }
            words.end_line();
        }
        0
    }

    /// Faces with a corner whose normal cannot be used get none, all of the face.
    fn check_normals(&mut self, source: Source, reading: &mut Reading) {
        let count = self.normals.len();
        let fault = |face: &Face| {
            let normals = face.normals?;
            let fault = |n: u32| match self.normals.get(n as usize) {
                Some(normal) if normal.is_nan() => 3,
                Some(_) => 0,
                None if n == NO_NORMAL => 1,
                None => 2,
            };
            normals.into_iter().map(fault).max().filter(|fault| *fault > 0)
        };
        debug_assert!(count < WRONG_NORMAL as usize);
        let faulty: Vec<(usize, usize)> =
            self.faces.par_iter().enumerate().filter_map(|(i, face)| Some((i, fault(face)?))).collect();
        for (kind, message) in [
            (1, "triangles with normals on some corners get their own normal"),
            (2, "triangles with a normal's number that is 0 or out of range get their own normal"),
            (3, "triangles with a normal of length 0, or of no numbers, get their own normal"),
        ] {
            let of_kind = || faulty.iter().filter(|(_, k)| *k == kind);
            if let Some((first, _)) = of_kind().next() {
                self.note(source, *first, message, of_kind().count(), reading);
            }
        }
        // No face uses these any more; a mesh holds unit vectors only, equal to themselves.
        self.normals.par_iter_mut().filter(|n| n.is_nan()).for_each(|n| *n = DVec3::Z);
        for (i, _) in faulty {
            self.faces[i].normals = None;
            // Of a face with more corners no triangle keeps its normals.
            let at = self.polygons.partition_point(|p| p.first as usize <= i);
            if let Some(p) = at.checked_sub(1).map(|at| self.polygons[at])
                && i < (p.first + p.corners - 2) as usize
            {
                self.faces[p.first as usize..(p.first + p.corners - 2) as usize]
                    .iter_mut()
                    .for_each(|face| face.normals = None);
            }
        }
    }

    /// Replaces the fans that do not cover their faces.
    fn cut_polygons(
        &mut self,
        source: Source,
        object: &str,
        reading: &mut Reading,
    ) -> Result<(), SceneError> {
        let cut = |p: &Polygon| match triangulate::cut(&self.corners(p)) {
            Ok(Cut::Fan) => None,
            other => Some((*p, other)),
        };
        let others: Vec<(Polygon, Result<Cut, Fault>)> = self.polygons.par_iter().filter_map(cut).collect();
        let mut crossed = Vec::new();
        for (p, cut) in others {
            match cut {
                Ok(Cut::Triangles(triangles)) => self.replace(p, &triangles),
                Err(Fault::NoArea) if !self.has_area(&p) => {}
                _ => crossed.push(p.first as usize),
            }
        }
        let Some(first) = crossed.first() else { return Ok(()) };
        let (first, message) =
            (*first, "faces whose border crosses itself are fanned from their first corner");
        if reading.strict {
            let remedy = "order the corners along the border, or write the face as several";
            return Err(source.error(
                self.place(source, first),
                object,
                "a face whose border crosses itself",
                remedy,
            ));
        }
        self.note(source, first, message, crossed.len(), reading);
        Ok(())
    }

    fn triangles_of(&self, p: &Polygon) -> &[Face] {
        &self.faces[p.first as usize..(p.first + p.corners - 2) as usize]
    }

    /// The corners of a face that is still a fan.
    fn corners(&self, p: &Polygon) -> Vec<DVec3> {
        let fan = self.triangles_of(p);
        let first = fan[0].vertices[..2].iter();
        first.chain(fan.iter().map(|f| &f.vertices[2])).map(|v| self.vertices[*v as usize]).collect()
    }

    /// True if some triangle of the fan has an area.
    fn has_area(&self, p: &Polygon) -> bool {
        self.triangles_of(p).iter().any(|f| {
            let [a, b, c] = f.vertices.map(|v| self.vertices[v as usize]);
            (b - a).cross(c - a) != DVec3::ZERO
        })
    }

    /// Writes `triangles` over a face's fan. What is left over of it becomes triangles without area.
    fn replace(&mut self, p: Polygon, triangles: &[[u32; 3]]) {
        let fan = self.triangles_of(&p).to_vec();
        let corner = |i: u32| match i {
            0 | 1 => (fan[0].vertices[i as usize], fan[0].normals.map(|n| n[i as usize])),
            _ => {
                let face = &fan[i as usize - 2];
                (face.vertices[2], face.normals.map(|n| n[2]))
            }
        };
        for (k, old) in fan.iter().enumerate() {
            let [a, b, c] = triangles.get(k).map_or([corner(0); 3], |t| t.map(corner));
            let normals = match (a.1, b.1, c.1) {
                (Some(a), Some(b), Some(c)) => Some([a, b, c]),
                _ => None,
            };
            self.faces[p.first as usize + k] =
                Face { vertices: [a.0, b.0, c.0], normals, material: old.material };
        }
    }
}

/// True if the three normals are one that agrees with the triangle's plane up to its digits: the
/// plane's own normal, which is exact, then says it better.
pub fn is_flat(vertices: &[DVec3], normals: &[DVec3], corners: [u32; 3], corner_normals: [u32; 3]) -> bool {
    if corner_normals[0] != corner_normals[1] || corner_normals[0] != corner_normals[2] {
        return false;
    }
    let [a, b, c] = corners.map(|i| vertices[i as usize]);
    let size = (b - a).abs().max((c - a).abs()).max_element();
    unit(((b - a) / size).cross((c - a) / size))
        .is_some_and(|plane| plane.cross(normals[corner_normals[0] as usize]).length() <= NORMAL_LEAN)
}

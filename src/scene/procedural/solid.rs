//! A triangle mesh on its way to a file.

use crate::scene::Transform;
use glam::DVec3;
use std::io::{Result, Write};

/// A closed triangle mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Solid {
    /// Name of the OBJ object and of its material.
    pub name: &'static str,
    /// Metres.
    pub vertices: Vec<DVec3>,
    /// Unit normals of faces; empty if the corners say enough.
    pub normals: Vec<DVec3>,
    /// Triangles, counter-clockwise seen from outside.
    pub faces: Vec<Corners>,
}

/// One triangle of a [`Solid`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Corners {
    /// Indices into [`Solid::vertices`].
    pub vertices: [u32; 3],
    /// Index into [`Solid::normals`], if there are any.
    pub normal: u32,
}

impl Solid {
    /// Scales, rotates (degrees about x, y, z in turn) and moves the solid.
    pub fn place(&mut self, scale: f64, rotate: DVec3, translate: DVec3) {
        let place = Transform::new(scale, rotate, translate);
        self.vertices.iter_mut().for_each(|v| *v = place.point(*v));
        self.normals.iter_mut().for_each(|n| *n = place.normal(*n));
    }

    /// Writes the solid as OBJ text; `mtl` names the material file.
    ///
    /// Coordinates are written in single precision, which is what is rendered, in the fewest digits
    /// that give it back.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write_obj(&self, out: &mut dyn Write, mtl: Option<&str>) -> Result<()> {
        writeln!(out, "# {}: {} vertices, {} triangles", self.name, self.vertices.len(), self.faces.len())?;
        if let Some(file) = mtl {
            writeln!(out, "mtllib {file}")?;
        }
        writeln!(out, "o {}", self.name)?;
        for v in &self.vertices {
            triple(out, "v", *v)?;
        }
        for n in &self.normals {
            triple(out, "vn", *n)?;
        }
        if mtl.is_some() {
            writeln!(out, "usemtl {}", self.name)?;
        }
        for face in &self.faces {
            let [a, b, c] = face.vertices.map(|v| v + 1);
            if self.normals.is_empty() {
                writeln!(out, "f {a} {b} {c}")?;
            } else {
                let n = face.normal + 1;
                writeln!(out, "f {a}//{n} {b}//{n} {c}//{n}")?;
            }
        }
        Ok(())
    }

    /// Writes the solid's material, diffuse of that colour, as MTL text.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write_mtl(&self, out: &mut dyn Write, color: DVec3) -> Result<()> {
        writeln!(out, "newmtl {}\nKd {} {} {}", self.name, color.x, color.y, color.z)?;
        writeln!(out, "illum 1\nwhitted_ambient 0.1\nwhitted_secondary 0")
    }
}

fn triple(out: &mut dyn Write, keyword: &str, v: DVec3) -> Result<()> {
    // Adding 0 turns -0 into 0.
    let [x, y, z] = v.to_array().map(|x| x as f32 + 0.0);
    writeln!(out, "{keyword} {x} {y} {z}")
}

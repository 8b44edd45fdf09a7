//! PLY meshes (Turk, The PLY Polygon File Format, 1994): ASCII and binary, with vertices `x y z`, normals
//! `nx ny nz`, colours, faces of any number of corners and triangle strips. Other elements and properties are skipped.

mod body;
mod header;

use super::error::SceneError;
use super::library::Library;
use super::mesh_builder::MeshBuilder;
use super::model::{Model, Wanted};
use super::model_file::ModelFile;
use super::notes::Reading;
use super::{Material, material};
use crate::scene::mean_color::srgb_to_linear;
use body::Body;
use glam::DVec3;
use header::{Element, Number, Property};

/// True if it begins as a PLY file does.
pub(super) fn is_ply(bytes: &[u8]) -> bool {
    bytes.len() >= 4 && bytes.starts_with(b"ply") && bytes[3].is_ascii_whitespace()
}

/// Names of the list of a face's corners.
const CORNERS: [&str; 2] = ["vertex_indices", "vertex_index"];

/// What the elements hold.
struct Content {
    builder: MeshBuilder,
    vertex_colors: Mean,
    face_colors: Mean,
    /// Corners of all faces, one after the other.
    corners: Vec<u32>,
    /// Where in `corners` each face ends.
    ends: Vec<usize>,
    /// The faces of an element `face`, or those of strips.
    faces_are: Shape,
    /// Faces with fewer than three corners.
    thin: usize,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Shape {
    Polygons,
    Strips,
}

/// A mean of colours.
#[derive(Default)]
struct Mean {
    sum: DVec3,
    count: usize,
}

impl Mean {
    fn add(&mut self, color: DVec3) {
        // A colour that is no number says nothing.
        if color.is_finite() {
            self.sum += color.max(DVec3::ZERO);
            self.count += 1;
        }
    }

    fn mean(&self) -> Option<DVec3> {
        (self.count > 0).then(|| self.sum / self.count as f64)
    }
}

/// Reads a PLY file.
pub(super) fn read(
    file: ModelFile,
    wanted: Wanted,
    library: &mut Library,
    reading: &mut Reading,
) -> Result<Model, SceneError> {
    if !is_ply(file.source.text) {
        return Err(file.error_at(
            0,
            "no PLY file: its first line is not `ply`",
            "export the model as PLY again",
        ));
    }
    let header = header::read(file, reading)?;
    let mut body = Body::new(file, header.encoding, header.body);
    let mut content = Content {
        builder: MeshBuilder::new(wanted.place),
        vertex_colors: Mean::default(),
        face_colors: Mean::default(),
        corners: Vec::new(),
        ends: Vec::new(),
        faces_are: Shape::Polygons,
        thin: 0,
    };
    for element in &header.elements {
        body.check(element)?;
        match element.name.as_str() {
            "vertex" => content.vertices(file, element, &mut body)?,
            "face" => content.faces(element, &mut body, Shape::Polygons)?,
            "tristrips" => content.faces(element, &mut body, Shape::Strips)?,
            _ => skip(element, &mut body)?,
        }
    }
    if header.textured {
        let remedy = "give `material` in the scene's [[mesh]]";
        file.assume(reading, 1, "its texture is not drawn", remedy)?;
    }
    if content.ends.is_empty() {
        let vertices = content.builder.vertex_count();
        return Err(file.error(
            format!("{vertices} points without faces: a cloud of points has no surface"),
            "make a mesh of it first, for instance with MeshLab's or Open3D's surface reconstruction",
        ));
    }
    let material = match wanted.material {
        Some(material) => material,
        None => {
            library.materials.push(content.material(file, reading)?);
            library.materials.len() - 1
        }
    };
    content.finish(file, material, reading)
}

/// Reads past an element that means nothing here.
fn skip(element: &Element, body: &mut Body) -> Result<(), SceneError> {
    if element.properties.is_empty() {
        return Ok(());
    }
    for _ in 0..element.count {
        for property in &element.properties {
            skip_property(property, body)?;
        }
    }
    Ok(())
}

fn skip_property(property: &Property, body: &mut Body) -> Result<(), SceneError> {
    let count = match property.length {
        Some(length) => body.length(length, property.number)?,
        None => 1,
    };
    for _ in 0..count {
        body.number(property.number)?;
    }
    Ok(())
}

/// Which of nine values of a vertex, or three of a face's colour, a property is: position 0 to 2, normal 3 to 5, colour 6 to 8.
fn slot(property: &Property) -> Option<usize> {
    if property.length.is_some() {
        return None;
    }
    Some(match property.name.as_str() {
        "x" => 0,
        "y" => 1,
        "z" => 2,
        "nx" => 3,
        "ny" => 4,
        "nz" => 5,
        "red" | "r" | "diffuse_red" => 6,
        "green" | "g" | "diffuse_green" => 7,
        "blue" | "b" | "diffuse_blue" => 8,
        _ => return None,
    })
}

/// A colour channel, linear. Whole numbers are sRGB, as scanners and viewers have them; others are linear.
fn channel(number: Number, value: f64) -> f64 {
    match number {
        Number::I8 | Number::U8 => srgb_to_linear(value / 255.0),
        Number::I16 | Number::U16 => srgb_to_linear(value / 65_535.0),
        // Some write 0 to 255 with a wider type.
        Number::I32 | Number::U32 => srgb_to_linear(value / 255.0),
        Number::F32 | Number::F64 => value,
    }
}

/// Reads one element's values into their slots; calls `list` for each list.
fn values(
    element: &Element,
    slots: &[Option<usize>],
    body: &mut Body,
    mut list: impl FnMut(&Property, &mut Body) -> Result<(), SceneError>,
) -> Result<[f64; 9], SceneError> {
    let mut values = [0.0; 9];
    for (property, slot) in element.properties.iter().zip(slots) {
        match (property.length, slot) {
            (Some(_), _) => list(property, body)?,
            (None, Some(slot)) => {
                let value = body.number(property.number)?;
                values[*slot] = if *slot < 6 { value } else { channel(property.number, value) };
            }
            (None, None) => {
                body.number(property.number)?;
            }
        }
    }
    Ok(values)
}

impl Content {
    fn vertices(&mut self, file: ModelFile, element: &Element, body: &mut Body) -> Result<(), SceneError> {
        let slots: Vec<_> = element.properties.iter().map(slot).collect();
        let has = |range: std::ops::Range<usize>| range.clone().all(|i| slots.contains(&Some(i)));
        if !has(0..3) {
            return Err(file.error_at(
                element.offset,
                "the vertices have no `x`, `y` and `z`",
                "add the lines `property float x` and so on",
            ));
        }
        let has_normals = has(3..6);
        let has_colors = has(6..9);
        for _ in 0..element.count {
            let v = values(element, &slots, body, skip_property)?;
            self.builder.vertex(DVec3::new(v[0], v[1], v[2]));
            if has_normals {
                self.builder.normal(DVec3::new(v[3], v[4], v[5]));
            }
            if has_colors {
                self.vertex_colors.add(DVec3::new(v[6], v[7], v[8]));
            }
        }
        Ok(())
    }

    fn faces(&mut self, element: &Element, body: &mut Body, shape: Shape) -> Result<(), SceneError> {
        if element.properties.is_empty() {
            return Ok(());
        }
        let slots: Vec<_> = element.properties.iter().map(slot).collect();
        let has_colors = (6..9).all(|i| slots.contains(&Some(i)));
        self.faces_are = shape;
        for face in 0..element.count {
            let (corners, ends) = (&mut self.corners, &mut self.ends);
            let start = corners.len();
            let v = values(element, &slots, body, |property, body| {
                if CORNERS.contains(&property.name.as_str()) {
                    list(face, property, body, corners, shape)
                } else {
                    skip_property(property, body)
                }
            })?;
            match corners.len() - start {
                0 => {}
                1 | 2 if shape == Shape::Polygons => {
                    corners.truncate(start);
                    self.thin += 1;
                }
                _ => ends.push(corners.len()),
            }
            if has_colors {
                self.face_colors.add(DVec3::new(v[6], v[7], v[8]));
            }
        }
        Ok(())
    }

    /// The material of the colours, or the default one.
    fn material(&self, file: ModelFile, reading: &mut Reading) -> Result<Material, SceneError> {
        let remedy = "give `material` in the scene's [[mesh]]";
        let Some(color) = self.vertex_colors.mean().or(self.face_colors.mean()) else {
            let message = "the file has no colours: it gets the default material, diffuse 0.8";
            file.assume(reading, 1, message, remedy)?;
            return Ok(material::plain("default"));
        };
        let [r, g, b] = color.to_array();
        let what = if self.vertex_colors.count > 0 { "vertices" } else { "faces" };
        let message =
            format!("the colours of its {what} become their mean, diffuse [{r:.3}, {g:.3}, {b:.3}]");
        file.assume(reading, 1, &message, remedy)?;
        Ok(Material { diffuse: color.min(DVec3::splat(f64::from(f32::MAX))), ..material::plain("colours") })
    }

    fn finish(
        mut self,
        file: ModelFile,
        material: usize,
        reading: &mut Reading,
    ) -> Result<Model, SceneError> {
        let count = self.builder.vertex_count();
        let beyond = |corner: &u32| *corner as usize >= count && *corner != RESTART;
        if let Some(wrong) = self.corners.iter().position(beyond) {
            let face = self.ends.partition_point(|end| *end <= wrong) + 1;
            return Err(file.error(
                format!("face {face} names vertex {}, but there are {count}, from 0", self.corners[wrong]),
                "the file is damaged: export it again",
            ));
        }
        let has_normals = self.builder.normal_count() == count;
        let mut start = 0;
        for &end in &self.ends {
            let corners = &self.corners[start..end];
            match self.faces_are {
                Shape::Polygons => {
                    self.builder.polygon(corners, has_normals.then_some(corners), material);
                }
                Shape::Strips => strips(&mut self.builder, corners, has_normals, material),
            }
            start = end;
        }
        let (mesh, lost) = self.builder.finish(file.source.file.display().to_string());
        let remedy = "export the file again, or repair it";
        file.assume(reading, self.thin, "faces with fewer than three corners are left out", remedy)?;
        file.assume(reading, lost, "triangles with a corner that is not finite are left out", remedy)?;
        if mesh.faces.is_empty() {
            return Err(file.error("no face has three corners", "export the model as a mesh"));
        }
        Ok(Model { meshes: vec![mesh], ..Model::default() })
    }
}

/// Ends one strip and begins another: -1 in the file.
const RESTART: u32 = u32::MAX;

/// Reads the corners of `face`.
fn list(
    face: usize,
    property: &Property,
    body: &mut Body,
    corners: &mut Vec<u32>,
    shape: Shape,
) -> Result<(), SceneError> {
    let Some(length) = property.length else { return Ok(()) };
    for _ in 0..body.length(length, property.number)? {
        let offset = body.at();
        let corner = body.number(property.number)?;
        let whole = corner.fract() == 0.0 && (0.0..f64::from(RESTART)).contains(&corner);
        let restart = shape == Shape::Strips && corner == -1.0;
        if !whole && !restart {
            let message = format!("face {} has the corner {corner}", face + 1);
            return Err(body.error_at(offset, &message, "corners are numbers of vertices, from 0"));
        }
        corners.push(if whole { corner as u32 } else { RESTART });
    }
    Ok(())
}

/// Triangles of strips: every second one turned round, so that all face one way.
fn strips(builder: &mut MeshBuilder, corners: &[u32], has_normals: bool, material: usize) {
    for strip in corners.split(|c| *c == RESTART) {
        for (i, three) in strip.windows(3).enumerate() {
            let [a, b, c] = [three[0], three[1], three[2]];
            let turned = if i % 2 == 0 { [a, b, c] } else { [b, a, c] };
            // Strips repeat a corner to jump: such triangles have no area.
            if a != b && b != c && a != c {
                builder.triangle(turned, has_normals.then_some(turned), material);
            }
        }
    }
}

#[cfg(test)]
mod tests;

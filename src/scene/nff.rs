//! NFF, the Neutral File Format of Haines' Standard Procedural Databases (1987): viewpoint `v`, background `b`, lights
//! `l`, fills `f`, spheres `s`, cones and cylinders `c`, polygons `p`, patches with normals `pp`.

mod cone;
mod fill;

use super::error::{SceneError, Source};
use super::library::Library;
use super::model::{Model, Wanted};
use super::notes::Reading;
use super::polygon;
use super::table::{MAX_LENGTH, MIN_LENGTH, unit, within_f32};
use super::tokens::{Word, Words};
use super::{Camera, Face, Light, Mesh, Sphere};
use fill::Fill;
use glam::DVec3;

/// Reads an NFF text.
pub(super) fn read(
    source: Source,
    wanted: Wanted,
    library: &mut Library,
    reading: &mut Reading,
) -> Result<Model, SceneError> {
    let words = Words::new(source, wanted.object.to_owned());
    let mut reader = Reader {
        words,
        wanted,
        library,
        reading,
        fills: Vec::new(),
        current: None,
        model: Model::default(),
        solids: Vec::new(),
        shining: 0,
    };
    while let Some(keyword) = reader.words.keyword() {
        reader.statement(keyword)?;
        reader.words.end_line();
    }
    reader.finish()
}

/// What one fill's statements add to.
struct Reader<'a, 'b> {
    words: Words<'a>,
    wanted: Wanted<'b>,
    library: &'b mut Library,
    reading: &'b mut Reading,
    /// Fills so far, each with its material.
    fills: Vec<(Fill, usize)>,
    /// The fill in use.
    current: Option<(Fill, usize)>,
    model: Model,
    /// Meshes, each with the material that refracts and bounds it; none where opaque faces are.
    solids: Vec<(Option<usize>, Mesh)>,
    /// Fills with a highlight.
    shining: usize,
}

/// A corner with its normal, if it has one.
type Corner = (DVec3, Option<DVec3>);

impl Reader<'_, '_> {
    fn statement(&mut self, keyword: Word) -> Result<(), SceneError> {
        match keyword.bytes {
            b"v" => self.viewpoint(keyword),
            b"b" => {
                self.model.background = Some(self.color(keyword)?);
                Ok(())
            }
            b"l" => self.light(keyword),
            b"f" => self.fill(keyword),
            b"s" => self.sphere(keyword),
            b"c" => self.cone(keyword),
            b"p" => self.polygon(keyword, false),
            b"pp" => self.polygon(keyword, true),
            b"nff" => Err(self.words.error(
                keyword.offset,
                "this is the NFF of WorldToolKit, another format of the same name",
                "convert it to OBJ or glTF",
            )),
            _ => {
                let message = "statements that the format does not have are skipped";
                self.assume(keyword, message, "use `v`, `b`, `l`, `f`, `s`, `c`, `p` and `pp`")
            }
        }
    }

    fn assume(&mut self, word: Word, message: &str, remedy: &str) -> Result<(), SceneError> {
        self.reading.assume(self.words.source, word.offset, self.wanted.object, message, remedy)
    }

    /// The next number, on this line or a later one.
    fn number(&mut self, keyword: Word) -> Result<f64, SceneError> {
        let word = match self.words.word() {
            Some(word) => Some(word),
            None => self.words.keyword(),
        };
        let Some(word) = word else {
            let name = keyword.text();
            return Err(self.words.error(
                keyword.offset,
                format!("`{name}` ends too early"),
                "write the numbers that the format asks for",
            ));
        };
        let number = self.words.number(word)?;
        if number.abs() > MAX_LENGTH {
            return Err(self.words.error(
                word.offset,
                format!("`{}` is larger than {MAX_LENGTH:e}", word.text()),
                "use a larger unit of length",
            ));
        }
        Ok(number)
    }

    fn vector(&mut self, keyword: Word) -> Result<DVec3, SceneError> {
        Ok(DVec3::new(self.number(keyword)?, self.number(keyword)?, self.number(keyword)?))
    }

    fn position(&mut self, keyword: Word) -> Result<DVec3, SceneError> {
        let point = self.vector(keyword)?;
        Ok(self.wanted.place.point(point))
    }

    fn color(&mut self, keyword: Word) -> Result<DVec3, SceneError> {
        let color = self.vector(keyword)?;
        if color.to_array().into_iter().all(within_f32) {
            return Ok(color);
        }
        Err(self.words.error(
            keyword.offset,
            "a colour with a negative channel",
            "write channels from 0 to 1",
        ))
    }

    /// The numbers that are left on this line. A word that is none, such as the name of a texture, ends them.
    fn rest(&mut self) -> Result<Vec<f64>, SceneError> {
        let mut numbers = Vec::new();
        while let Some(word) = self.words.word() {
            match self.words.number(word) {
                Ok(number) => numbers.push(number),
                Err(_) => {
                    self.assume(word, "names of textures are skipped", "remove the name")?;
                    break;
                }
            }
        }
        Ok(numbers)
    }

    /// `v` and its six lines, in any order.
    fn viewpoint(&mut self, keyword: Word) -> Result<(), SceneError> {
        let (mut from, mut at, mut up) = (DVec3::ZERO, DVec3::ZERO, DVec3::Y);
        let (mut angle, mut resolution) = (45.0, [512.0; 2]);
        for _ in 0..6 {
            let Some(word) = self.words.keyword() else { break };
            match word.bytes {
                b"from" => from = self.position(word)?,
                b"at" => at = self.position(word)?,
                b"up" => up = self.vector(word)?,
                b"angle" => angle = self.number(word)?,
                b"hither" => _ = self.number(word)?,
                b"resolution" => resolution = [self.number(word)?, self.number(word)?],
                _ => {
                    return Err(self.words.error(
                        word.offset,
                        format!("`{}` within the viewpoint", word.text()),
                        "write `from`, `at`, `up`, `angle`, `hither` and `resolution` after `v`",
                    ));
                }
            }
        }
        let side = |x: f64| (x.fract() == 0.0 && (1.0..=65_535.0).contains(&x)).then_some(x as u32);
        let sides = resolution.map(side);
        let ([Some(width), Some(height)], true) = (sides, angle > 0.0 && angle < 180.0) else {
            return Err(self.words.error(
                keyword.offset,
                "a viewpoint with an impossible angle or resolution",
                "write `angle` between 0 and 180 degrees, and `resolution` from 1 to 65535 pixels",
            ));
        };
        let place = self.wanted.place;
        let up = place.point(up) - place.point(DVec3::ZERO);
        let fov = angle.to_radians();
        self.model.cameras.push(Camera { look_from: from, look_at: at, up, fov, width, height });
        Ok(())
    }

    /// `l x y z [r g b]`; its intensity is set at the end, when the scene's centre is known.
    fn light(&mut self, keyword: Word) -> Result<(), SceneError> {
        let position = self.position(keyword)?;
        let intensity = match self.rest()?[..] {
            [r, g, b, ..] => DVec3::new(r, g, b),
            _ => DVec3::ONE,
        };
        if !intensity.to_array().into_iter().all(within_f32) {
            return Err(self.words.error(
                keyword.offset,
                "a light with a negative channel",
                "write channels from 0",
            ));
        }
        self.model.lights.push(Light { position, intensity });
        Ok(())
    }

    /// `f r g b Kd Ks Shine T ior`.
    fn fill(&mut self, keyword: Word) -> Result<(), SceneError> {
        let color = self.color(keyword)?;
        let mut numbers = self.rest()?;
        if numbers.len() < 5 {
            let message = "fills with fewer than eight numbers: Kd 1, the others 0";
            self.assume(keyword, message, "write `f r g b Kd Ks Shine T ior`")?;
        }
        if numbers.is_empty() {
            numbers.push(1.0);
        }
        numbers.resize(5, 0.0);
        let fill = Fill { color, kd: numbers[0], ks: numbers[1], transmits: numbers[3], ior: numbers[4] };
        if let Some((what, remedy)) = fill.fault() {
            return Err(self.words.error(keyword.offset, what, remedy));
        }
        if let Some(message) = fill.assumed() {
            self.assume(
                keyword,
                message,
                "write weights Ks and T with a sum of at most 1, and an index of refraction",
            )?;
        }
        if fill.ks > 0.0 && numbers[2] > 0.0 {
            self.shining += 1;
        }
        self.select(fill);
        Ok(())
    }

    /// Makes `fill` the one in use; equal fills share a material.
    fn select(&mut self, fill: Fill) {
        let known = self.fills.iter().find(|(other, _)| *other == fill).copied();
        self.current = Some(known.unwrap_or_else(|| {
            let material = self.wanted.material.unwrap_or_else(|| {
                self.library.materials.push(fill.material(self.fills.len() + 1));
                self.library.materials.len() - 1
            });
            self.fills.push((fill, material));
            (fill, material)
        }));
    }

    /// The material in use; that of a file without fills is white.
    fn material(&mut self, keyword: Word) -> Result<usize, SceneError> {
        if self.current.is_none() {
            let message = "shapes before the first fill are white: Kd 0.8";
            self.assume(keyword, message, "write `f r g b Kd Ks Shine T ior` above them")?;
            self.select(Fill { color: DVec3::ONE, kd: 0.8, ks: 0.0, transmits: 0.0, ior: 0.0 });
        }
        Ok(self.current.map_or(0, |(_, material)| material))
    }

    /// The mesh that faces of `material` belong to: one for each that refracts, which it bounds; one for all others.
    fn mesh(&mut self, material: usize) -> &mut Mesh {
        let solid = self.library.materials[material].refracts().then_some(material);
        let at = self.solids.iter().position(|(bounds, _)| *bounds == solid).unwrap_or_else(|| {
            let name = self.words.source.file.display().to_string();
            let mesh = Mesh { name, vertices: Vec::new(), normals: Vec::new(), faces: Vec::new() };
            self.solids.push((solid, mesh));
            self.solids.len() - 1
        });
        &mut self.solids[at].1
    }

    /// `s x y z r`; a negative radius turns the inside out, which surfaces with two sides need not know.
    fn sphere(&mut self, keyword: Word) -> Result<(), SceneError> {
        let material = self.material(keyword)?;
        let (center, radius) = (self.vector(keyword)?, self.number(keyword)?.abs());
        let place = self.wanted.place;
        let Some(scale) = place.uniform_scale() else {
            return Err(self.words.error(
                keyword.offset,
                "a sphere that is stretched by the mesh's placement",
                "scale by one factor, without a shear",
            ));
        };
        if radius * scale < MIN_LENGTH {
            return self.assume(keyword, "spheres of radius 0 are left out", "write a radius above 0");
        }
        let center = place.point(center);
        self.model.spheres.push(Sphere { center, radius: radius * scale, material });
        Ok(())
    }

    /// `c`, then base and apex, each with its radius.
    fn cone(&mut self, keyword: Word) -> Result<(), SceneError> {
        let material = self.material(keyword)?;
        let base = (self.vector(keyword)?, self.number(keyword)?.abs());
        let apex = (self.vector(keyword)?, self.number(keyword)?.abs());
        let Some(corners) = cone::triangles(base, apex) else {
            return self.assume(
                keyword,
                "cones without a surface are left out",
                "write two ends and a radius above 0",
            );
        };
        self.reading.notes.add(&cone::note(), self.words.source.file, 0);
        for triangle in corners {
            self.triangle(triangle, material);
        }
        Ok(())
    }

    /// `p n` or `pp n`, then n corners, those of `pp` with a normal each.
    fn polygon(&mut self, keyword: Word, patch: bool) -> Result<(), SceneError> {
        let material = self.material(keyword)?;
        let count = self.number(keyword)?;
        if count.fract() != 0.0 || !(1.0..=f64::from(u32::MAX)).contains(&count) {
            return Err(self.words.error(
                keyword.offset,
                "no number of corners",
                "write `p 4` and four corners",
            ));
        }
        let mut corners: Vec<Corner> = Vec::new();
        for _ in 0..count as u32 {
            let point = self.vector(keyword)?;
            let normal = if patch { unit(self.vector(keyword)?) } else { None };
            corners.push((point, normal));
        }
        if corners.len() < 3 {
            return self.assume(
                keyword,
                "polygons of one or two corners are left out",
                "write three or more corners",
            );
        }
        if corners.iter().any(|(_, normal)| normal.is_none()) {
            corners.iter_mut().for_each(|(_, normal)| *normal = None);
        }
        let points: Vec<DVec3> = corners.iter().map(|(point, _)| *point).collect();
        let triangles = triangles(&points)
            .map_err(|(message, remedy)| self.words.error(keyword.offset, message, remedy))?;
        for triangle in triangles {
            self.triangle(triangle.map(|i| corners[i]), material);
        }
        Ok(())
    }

    /// Adds a triangle in its place.
    fn triangle(&mut self, corners: [Corner; 3], material: usize) {
        let place = self.wanted.place;
        let mesh = self.mesh(material);
        let first = mesh.vertices.len() as u32;
        let mut vertices = [first, first + 1, first + 2];
        mesh.vertices.extend(corners.map(|(point, _)| place.point(point)));
        let normals = match corners.map(|(_, normal)| normal) {
            [Some(a), Some(b), Some(c)] => {
                let first = mesh.normals.len() as u32;
                mesh.normals.extend([a, b, c].map(|normal| place.normal(normal)));
                Some([first, first + 1, first + 2])
            }
            _ => None,
        };
        let mut normals = normals;
        if place.mirrors() {
            vertices.swap(1, 2);
            if let Some(normals) = &mut normals {
                normals.swap(1, 2);
            }
        }
        mesh.faces.push(Face { vertices, normals, material });
    }

    /// Gives the lights their intensities and the meshes to the model.
    fn finish(self) -> Result<Model, SceneError> {
        let Reader { mut model, solids, reading, words, shining, .. } = self;
        model.meshes = solids.into_iter().map(|(_, mesh)| mesh).collect();
        let file = words.source.file;
        if model.meshes.is_empty() && model.spheres.is_empty() {
            return Err(words.error(0, "the file has no shapes", "add shapes such as `s 0 0 0 1`"));
        }
        let note = "highlights (Shine) of the lights are not drawn";
        reading.notes.add_count(note, shining, file, 0);
        let bounds = model.bounds();
        let (center, size) = (bounds.lo + (bounds.hi - bounds.lo) / 2.0, (bounds.hi - bounds.lo).length());
        // "1 / sqrt(number of lights)" of the SPD's text, at any distance.
        let share = 1.0 / (model.lights.len().max(1) as f64).sqrt();
        for light in &mut model.lights {
            let square = light.position.distance_squared(center).max(size * size / 16.0);
            light.intensity *= share * square;
        }
        let note = "lights that shine alike at any distance fall with its square here; at the scene's centre they agree";
        reading.notes.add_count(note, model.lights.len(), file, 0);
        Ok(model)
    }
}

/// Indices of the corners of the triangles of a polygon.
fn triangles(corners: &[DVec3]) -> Result<Vec<[usize; 3]>, polygon::Fault> {
    polygon::normal(corners)?;
    Ok((1..corners.len() - 1).map(|i| [0, i, i + 1]).collect())
}

#[cfg(test)]
mod tests;

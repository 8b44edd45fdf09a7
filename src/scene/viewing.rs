//! A scene around a model: the file's own camera and lights if it has any, otherwise a camera that sees all of the
//! model and two lights that show its shape.

use super::error::{SceneError, Source};
use super::library::Library;
use super::model::{Model, Wanted};
use super::notes::{Notes, Reading};
use super::parse::{HEIGHT, MIN_UP_SINE, WIDTH};
use super::table::{MAX_LENGTH, unit, within_f32};
use super::{Axis, Camera, Light, Mesh, ReadOptions, ReadTime, RenderDefaults, Scene, Sphere, Transform};
use super::{bounds::Bounds, model};
use glam::DVec3;
use std::path::Path;
use std::time::Duration;

/// Vertical field of view of the fitted camera, degrees: that of a scene's camera.
const FOV_DEGREES: f64 = 45.0;
/// Where the fitted camera stands, seen from the model: turned from its front to the right, and raised; degrees.
const TURNED_DEGREES: f64 = 35.0;
const RAISED_DEGREES: f64 = 25.0;
/// The share of the half picture that the model fills in the direction in which it is the largest.
const FILLS: f64 = 0.9;
/// Least distance from the eye to the model, in extents: a needle that points at the eye.
const CLOSEST: f64 = 0.05;

/// Least size of a model against its distance from the origin: the eye's place has decimals of 1e-5 of its distance
/// from the model, and f64 sixteen digits.
const FINEST: f64 = 1e-10;

/// Distance of the lights from the model's centre, in distances of the eye: so far that the near side of a model
/// that fills the picture receives at most twice the light of its centre.
const LIGHTS_AT: f64 = 4.0;
/// Directions to key and fill light along the camera's axes: right, up, toward the eye.
const KEY: DVec3 = DVec3::new(-0.6, 0.6, 1.0);
const FILL: DVec3 = DVec3::new(1.0, 0.2, 0.6);
/// Light of the fill light at the model's centre, against the key light's.
const FILL_SHARE: f64 = 0.25;
/// What a surface that faces the key light at the model's centre receives from both lights. With the ambient share of
/// 0.1 its colour is its diffuse colour.
const RECEIVED: f64 = 0.9;
/// A file's own lights are scaled if the brightest gives the model's centre less or more than this, facing it: files
/// give watts, candelas, or numbers for another exposure.
const SENSIBLE: std::ops::RangeInclusive<f64> = 0.1..=4.0;

/// Four samples smooth the edges; eight rays in a path see through a glass with its content.
const SAMPLES: u32 = 4;
const DEPTH: u32 = 8;
/// A grey between that of lit and of shadowed surfaces, so that both stand out.
const BACKGROUND: DVec3 = DVec3::new(0.18, 0.2, 0.22);

/// Reads the model `path`, whose bytes are `text`, and puts a scene around it.
pub(super) fn around(path: &Path, text: &[u8], options: &ReadOptions) -> Result<Scene, SceneError> {
    let source = Source { file: path, text };
    let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
    let object = format!("model `{name}`");
    let mut library = Library::new(Vec::new());
    let mut reading = Reading { strict: options.strict, notes: Notes::default() };
    let place = Transform::new(1.0, DVec3::ZERO, DVec3::ZERO);
    let wanted = Wanted { object: &object, material: None, place, node: None };
    let model = model::read(source, wanted, &mut library, &mut reading)?;

    let refuse = |what: &str, remedy: &str| Err(source.error(0, object.as_str(), what, remedy));
    let bounds = model.bounds();
    if bounds.is_empty() {
        return refuse("it holds no surfaces", "give a model with faces or spheres");
    }
    let size = (bounds.hi - bounds.lo).max_element();
    if size <= 0.0 {
        return refuse("all of its corners are one point", "give a model with an extent");
    }
    let away = bounds.lo.abs().max(bounds.hi.abs()).max_element();
    if size < FINEST * away {
        return refuse("it lies too far from the origin for its size", "move it nearer to the origin");
    }
    let own = match options.up {
        None => usable_camera(&model, path, &mut reading),
        Some(_) => None,
    };
    let up = options.up.unwrap_or_else(|| up_axis(path));
    let camera = match own {
        Some(camera) => sized(camera, options.size),
        None => fitted(&model, &bounds, up.vector(), options.size.unwrap_or([WIDTH, HEIGHT])),
    };
    let lights = match (model.lights.is_empty(), own) {
        (false, _) => exposed(&model.lights, &bounds, path, &mut reading),
        (true, None) => key_and_fill(&camera, &bounds),
        (true, Some(_)) => vec![headlight(&camera, &bounds)],
    };
    if !lights.iter().all(|light| light.intensity.to_array().into_iter().all(within_f32)) {
        return refuse(
            "it is too large to be lit in single precision",
            "use a larger unit of length, or place it in a scene with `scale`",
        );
    }
    note_missing(&model, own, up, path, &mut reading);
    let background = model.background.unwrap_or(BACKGROUND);
    let files = library.files().map(Path::to_owned).collect();
    Ok(Scene {
        file: path.to_owned(),
        read_time: ReadTime(Duration::ZERO, files),
        camera,
        render: RenderDefaults { samples: SAMPLES, depth: DEPTH, background },
        lights,
        materials: library.materials,
        spheres: model.spheres,
        polygons: Vec::new(),
        meshes: model.meshes,
        notes: reading.notes,
    })
}

/// Says what stands in for a camera and lights.
fn note_missing(model: &Model, own: Option<Camera>, up: Axis, path: &Path, reading: &mut Reading) {
    let whose = if model.cameras.is_empty() { "no camera in the file" } else { "no camera of the file" };
    let camera = format!("{whose}: one that sees all of it, {} up", up.name());
    let note = match (own, model.lights.is_empty()) {
        (None, true) => camera + "; no lights: a key light and a fill light",
        (None, false) => camera,
        (Some(_), true) => "no lights in the file: one at the camera".into(),
        (Some(_), false) => return,
    };
    reading.notes.add(&note, path, 0);
}

/// The axis that points up in files of this kind: z where shapes are measured or printed (STL, PLY) and in Haines' NFF,
/// y in OBJ and glTF.
fn up_axis(path: &Path) -> Axis {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    if ["stl", "ply", "nff"].contains(&extension.as_str()) { Axis::Z } else { Axis::Y }
}

/// The file's first camera that can be used.
fn usable_camera(model: &Model, path: &Path, reading: &mut Reading) -> Option<Camera> {
    let is_usable = |camera: &&Camera| {
        let finite = [camera.look_from, camera.look_at, camera.up].iter().all(|v| v.is_finite());
        let (view, up) = (unit(camera.look_at - camera.look_from), unit(camera.up));
        let upright = view.zip(up).is_some_and(|(view, up)| up.cross(view).length() >= MIN_UP_SINE);
        let tan = (camera.fov / 2.0).tan();
        finite
            && upright
            && camera.look_from.abs().max_element() <= MAX_LENGTH
            && tan > 0.0
            && tan.is_finite()
    };
    let camera = model.cameras.iter().find(is_usable);
    if camera.is_none() {
        let note = "cameras that look nowhere, or along `up`, are left out";
        reading.notes.add_count(note, model.cameras.len(), path, 0);
    }
    let camera = *camera?;
    let note = "further cameras of the file are left out: the first is the view";
    reading.notes.add_count(note, model.cameras.len() - 1, path, 0);
    // As a scene's text states it: degrees, which come back from radians only nearly, and a unit vector.
    let up = unit(camera.up)?;
    Some(Camera { fov: camera.fov.to_degrees().to_radians(), up, ..camera })
}

fn sized(camera: Camera, size: Option<[u32; 2]>) -> Camera {
    let [width, height] = size.unwrap_or([camera.width, camera.height]);
    Camera { width, height, ..camera }
}

/// A camera to the right of the model's front and above it, which turns to the middle of the model and sees all of it.
///
/// Of the positions with this direction it is the nearest from which every point lies within the picture. With x, z
/// the coordinates of a point along an axis of the picture and forward, e those of the eye, and t the tangent of half
/// the field of view along that axis, a point is inside if |x - e_x| <= t (z - e_z). With P the greatest x - t z of all
/// points, and N the greatest -x - t z, that is P <= e_x - t e_z and N <= -e_x - t e_z: the nearest eye has
/// e_z = -(P + N) / 2t, and e_x = (P - N) / 2. A sphere reaches r sqrt(1 + t^2) beyond its centre in both sums.
fn fitted(model: &Model, bounds: &Bounds, up: DVec3, [width, height]: [u32; 2]) -> Camera {
    let front = if up.z == 0.0 { DVec3::Z } else { DVec3::NEG_Y };
    let (turned, raised) = (TURNED_DEGREES.to_radians(), RAISED_DEGREES.to_radians());
    let side = up.cross(front);
    let eye = (front * turned.cos() + side * turned.sin()) * raised.cos() + up * raised.sin();
    let fov = FOV_DEGREES.to_radians();
    let center = middle(bounds);
    let forward = -eye;
    let x = forward.cross(up).normalize();
    let y = x.cross(forward);
    let tan = FILLS * (fov / 2.0).tan();
    let tans = [tan * f64::from(width) / f64::from(height), tan];

    let mut most = [[f64::NEG_INFINITY; 2]; 2];
    let mut nearest = f64::INFINITY;
    model.each_ball(|point, radius| {
        let point = point - center;
        let depth = point.dot(forward);
        nearest = nearest.min(depth - radius);
        for ((most, tan), along) in most.iter_mut().zip(tans).zip([x, y]) {
            let reach = radius * (1.0 + tan * tan).sqrt() - tan * depth;
            let across = point.dot(along);
            most[0] = most[0].max(across + reach);
            most[1] = most[1].max(-across + reach);
        }
    });
    let back = most.iter().zip(tans).map(|([p, n], tan)| -(p + n) / (2.0 * tan));
    let size = (bounds.hi - bounds.lo).max_element();
    let back = back.fold(nearest - CLOSEST * size, f64::min);
    let [[px, nx], [py, ny]] = most;
    let look_from = center + x * ((px - nx) / 2.0) + y * ((py - ny) / 2.0) + forward * back;
    let look_at = look_from - forward * back.min(-CLOSEST * size);
    let short = |v| shortened(v, -back);
    Camera { look_from: short(look_from), look_at: short(look_at), up, fov, width, height }
}

/// `v` in decimals of 1e-5 of `size` or finer, so that a text of it is short.
fn shortened(v: DVec3, size: f64) -> DVec3 {
    let decimals = (5.0 - size.log10().floor()).clamp(0.0, 300.0) as usize;
    let short = |x: f64| format!("{x:.decimals$}").parse().map_or(x, |short: f64| short + 0.0);
    DVec3::from_array(v.to_array().map(short))
}

/// Four significant digits of `x`.
fn four_digits(x: f64) -> f64 {
    format!("{x:.3e}").parse().unwrap_or(x)
}

fn middle(bounds: &Bounds) -> DVec3 {
    bounds.lo + (bounds.hi - bounds.lo) / 2.0
}

/// Two lights far behind the eye: the key light above its left shoulder, the fill light at its right.
fn key_and_fill(camera: &Camera, bounds: &Bounds) -> Vec<Light> {
    let [right, up, forward] = camera.axes();
    let center = middle(bounds);
    let away = LIGHTS_AT * camera.look_from.distance(center);
    let [key, fill] = [KEY, FILL].map(|d| (right * d.x + up * d.y - forward * d.z).normalize());
    let received = RECEIVED / (1.0 + FILL_SHARE * key.dot(fill));
    let light = |direction: DVec3, received: f64| {
        let position = shortened(center + direction * away, away);
        let intensity = DVec3::splat(four_digits(received * position.distance_squared(center)));
        Light { position, intensity }
    };
    vec![light(key, received), light(fill, FILL_SHARE * received)]
}

/// One light at the eye, which no wall of a room hides.
fn headlight(camera: &Camera, bounds: &Bounds) -> Light {
    let reach = camera.look_from.distance(middle(bounds)).max((bounds.hi - bounds.lo).length() / 4.0);
    Light { position: camera.look_from, intensity: DVec3::splat(four_digits(RECEIVED * reach * reach)) }
}

/// The file's own lights, scaled together if what they give to the model's centre would be black or white.
fn exposed(lights: &[Light], bounds: &Bounds, path: &Path, reading: &mut Reading) -> Vec<Light> {
    let center = middle(bounds);
    let near = (bounds.hi - bounds.lo).length_squared() / 16.0;
    let received =
        |light: &Light| light.intensity.max_element() / light.position.distance_squared(center).max(near);
    let most = lights.iter().map(received).fold(0.0, f64::max);
    if most == 0.0 || !most.is_finite() || SENSIBLE.contains(&most) || reading.strict {
        return lights.to_vec();
    }
    let factor = four_digits(RECEIVED / most);
    reading.notes.add(
        &format!("the file's lights are scaled by {factor:e}, for a picture neither black nor white"),
        path,
        0,
    );
    lights.iter().map(|light| Light { intensity: light.intensity * factor, ..*light }).collect()
}

impl Model {
    /// Gives every corner of a face, with radius 0, and every sphere to `take`.
    fn each_ball(&self, mut take: impl FnMut(DVec3, f64)) {
        for Mesh { vertices, faces, .. } in &self.meshes {
            faces.iter().flat_map(|face| face.vertices).for_each(|v| take(vertices[v as usize], 0.0));
        }
        self.spheres.iter().for_each(|Sphere { center, radius, .. }| take(*center, *radius));
    }

    /// The box of its faces and spheres.
    pub(super) fn bounds(&self) -> Bounds {
        let meshes = self.meshes.iter().map(Mesh::bounds);
        let spheres = self.spheres.iter().map(|s| Bounds::of_sphere(s.center, s.radius));
        meshes.chain(spheres).fold(Bounds::EMPTY, Bounds::union)
    }
}

#[cfg(test)]
mod tests;

//! Scene text (TOML) to [`Scene`].

use super::error::{SceneError, Source, did_you_mean, list, unreadable};
use super::library::Library;
use super::model::{Model, Wanted};
use super::notes::{Notes, Reading};
use super::table::{MAX_LENGTH, MIN_LENGTH, NOT_NEGATIVE, Table, Value, unit};
use super::{Camera, Light, Material, Polygon, ReadOptions, ReadTime, RenderDefaults, Scene, Sphere};
use super::{material, model, place, polygon, variables, viewing};
use glam::DVec3;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::{Duration, Instant};
use toml::de::{DeTable, DeValue};

/// Largest width and height, pixels: the product of the two still numbers every pixel in a u32.
pub(crate) const MAX_SIDE: u32 = 65_535;
/// Most samples per pixel: beyond 2^24 a sample changes a single-precision mean by less than an ulp.
pub(crate) const MAX_SAMPLES: u32 = 1 << 24;
/// Deepest paths: after 1024 hits that each halve it, a throughput has left the range even of f64.
pub(crate) const MAX_DEPTH: u32 = 1024;
/// Smallest sine of the angle between view and up: the camera's axes are off by 2^-53 divided by it,
/// which must stay below the 2^-24 of single-precision directions with some bits to spare.
pub(super) const MIN_UP_SINE: f64 = 1.0 / (1u64 << 26) as f64;

/// Defaults of `[camera]`: up is y, 45 degrees, 600 x 500 pixels.
const UP: DVec3 = DVec3::Y;
const FOV_DEGREES: f64 = 45.0;
pub(super) const WIDTH: u32 = 600;
pub(super) const HEIGHT: u32 = 500;
/// Defaults of `[render]`: one sample through the pixel's centre, four rays in the longest path (in and
/// out of a glass object and one more), a black background.
const RENDER: RenderDefaults = RenderDefaults { samples: 1, depth: 4, background: DVec3::ZERO };

const TOP: [&str; 7] = ["camera", "render", "light", "material", "sphere", "polygon", "mesh"];

impl Scene {
    /// Reads a scene file and all files that it names.
    ///
    /// # Errors
    /// The first mistake in the text (see [`SceneError`]): syntax, unknown keys, wrong types, missing
    /// materials, impossible values, files that cannot be read.
    pub fn load(path: impl AsRef<Path>) -> Result<Scene, SceneError> {
        Scene::load_with(path, &ReadOptions::default())
    }

    /// Reads a scene file and all files that it names, as `options` say. A file of shapes ([`is_model`](super::is_model))
    /// gets a scene of its own: its camera and lights, or a camera that sees all of it and two lights.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn load_with(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Scene, SceneError> {
        let start = Instant::now();
        let scene = load(path.as_ref(), options)?;
        Ok(timed(scene, start))
    }

    /// Reads a scene text as if it were the file `path`, which need not exist: messages name it, and files that the
    /// text names are relative to its folder.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn parse(text: &str, path: impl AsRef<Path>) -> Result<Scene, SceneError> {
        Scene::parse_with(text, path, &ReadOptions::default())
    }

    /// [`Scene::parse`], as `options` say.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn parse_with(
        text: &str,
        path: impl AsRef<Path>,
        options: &ReadOptions,
    ) -> Result<Scene, SceneError> {
        let start = Instant::now();
        let scene = parse(text, path.as_ref(), options)?;
        Ok(timed(scene, start))
    }
}

/// `scene`, whose reading began at `start`.
fn timed(mut scene: Scene, start: Instant) -> Scene {
    scene.read_time.0 = start.elapsed();
    scene
}

impl FromStr for Scene {
    type Err = SceneError;

    /// Reads a scene text; files that it names are relative to the current folder.
    fn from_str(text: &str) -> Result<Scene, SceneError> {
        Scene::parse(text, "scene")
    }
}

fn load(path: &Path, options: &ReadOptions) -> Result<Scene, SceneError> {
    let is_model = model::is_model(path);
    let what = if is_model { "model" } else { "scene" };
    let bytes = std::fs::read(path).map_err(|e| unreadable(path, what, e))?;
    if is_model {
        return match options.variables.first() {
            None => viewing::around(path, &bytes, options),
            Some((name, _)) => Err(variables::unnamed(Source { file: path, text: &bytes }, name)),
        };
    }
    parse(utf8(&bytes, path)?, path, options)
}

/// The bytes of a scene as text.
pub(crate) fn utf8<'a>(bytes: &'a [u8], path: &Path) -> Result<&'a str, SceneError> {
    std::str::from_utf8(bytes).map_err(|e| {
        let source = Source { file: path, text: bytes };
        source.error(e.valid_up_to(), "scene", "the text is not UTF-8", "save the file as UTF-8")
    })
}

fn parse(text: &str, path: &Path, options: &ReadOptions) -> Result<Scene, SceneError> {
    let filled = variables::fill(text, path, &options.variables)?;
    parse_filled(&filled.text, path, options).map_err(|error| filled.replace(error, path))
}

/// Reads a text without variables.
fn parse_filled(text: &str, path: &Path, options: &ReadOptions) -> Result<Scene, SceneError> {
    let source = Source { file: path, text: text.as_bytes() };
    let document = DeTable::parse(text).map_err(|error| {
        let offset = error.span().map_or(0, |span| span.start);
        source.error(
            offset,
            "scene",
            error.message(),
            "correct the TOML: `key = value`, `[camera]`, `[[sphere]]`",
        )
    })?;
    let top = Table { source, object: "scene".to_owned(), offset: 0, entries: document.get_ref() };
    top.only(&TOP)?;

    let materials = materials(&top)?;
    let reading = Reading { strict: options.strict, notes: Notes::default() };
    let (own, library) = (materials.len(), Library::new(materials));
    let mut reader = Reader { own, library, reading, files: Vec::new() };
    let camera = camera(&single(&top, "camera")?.ok_or_else(|| {
        top.error(
            "`[camera]` is missing",
            "add `[camera]` with the lines `look_from = [0, 5, 14]` and `look_at = [0, 5, 0]`",
        )
    })?)?;
    let render = single(&top, "render")?.map_or(Ok(RENDER), |table| render(&table))?;
    let lights = each(&top, "light")?.iter().map(light).collect::<Result<_, _>>()?;
    let mut spheres: Vec<_> =
        each(&top, "sphere")?.iter().map(|t| reader.sphere(t)).collect::<Result<_, _>>()?;
    let polygons = each(&top, "polygon")?.iter().map(|t| reader.polygon(t)).collect::<Result<_, _>>()?;
    let mut meshes = Vec::new();
    for table in each(&top, "mesh")? {
        let model = reader.mesh(table)?;
        meshes.extend(model.meshes);
        spheres.extend(model.spheres);
    }
    let Reader { library, reading, mut files, .. } = reader;
    files.extend(library.files().map(Path::to_owned));
    let (materials, notes) = (library.materials, reading.notes);
    let (file, read_time) = (path.to_owned(), ReadTime(Duration::ZERO, files));
    Ok(Scene { file, read_time, camera, render, lights, materials, spheres, polygons, meshes, notes })
}

/// The table `[key]`, if written.
fn single<'a>(top: &'a Table<'a>, key: &'a str) -> Result<Option<Table<'a>>, SceneError> {
    let Some(value) = top.get(key) else { return Ok(None) };
    match value.value.get_ref() {
        DeValue::Table(entries) => Ok(Some(Table {
            source: top.source,
            object: key.to_owned(),
            offset: value.value.span().start,
            entries,
        })),
        _ => Err(value.error(format!("`{key}` is not one table"), format!("write it once, as `[{key}]`"))),
    }
}

/// The tables `[[key]]`, called "key 1", "key 2", ...
fn each<'a>(top: &'a Table<'a>, key: &'a str) -> Result<Vec<Table<'a>>, SceneError> {
    let Some(value) = top.get(key) else { return Ok(Vec::new()) };
    let wrong = |at: &Value| {
        at.error(format!("`{key}` is not a list of tables"), format!("write each one as `[[{key}]]`"))
    };
    let DeValue::Array(items) = value.value.get_ref() else { return Err(wrong(&value)) };
    let table = |(i, item): (usize, &'a toml::Spanned<DeValue<'a>>)| match item.get_ref() {
        DeValue::Table(entries) => Ok(Table {
            source: top.source,
            object: format!("{key} {}", i + 1),
            offset: item.span().start,
            entries,
        }),
        _ => Err(wrong(&Value { value: item, ..value })),
    };
    items.iter().enumerate().map(table).collect()
}

/// All `[material.NAME]`, in the text's order.
fn materials(top: &Table) -> Result<Vec<Material>, SceneError> {
    let Some(all) = single(top, "material")? else { return Ok(Vec::new()) };
    let mut entries: Vec<_> = all.entries.iter().collect();
    entries.sort_by_key(|(name, _)| name.span().start);
    let read = |(name, value): &(&toml::Spanned<toml::de::DeString>, &toml::Spanned<DeValue>)| {
        let name = name.get_ref();
        let object = format!("material `{name}`");
        let DeValue::Table(entries) = value.get_ref() else {
            return Err(top.source.error(
                value.span().start,
                object,
                "a material is a table",
                "write `[material.NAME]` with the line `diffuse = [0.8, 0.8, 0.8]`",
            ));
        };
        let table = Table { source: top.source, object, offset: value.span().start, entries };
        material::material(name, &table)
    };
    entries.iter().map(read).collect()
}

fn camera(table: &Table) -> Result<Camera, SceneError> {
    table.only(&["look_from", "look_at", "up", "fov", "width", "height"])?;
    let look_from = table.need("look_from", "[0, 5, 14]")?.position()?;
    let at = table.need("look_at", "[0, 5, 0]")?;
    let look_at = at.position()?;
    let view = unit(look_at - look_from).ok_or_else(|| {
        at.error(
            "`look_at` equals `look_from`",
            "move one of the two: the camera looks from one to the other",
        )
    })?;
    let up = table.get("up").map_or(Ok(UP), |value| value.direction())?;
    if up.cross(view).length() < MIN_UP_SINE {
        let other = if view.y.abs() < 0.5 { "[0, 1, 0]" } else { "[0, 0, 1]" };
        let place = table.get("up").unwrap_or(at);
        return Err(place.error("`up` is parallel to the view", format!("write `up = {other}`")));
    }
    let rule = "between 0 and 180 degrees, both excluded";
    let fov = table.get("fov").map_or(Ok(FOV_DEGREES), |value| {
        // Radians must not round to 0 or pi, where the image plane is a point or infinite.
        let possible = |x: f64| x > 0.0 && (x / 2.0).to_radians().tan() > 0.0 && x < 180.0;
        value.number_where(possible, rule)
    })?;
    let side = |key, default| table.get(key).map_or(Ok(default), |value| value.count(MAX_SIDE));
    Ok(Camera {
        look_from,
        look_at,
        up,
        fov: fov.to_radians(),
        width: side("width", WIDTH)?,
        height: side("height", HEIGHT)?,
    })
}

fn render(table: &Table) -> Result<RenderDefaults, SceneError> {
    table.only(&["samples", "depth", "background"])?;
    let count = |key, default, max| table.get(key).map_or(Ok(default), |value| value.count(max));
    Ok(RenderDefaults {
        samples: count("samples", RENDER.samples, MAX_SAMPLES)?,
        depth: count("depth", RENDER.depth, MAX_DEPTH)?,
        background: table.get("background").map_or(Ok(RENDER.background), |value| value.grey_or_color())?,
    })
}

fn light(table: &Table) -> Result<Light, SceneError> {
    table.only(&["position", "intensity"])?;
    let position = table.need("position", "[0, 5, 5]")?.position()?;
    let intensity = table.need("intensity", "10")?;
    if !intensity.is_number() && intensity.value.get_ref().as_array().is_none() {
        return Err(intensity.error(
            format!("`intensity` must be a number or [r, g, b], each {NOT_NEGATIVE}"),
            "write it as `intensity = 10` or `intensity = [10, 8, 6]`",
        ));
    }
    Ok(Light { position, intensity: intensity.grey_or_color()? })
}

/// Reads the objects, which name materials.
struct Reader {
    library: Library,
    /// The first `own` materials are the scene text's; those of MTL files follow.
    own: usize,
    reading: Reading,
    /// Files of meshes.
    files: Vec<PathBuf>,
}

impl Reader {
    /// Index of the scene text's material that `value` names.
    fn material(&self, value: &Value) -> Result<usize, SceneError> {
        let name = value.text("\"white\"")?;
        let names = || self.library.materials[..self.own].iter().map(|m| m.name.as_str());
        names().position(|n| n == name).ok_or_else(|| {
            let remedy = match list(names()) {
                none if none.is_empty() => {
                    format!("add `[material.{name}]` with `diffuse = [0.8, 0.8, 0.8]`")
                }
                some => format!("use one of {some}, or add `[material.{name}]`"),
            };
            value.error(format!("there is no material `{name}`{}", did_you_mean(name, names())), remedy)
        })
    }

    fn sphere(&self, table: &Table) -> Result<Sphere, SceneError> {
        table.only(&["center", "radius", "material"])?;
        let sizes = MIN_LENGTH..=MAX_LENGTH;
        let rule = format!("greater than 0, from {:e} to {:e}", sizes.start(), sizes.end());
        Ok(Sphere {
            center: table.need("center", "[0, 1, 0]")?.position()?,
            radius: table.need("radius", "1.0")?.number_where(|r| sizes.contains(&r), &rule)?,
            material: self.material(&table.need("material", "\"white\"")?)?,
        })
    }

    fn polygon(&mut self, table: &Table) -> Result<Polygon, SceneError> {
        table.only(&["vertices", "normal", "material"])?;
        let corners = table.need("vertices", "[[0, 0, 0], [1, 0, 0], [0, 1, 0]]")?;
        let items = corners.items("a list of corners", "[[0, 0, 0], [1, 0, 0], [0, 1, 0]]")?;
        let mut vertices = items.iter().map(Value::position).collect::<Result<Vec<_>, _>>()?;
        if polygon::drop_repeated(&mut vertices) {
            corners.assume(
                &mut self.reading,
                "corners of a polygon that repeat the one before count once",
                "remove the corner",
            )?;
        }
        let at_corners = |(message, remedy): polygon::Fault| corners.error(message, remedy);
        let mut normal = polygon::normal(&vertices).map_err(at_corners)?;
        if let Some(written) = table.get("normal") {
            let direction = written.direction()?;
            if direction.cross(normal).length() > polygon::NORMAL_LEAN {
                let [x, y, z] = normal.to_array();
                return Err(written.error(
                    "`normal` is not perpendicular to the polygon",
                    format!("write `normal = [{x:.6}, {y:.6}, {z:.6}]` (or its opposite), or leave it out"),
                ));
            }
            if direction.dot(normal) < 0.0 {
                vertices[1..].reverse();
                normal = -normal;
            }
        }
        let cut = polygon::cut(&vertices).map_err(at_corners)?;
        Ok(Polygon { vertices, normal, cut, material: self.material(&table.need("material", "\"white\"")?)? })
    }

    fn mesh(&mut self, mut table: Table) -> Result<Model, SceneError> {
        table.only(&["file", "node", "material", "matrix", "scale", "rotate", "translate"])?;
        let name = table.need("file", "\"cube.obj\"")?.text("\"cube.obj\"")?.to_owned();
        table.object = format!("mesh `{name}`");
        let file = table.need("file", "\"cube.obj\"")?;
        let whole = table.get("material").map(|value| self.material(&value)).transpose()?;
        let node = table.get("node").map(|value| value.text("\"wheel\"")).transpose()?;
        let place = place::of(&table)?;

        let path = table.source.file.parent().unwrap_or(Path::new("")).join(&name);
        let text = std::fs::read(&path).map_err(|e| {
            let message = format!("`{}` cannot be read", path.display());
            let error = file.error(message, "correct the path; it starts at the scene file's folder");
            SceneError { cause: Some(e), ..error }
        })?;
        self.files.push(path.clone());
        let source = Source { file: &path, text: &text };
        let wanted = Wanted { object: &table.object, material: whole, place, node };
        model::read(source, wanted, &mut self.library, &mut self.reading)
    }
}

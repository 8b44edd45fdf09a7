//! The scene as its author means it: user's units (metres), radians, linear RGB, everything `f64`
//! and already checked. [`Scene::load`] and [`Scene::parse`] (and their `_with` forms) are the only ways from text to a [`Scene`].
//! A scene that is built by hand must keep the ranges that the fields state: rendering relies on them.

mod beside;
pub mod bounds;
mod error;
mod gltf;
mod import;
mod library;
mod material;
mod mean_color;
mod mesh_builder;
mod model;
mod model_file;
mod mtl;
mod nff;
mod notes;
mod obj;
mod parse;
mod place;
mod plain_words;
mod ply;
mod polygon;
#[doc(hidden)]
pub mod procedural;
mod read_options;
mod stl;
mod table;
mod text;
mod transform;
mod tokens;
mod triangulate;
mod variables;
mod viewing;

pub use error::SceneError;
pub use import::import;
pub use model::is_model;
pub use notes::{Note, Notes};
pub(crate) use parse::{MAX_DEPTH, MAX_SAMPLES, MAX_SIDE, utf8};
pub use read_options::{Axis, ReadOptions};
pub use transform::{Transform, rotation};
pub(crate) use variables::is_name;

use crate::scene::bounds::Bounds;
use glam::DVec3;
use rayon::prelude::*;
use std::fmt;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// A whole scene. Indices into `materials` are always in range.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// The file it came from, for messages; empty if built by hand.
    pub file: PathBuf,
    /// How long reading and checking it took; zero if built by hand.
    pub read_time: ReadTime,
    /// The eye.
    pub camera: Camera,
    /// What the scene's author asked for; the command line overrides.
    pub render: RenderDefaults,
    /// Point lights.
    pub lights: Vec<Light>,
    /// All materials, in the order of the text (MTL materials follow).
    pub materials: Vec<Material>,
    /// Analytic spheres.
    pub spheres: Vec<Sphere>,
    /// Planar polygons.
    pub polygons: Vec<Polygon>,
    /// Triangle meshes, already scaled, rotated and moved to their place.
    pub meshes: Vec<Mesh>,
    /// What its readers assumed or left out; empty if built by hand.
    pub notes: Notes,
}

/// How long it took to read a scene, and from which files besides the scene text. No property of the scene: two
/// readings of one file are equal, and print alike.
#[derive(Clone, Default)]
pub struct ReadTime(pub Duration, pub Vec<PathBuf>);

impl PartialEq for ReadTime {
    fn eq(&self, _: &ReadTime) -> bool {
        true
    }
}

impl fmt::Debug for ReadTime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("ReadTime")
    }
}

/// Pinhole camera. Pixel (0, 0) is top left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Position of the eye, metres.
    pub look_from: DVec3,
    /// The point in the middle of the image, metres; never equal to `look_from`.
    pub look_at: DVec3,
    /// Direction that points up in the image; never parallel to the view.
    pub up: DVec3,
    /// Vertical field of view, radians, in (0, pi).
    pub fov: f64,
    /// Image width, pixels.
    pub width: u32,
    /// Image height, pixels.
    pub height: u32,
}

impl Camera {
    /// Unit vectors to the right, up and forward.
    pub fn axes(&self) -> [DVec3; 3] {
        let forward = (self.look_at - self.look_from).normalize();
        let right = forward.cross(self.up).normalize();
        [right, right.cross(forward), forward]
    }
}

/// `[render]`: defaults of a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RenderDefaults {
    /// Samples per pixel, at least 1.
    pub samples: u32,
    /// Rays in the longest path; 1 = neither reflection nor refraction.
    pub depth: u32,
    /// What a ray that hits nothing sees, linear RGB.
    pub background: DVec3,
}

/// A point light. Not visible itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Light {
    /// Metres.
    pub position: DVec3,
    /// Linear RGB; a surface at distance d and angle a receives `intensity * cos(a) / d^2`.
    pub intensity: DVec3,
}

/// How the secondary weight divides between reflection and refraction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fresnel {
    /// A constant share of reflection, in [0, 1] (the report's `kersnel`).
    Constant(f64),
    /// Schlick 1994, eq. 24, with the transmitted angle where the ray leaves the denser side.
    Schlick,
    /// The unpolarised dielectric Fresnel equations.
    Exact,
}

impl Fresnel {
    /// True if some light is refracted, so that the index of refraction matters.
    pub fn transmits(self) -> bool {
        !matches!(self, Fresnel::Constant(f) if f >= 1.0)
    }
}

/// One material; scene-format.md gives the meaning of each number.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Name in the scene text or the MTL file.
    pub name: String,
    /// Diffuse colour, linear RGB.
    pub diffuse: DVec3,
    /// Own colour = `ambient * diffuse` + diffuse light.
    pub ambient: f64,
    /// Weight of reflected and refracted light against own colour, in [0, 1].
    pub secondary: f64,
    /// Share of `secondary` that is reflection.
    pub fresnel: Fresnel,
    /// Index of refraction inside, in [1e-3, 1e3].
    pub ior: f64,
    /// Where solids overlap, the one of highest priority fills the space; of equal ones the last entered.
    pub priority: i32,
    /// What its file says that is not drawn; none if there is nothing.
    pub undrawn: Option<Box<Undrawn>>,
}

/// Properties of a material that are kept but not drawn.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Undrawn {
    /// Colour of the highlight, linear RGB (MTL: `Ks`).
    pub specular: Option<DVec3>,
    /// Exponent of the highlight (MTL: `Ns`).
    pub shininess: Option<f64>,
    /// Textures, in the order of the file.
    pub textures: Vec<TextureFile>,
}

/// A texture that a material names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TextureFile {
    /// The keyword that names it: `map_Kd`.
    pub role: &'static str,
    /// Its file; it may not exist.
    pub file: PathBuf,
}

impl Material {
    /// True if a ray goes on through this material: it bounds a solid.
    pub fn refracts(&self) -> bool {
        self.secondary > 0.0 && self.fresnel.transmits()
    }

    /// True if a ray is mirrored or refracted here.
    pub fn has_secondary(&self) -> bool {
        self.secondary > 0.0
    }
}

/// An analytic sphere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    /// Metres.
    pub center: DVec3,
    /// Metres, > 0.
    pub radius: f64,
    /// Index into [`Scene::materials`].
    pub material: usize,
}

/// A planar polygon with at least three corners, convex or not. A refracting polygon is a thin sheet: it
/// bounds no solid, and what it refracts goes straight on.
#[derive(Debug, Clone, PartialEq)]
pub struct Polygon {
    /// Corners, metres, counter-clockwise seen from the side the normal points to.
    pub vertices: Vec<DVec3>,
    /// Unit normal (given, or from the corners).
    pub normal: DVec3,
    /// Its triangles, as indices of corners; empty if they fan from the first corner, as in [`Polygon::fan`].
    pub cut: Vec<[u32; 3]>,
    /// Index into [`Scene::materials`].
    pub material: usize,
}

/// A triangle mesh. Where its material refracts, the mesh bounds a solid.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    /// The OBJ file's path, or any name, for messages.
    pub name: String,
    /// Metres, in the scene's space.
    pub vertices: Vec<DVec3>,
    /// Unit vectors; empty if the file has none.
    pub normals: Vec<DVec3>,
    /// Triangles (larger faces of the file are cut).
    pub faces: Vec<Face>,
}

/// One triangle of a [`Mesh`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Face {
    /// Indices into [`Mesh::vertices`].
    pub vertices: [u32; 3],
    /// Indices into [`Mesh::normals`]: shading normals, interpolated over the triangle.
    pub normals: Option<[u32; 3]>,
    /// Index into [`Scene::materials`].
    pub material: usize,
}

impl Mesh {
    /// The box of its faces, metres.
    pub fn bounds(&self) -> Bounds {
        // In pieces of one size: whether 0 or -0 is the least must not depend on the number of threads.
        const PIECE: usize = 1 << 15;
        let piece = |faces: &[Face]| {
            let corners = faces.iter().flat_map(|f| f.vertices).map(|v| self.vertices[v as usize]);
            corners.fold(Bounds::EMPTY, Bounds::with)
        };
        let pieces: Vec<Bounds> = self.faces.par_chunks(PIECE).map(piece).collect();
        pieces.into_iter().fold(Bounds::EMPTY, Bounds::union)
    }
}

impl Scene {
    /// The files that it was read from: the scene text, then those that it names. None of a scene built by hand.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let own = (!self.file.as_os_str().is_empty()).then_some(self.file.as_path());
        own.into_iter().chain(self.read_time.1.iter().map(PathBuf::as_path))
    }

    /// Number of triangles after the polygons are cut.
    pub fn triangle_count(&self) -> usize {
        self.polygons.iter().map(Polygon::triangle_count).sum::<usize>()
            + self.meshes.iter().map(|m| m.faces.len()).sum::<usize>()
    }
}

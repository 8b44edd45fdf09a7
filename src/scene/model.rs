//! Files that hold shapes: a format's reader gives a [`Model`], whose parts join the scene.

use super::error::{SceneError, Source};
use super::library::Library;
use super::notes::Reading;
use super::{Camera, Light, Mesh, Sphere, Transform, obj};

/// What a file of shapes holds, already in the scene's space.
#[derive(Debug, Default)]
pub(super) struct Model {
    /// Triangle meshes; one that refracts bounds one solid.
    pub meshes: Vec<Mesh>,
    /// Analytic spheres.
    pub spheres: Vec<Sphere>,
    /// Point lights of the file. A scene's `[[mesh]]` does not use them; `render MODEL` does.
    pub lights: Vec<Light>,
    /// Cameras of the file, in its order; used like `lights`.
    pub cameras: Vec<Camera>,
}

/// The part of a file that is wanted, and where it goes.
#[derive(Clone, Copy)]
pub(super) struct Wanted<'a> {
    /// What messages call it: "mesh `cube.obj`".
    pub object: &'a str,
    /// The scene's material for all of it; the file's own where absent.
    pub material: Option<usize>,
    /// From the file's space to the scene's.
    pub place: Transform,
    /// The node to take, with all below it (glTF), or group (OBJ `o`, `g`); everything if absent.
    pub node: Option<&'a str>,
}

/// Reads `source` by the format that its name and content say.
pub(super) fn read(
    source: Source,
    wanted: Wanted,
    library: &mut Library,
    reading: &mut Reading,
) -> Result<Model, SceneError> {
    obj::read(source, wanted, library, reading)
}

//! Files that hold shapes: a format's reader gives a [`Model`], whose parts join the scene.

use super::error::{SceneError, Source};
use super::library::Library;
use super::model_file::ModelFile;
use super::notes::Reading;
use super::{Camera, Light, Mesh, Sphere, Transform, gltf, nff, obj, ply, stl};
use glam::DVec3;
use std::path::Path;

/// Endings of the names of files that [`read`] reads.
const EXTENSIONS: [&str; 7] = ["obj", "gltf", "glb", "vrm", "ply", "stl", "nff"];

/// True if the name of the file says that it holds shapes rather than a scene.
pub fn is_model(file: impl AsRef<Path>) -> bool {
    let extension = file.as_ref().extension().unwrap_or_default();
    EXTENSIONS.iter().any(|known| extension.eq_ignore_ascii_case(known))
}

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
    /// Linear RGB of rays that hit nothing, if the file says; used like `lights`.
    pub background: Option<DVec3>,
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

/// A format of files of shapes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Gltf,
    Nff,
    Obj,
    Ply,
    Stl,
}

/// The format that the content says, or else the name's extension; OBJ, which any text may be, if neither does.
fn format(source: Source) -> Format {
    let bytes = source.text;
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    let extension = source.file.extension().unwrap_or_default().to_ascii_lowercase();
    if bytes.starts_with(b"glTF") || text.starts_with(b"{") {
        Format::Gltf
    } else if ply::is_ply(bytes) {
        Format::Ply
    } else if stl::is_binary(bytes) || stl::is_ascii(bytes) {
        Format::Stl
    } else {
        match extension.to_str() {
            Some("gltf" | "glb" | "vrm") => Format::Gltf,
            Some("ply") => Format::Ply,
            Some("stl") => Format::Stl,
            Some("nff") => Format::Nff,
            _ => Format::Obj,
        }
    }
}

/// Reads `source` by the format that its content and name say.
pub(super) fn read(
    source: Source,
    wanted: Wanted,
    library: &mut Library,
    reading: &mut Reading,
) -> Result<Model, SceneError> {
    let file = ModelFile { source, object: wanted.object };
    let format = format(source);
    if wanted.node.is_some() && matches!(format, Format::Ply | Format::Stl | Format::Nff) {
        return Err(file.error(
            "`node` picks a part by its name, but PLY, STL and NFF files have no named parts",
            "remove `node`, or take a glTF or OBJ file",
        ));
    }
    match format {
        Format::Gltf => gltf::read(file, wanted, library, reading),
        Format::Ply => ply::read(file, wanted, library, reading),
        Format::Stl => stl::read(file, wanted, library, reading),
        Format::Nff => nff::read(source, wanted, library, reading),
        Format::Obj => obj::read(source, wanted, library, reading),
    }
}

/// What tests of readers share.
#[cfg(test)]
pub(super) mod testing {
    use super::*;
    use crate::scene::Material;
    use crate::scene::notes::Notes;
    use glam::DVec3;
    use std::path::Path;

    /// What one reading gave.
    #[derive(Debug)]
    pub struct Reader {
        pub model: Model,
        pub materials: Vec<Material>,
        pub notes: Vec<String>,
    }

    /// Reads `bytes` as the file `name`.
    pub fn read(name: &str, bytes: &[u8]) -> Result<Reader, SceneError> {
        read_part(name, bytes, None, false)
    }

    /// Reads a part of `bytes`.
    pub fn read_part(
        name: &str,
        bytes: &[u8],
        node: Option<&str>,
        strict: bool,
    ) -> Result<Reader, SceneError> {
        let source = Source { file: Path::new(name), text: bytes };
        let place = Transform::new(1.0, DVec3::ZERO, DVec3::ZERO);
        let wanted = Wanted { object: "mesh `m`", material: None, place, node };
        let mut library = Library::new(Vec::new());
        let mut reading = Reading { strict, notes: Notes::default() };
        let model = super::read(source, wanted, &mut library, &mut reading)?;
        let notes = reading.notes.iter().map(|note| note.message.clone()).collect();
        Ok(Reader { model, materials: library.materials, notes })
    }

    impl Reader {
        /// Corners of all triangles, in order.
        pub fn triangles(&self) -> Vec<[DVec3; 3]> {
            let of = |mesh: &Mesh| {
                let corner = |v: u32| mesh.vertices[v as usize];
                mesh.faces.iter().map(|f| f.vertices.map(corner)).collect::<Vec<_>>()
            };
            self.model.meshes.iter().flat_map(of).collect()
        }

        /// True if some note contains `words`.
        pub fn notes_hold(&self, words: &str) -> bool {
            self.notes.iter().any(|note| note.contains(words))
        }
    }

    /// Reads every beginning of `bytes`, and `bytes` with each byte changed in several ways: a reader may refuse them, but must
    /// neither panic nor give what the rest of the program cannot take.
    pub fn survives_damage(name: &str, bytes: &[u8]) {
        let check = |bytes: &[u8]| {
            let Ok(read) = read(name, bytes) else { return };
            for mesh in &read.model.meshes {
                let (vertices, normals) = (mesh.vertices.len() as u32, mesh.normals.len() as u32);
                assert!(mesh.vertices.iter().all(|v| v.is_finite()));
                assert!(mesh.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-9));
                assert!(mesh.faces.iter().all(|f| f.vertices.iter().all(|v| *v < vertices)));
                assert!(mesh.faces.iter().flat_map(|f| f.normals).flatten().all(|n| n < normals));
                assert!(mesh.faces.iter().all(|f| f.material < read.materials.len()));
            }
            assert!(read.model.lights.iter().all(|l| l.position.is_finite() && l.intensity.is_finite()));
        };
        for length in 0..bytes.len() {
            check(&bytes[..length]);
        }
        let mut changed = bytes.to_vec();
        for at in 0..bytes.len() {
            for value in [!bytes[at], bytes[at] ^ 1, bytes[at].wrapping_add(7), 0xff, 0, b'9', b'-'] {
                changed[at] = value;
                check(&changed);
            }
            changed[at] = bytes[at];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn content_comes_before_the_name() {
        let format = |name: &str, text: &[u8]| format(Source { file: Path::new(name), text });
        assert_eq!(format("a.obj", b"glTF\x02\0\0\0"), Format::Gltf);
        assert_eq!(format("a.obj", b"\xef\xbb\xbf {}"), Format::Gltf);
        assert_eq!(format("a.stl", b"ply\nformat ascii 1.0\n"), Format::Ply);
        assert_eq!(format("a.ply", b"solid x\nfacet normal 0 0 1"), Format::Stl);
        let mut binary = b"solid, in spite of its first word".to_vec();
        binary.resize(84 + 50, 0);
        binary[80] = 1;
        assert_eq!(format("a", &binary), Format::Stl);
        binary.pop();
        assert_eq!(format("a.STL", &binary), Format::Stl);
        assert_eq!(format("a.obj", b"v 0 0 0\n"), Format::Obj);
        assert_eq!(format("a.GLB", b""), Format::Gltf);
        assert_eq!(format("a.txt", b"plywood\n"), Format::Obj);
    }
}

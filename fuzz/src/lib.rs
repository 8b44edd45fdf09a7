//! The readers of this program as functions of bytes. A reader may refuse its input. It must not panic, take memory out of
//! proportion, give what the rest of the program cannot take, or say what would move a terminal's cursor.
//!
//! libFuzzer calls them through `main.rs`; `tests/fuzzed.rs` calls them with the kept corpus.

use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use whitted::accuracy::promise::Bounded;
use whitted::image::read_metadata;
use whitted::lab::calibrate::{Header, Store};
use whitted::lab::sweep::truth::{Identity, Truth};
use whitted::prepare::{bvh, pack};
use whitted::render::{Payload, ResumeState, Sums};
use whitted::report::Report;
use whitted::scene::{ReadOptions, import};
use whitted::settings::{Schedule, Settings};
use whitted::{DVec3, Picture, Scene, SceneError};

/// A reader, by its name on the command line.
pub type Reader = (&'static str, fn(&[u8]));

/// All of them.
pub const READERS: [Reader; 13] = [
    ("scene", scene),
    ("obj", |bytes| model("obj", bytes)),
    ("mtl", mtl),
    ("gltf", |bytes| model("gltf", bytes)),
    ("ply", |bytes| model("ply", bytes)),
    ("stl", |bytes| model("stl", bytes)),
    ("nff", |bytes| model("nff", bytes)),
    ("picture", picture),
    ("state", state),
    ("hierarchy", hierarchy),
    ("truth", truth),
    ("records", records),
    ("report", report),
];

/// Most primitives of a scene that is prepared as well: what fuzzing is after shows in small ones.
const PREPARED: usize = 300;

/// A folder in memory where there is one, of this process alone.
static FOLDER: LazyLock<PathBuf> = LazyLock::new(|| {
    let memory = Path::new("/dev/shm");
    let parent = if memory.is_dir() { memory.to_owned() } else { std::env::temp_dir() };
    let folder = parent.join(format!("whitted-fuzz-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for the inputs");
    folder
});

/// Removes what [`READERS`] leave on the disk.
pub fn clean() {
    drop(std::fs::remove_dir_all(&*FOLDER));
}

/// Writes `bytes` as the file `name`.
fn file(name: &str, bytes: &[u8]) -> PathBuf {
    let path = FOLDER.join(name);
    std::fs::write(&path, bytes).expect("room for the input");
    path
}

/// Demands on a message: a terminal can show it as it is, and it is short.
fn shown(message: &str) {
    let moves = |c: char| c.is_control() && c != '\n';
    assert!(!message.contains(moves), "control characters in {message:?}");
    assert!(message.len() < 10_000, "a message of {} bytes", message.len());
}

/// A strict reading, whose message is looked at, and one that assumes.
fn both(read: impl Fn(&ReadOptions) -> Result<Scene, SceneError>) -> Option<Scene> {
    let strictly = |strict| read(&ReadOptions { strict, ..ReadOptions::default() });
    let [strict, loose] = [true, false].map(strictly);
    for error in [&strict, &loose].into_iter().filter_map(|read| read.as_ref().err()) {
        shown(&error.to_string());
    }
    // A strict reading keeps the file's own lights; otherwise they are exposed to its size, which may be too large for it.
    if let (Ok(strict), Err(loose)) = (&strict, &loose)
        && !loose.message.contains("too large to be lit")
    {
        panic!("read strictly but not otherwise: {:?}, {loose}", strict.file);
    }
    let scene = loose.ok()?;
    scene.notes.lines().iter().for_each(|line| shown(line));
    check(&scene);
    Some(scene)
}

fn is_unit(v: DVec3) -> bool {
    (v.length() - 1.0).abs() < 1e-9
}

/// Demands of the rest of the program on a scene.
fn check(scene: &Scene) {
    let materials = scene.materials.len();
    for mesh in &scene.meshes {
        let (vertices, normals) = (mesh.vertices.len() as u32, mesh.normals.len() as u32);
        assert!(mesh.vertices.iter().all(|v| v.is_finite()));
        let long = mesh.normals.iter().find(|n| !is_unit(**n));
        assert!(long.is_none(), "a normal of {long:?}");
        for face in &mesh.faces {
            assert!(face.vertices.iter().all(|v| *v < vertices) && face.material < materials);
            assert!(face.normals.iter().flatten().all(|n| *n < normals));
        }
    }
    for polygon in &scene.polygons {
        assert!(polygon.vertices.len() >= 3 && polygon.material < materials);
        assert!(polygon.vertices.iter().all(|v| v.is_finite()));
        assert!(polygon.cut.iter().flatten().all(|v| (*v as usize) < polygon.vertices.len()));
        assert!(is_unit(polygon.normal), "a normal of {}", polygon.normal);
    }
    for sphere in &scene.spheres {
        assert!(sphere.center.is_finite() && sphere.radius > 0.0 && sphere.radius.is_finite());
        assert!(sphere.material < materials);
    }
    assert!(scene.lights.iter().all(|l| l.position.is_finite() && l.intensity.is_finite()));
    assert!(scene.camera.axes().iter().all(|axis| axis.is_finite()), "{:?}", scene.camera);
    if scene.triangle_count() + scene.spheres.len() <= PREPARED {
        let settings = Settings { width: 8, height: 6, ..Settings::of(scene) };
        pack(scene, &settings, 0);
    }
}

fn scene(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    both(|options| Scene::parse_with(text, FOLDER.join("scene.toml"), options));
}

/// A model drawn by itself, and the scene that `whitted import` writes for it.
fn model(extension: &str, bytes: &[u8]) {
    let name = format!("model.{extension}");
    let path = file(&name, bytes);
    let Some(drawn) = both(|options| Scene::load_with(&path, options)) else { return };
    let text = import(&drawn, &name);
    let again = Scene::parse(&text, FOLDER.join("imported.toml"))
        .unwrap_or_else(|error| panic!("the imported scene cannot be read: {error}\n{text}"));
    assert_eq!((drawn.camera, &drawn.lights), (again.camera, &again.lights), "{text}");
    assert_eq!((&drawn.meshes, &drawn.spheres), (&again.meshes, &again.spheres), "{text}");
}

/// Materials of a mesh that uses some names.
fn mtl(bytes: &[u8]) {
    file("model.mtl", bytes);
    let mut mesh = String::from("mtllib model.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n");
    for name in ["a", "b", "Material", "none", ""] {
        mesh += &format!("usemtl {name}\nf 1 2 3\n");
    }
    let path = file("painted.obj", mesh.as_bytes());
    both(|options| Scene::load_with(&path, options));
}

fn picture(bytes: &[u8]) {
    let path = file("picture", bytes);
    match Picture::read(&path) {
        Ok(picture) => {
            assert_eq!(picture.linear.len(), picture.width as usize * picture.height as usize);
            assert!(picture.width > 0 && picture.height > 0);
        }
        Err(error) => shown(&error.to_string()),
    }
    read_metadata(&path);
}

/// A state with the checksum made right.
fn state(bytes: &[u8]) {
    fn read<P: Payload>(bytes: &[u8]) -> Option<ResumeState<P>> {
        ResumeState::read(&mut &bytes[..]).ok()
    }
    let content = [b"whitted resume state 2\n", bytes].concat();
    let sealed = [&content[..], &Sha256::digest(&content)[..]].concat();
    if let Some(state) = read::<Sums>(&sealed) {
        state.is_finished();
    }
    read::<Bounded>(&sealed);
    assert!(read::<Sums>(&content).is_none(), "read without its checksum");
}

/// A hierarchy of ten primitives with the checksum made right.
fn hierarchy(bytes: &[u8]) {
    let key = [7; 32];
    let content = [b"whitted bvh\n", &key[..], bytes].concat();
    let whole = Sha256::digest(&content);
    let sum = Sha256::new().chain_update((content.len() as u64).to_le_bytes()).chain_update(whole).finalize();
    bvh::decode(&[&content[..], &sum[..]].concat(), &key, 10);
    assert!(bvh::decode(&content, &key, 10).is_none(), "read without its checksum");
}

/// The truth of a sweep of four pixels, or whatever its own first line says.
fn truth(bytes: &[u8]) {
    #[derive(serde::Deserialize)]
    struct Line {
        truth: Identity,
    }
    let line = bytes.split(|b| *b == b'\n').next().unwrap_or_default();
    let Ok(Line { truth }) = serde_json::from_slice(line) else { return };
    drop(Truth::load(&mut &bytes[..], &truth));
}

/// The records of a calibration with the trials that its own first line names.
fn records(bytes: &[u8]) {
    let line = bytes.split(|b| *b == b'\n').next().unwrap_or_default();
    let Ok(header) = serde_json::from_slice::<Header>(line) else { return };
    if let Err(error) = Store::open(&file("records.jsonl", bytes), &header) {
        shown(&error.to_string());
    }
}

fn report(bytes: &[u8]) {
    let Ok(report) = serde_json::from_slice::<Report>(bytes) else { return };
    whitted::report::text::report(&report);
    if let Err(why) = report.settings.to_settings(Schedule::default()) {
        shown(&why);
    }
}

//! Loads the model files that `tests/corpus/corpus.py` lists and says what is in each, one JSON object a line.
// Helpers of tests are not seen as tests: a panic is the failure report there too.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use serde_json::json;
use std::path::Path;
use whitted::scene::Scene;
use whitted::scene::bounds::Bounds;

/// The environment variable with the path of a list of files, one a line.
const LIST: &str = "WHITTED_CORPUS";

const CAMERA: &str = "[camera]\nlook_from = [0, 0, 1]\nlook_at = [0, 0, 0]\n";

#[test]
#[ignore = "tests/corpus/corpus.py runs it"]
fn load_what_is_listed() {
    let list = std::env::var(LIST).expect("corpus.py sets it");
    for file in std::fs::read_to_string(list).unwrap().lines() {
        let name = toml_string(file);
        let text = format!("{CAMERA}[[mesh]]\nfile = {name}\n");
        // The place of the scene does not matter: the file's path is absolute.
        let result = match Scene::parse(&text, Path::new("corpus.toml")) {
            Err(error) => json!({ "file": file, "error": error.message, "remedy": error.remedy }),
            Ok(scene) => {
                let bounds = scene.meshes.iter().fold(Bounds::EMPTY, |b, mesh| b.union(mesh.bounds()));
                let notes: Vec<String> = scene.notes.iter().map(|note| note.message.clone()).collect();
                json!({
                    "file": file,
                    "triangles": scene.triangle_count(),
                    "lo": bounds.lo.to_array(),
                    "hi": bounds.hi.to_array(),
                    "notes": notes,
                })
            }
        };
        println!("{result}");
    }
}

/// A path as a TOML string.
fn toml_string(text: &str) -> String {
    serde_json::to_string(text).unwrap()
}

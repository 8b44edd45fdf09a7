//! OBJ and MTL files as exporters write them render, and one line each says what was assumed.

// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

use assert_cmd::Command;
use serde_json::Value;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

const SCENE: &str = "[camera]\nlook_from = [0.5, 0.5, 4]\nlook_at = [0.5, 0.5, 0]\nwidth = 24\nheight = 20\n\
    [[light]]\nposition = [0, 0, 5]\nintensity = 20\n[[mesh]]\nfile = \"m.obj\"\n";

/// A face without a material, one with an unknown one, one with a normal that is none, and a file that is missing.
const MODEL: &str = "mtllib .\\none.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 0\nf 1 2 3\nusemtl \u{1b}[31mred\nf 1//1 3//1 4//1\n";

fn folder(model: &[u8]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("s.toml"), SCENE).unwrap();
    fs::write(folder.path().join("m.obj"), model).unwrap();
    folder
}

/// Standard error of `whitted render s.toml` with `words`, which ends with `code`.
fn render(folder: &Path, words: &str, code: i32) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_whitted"));
    command.args(["render", "s.toml", "-o", "a.png"]).args(words.split_whitespace());
    let command = command.env("WHITTED_DEVICE", "cpu").current_dir(folder);
    String::from_utf8(command.assert().code(code).get_output().stderr.clone()).unwrap()
}

#[test]
fn notes_are_printed_reported_and_strictly_refused() {
    let folder = folder(MODEL.as_bytes());
    let said = render(folder.path(), "--report r.json", 0);
    let report: Value = serde_json::from_slice(&fs::read(folder.path().join("r.json")).unwrap()).unwrap();
    let notes = report["scene"]["notes"].as_array().unwrap();
    for (line, part) in [
        (1, "`mtllib` names a file that is missing"),
        (7, "without a material get the default"),
        (8, "names a material that no MTL file has"),
        (9, "normal of length 0"),
    ] {
        let is_it = |text: &str| text.contains(&format!("m.obj:{line}: ")) && text.contains(part);
        assert!(said.lines().any(is_it), "{part}: {said}");
        assert_eq!(notes.iter().filter(|n| is_it(n.as_str().unwrap())).count(), 1, "{part}: {notes:?}");
    }
    assert_eq!(notes.len(), 4, "{notes:?}");
    assert_eq!(render(folder.path(), "-q", 0), "");
    let refused = render(folder.path(), "--strict", 3);
    assert!(refused.contains("m.obj:1:8: ") && refused.contains("there is no file"), "{refused}");
}

#[test]
fn messages_hold_no_escape_sequences_and_stay_short() {
    let long = [b"v 0 0 0\nf 1 1 \x1b]0;gone\x07".to_vec(), vec![b'9'; 1 << 22]].concat();
    let said = render(folder(&long).path(), "", 3);
    assert!(said.contains("m.obj:2:7: ") && said.contains("`\\u{1b}]0;gone\\u{7}999"), "{said}");
    assert!(said.len() < 2000 && said.chars().all(|c| c == '\n' || !c.is_control()));
}

/// The dent of a concave face shows what is behind it: the picture is that of the two triangles it is.
#[test]
fn a_dent_is_seen_through() {
    let vertices = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv .6 .3 0\n";
    let hash = |faces: &str| {
        let folder = folder(format!("{vertices}{faces}").as_bytes());
        render(folder.path(), "--samples 4 --report r.json", 0);
        let report: Value = serde_json::from_slice(&fs::read(folder.path().join("r.json")).unwrap()).unwrap();
        report["image"]["linear_sha256"].as_str().unwrap().to_owned()
    };
    let whole = hash("f 1 2 3 4\n");
    assert_eq!(whole, hash("f 4 1 2\nf 4 2 3\n"));
    assert_ne!(whole, hash("f 1 2 3\nf 1 3 4\n"));
}

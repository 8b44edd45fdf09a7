//! One solid written in every format is the same scene: OBJ, whose reader has tests of its own, is the oracle.
// Helpers of tests are not seen as tests: a panic is the failure report there too.
#![allow(clippy::unwrap_used)]

use glam::DVec3;
use std::fmt::Write;
use std::path::Path;
use whitted::scene::Scene;

/// A tetrahedron with corners that single precision holds, its faces counter-clockwise from outside.
const CORNERS: [[f32; 3]; 4] = [[0.25, 0.0, -1.0], [1.0, 0.5, 0.0], [0.0, 2.0, 0.125], [-0.5, 0.75, 3.5]];
const FACES: [[u16; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

fn obj() -> String {
    let mut text = String::from("mtllib m.mtl\nusemtl m\n");
    for [x, y, z] in CORNERS {
        writeln!(text, "v {x} {y} {z}").unwrap();
    }
    for face in FACES {
        let [a, b, c] = face.map(|i| i + 1);
        writeln!(text, "f {a} {b} {c}").unwrap();
    }
    text
}

fn ply() -> String {
    let mut text = String::from(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
        element face 4\nproperty list uchar ushort vertex_index\nend_header\n",
    );
    for [x, y, z] in CORNERS {
        writeln!(text, "{x} {y} {z}").unwrap();
    }
    for [a, b, c] in FACES {
        writeln!(text, "3 {a} {b} {c}").unwrap();
    }
    text
}

fn stl() -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend(4u32.to_le_bytes());
    for face in FACES {
        let corners = face.iter().flat_map(|i| CORNERS[usize::from(*i)]);
        bytes.extend([0.0; 3].into_iter().chain(corners).flat_map(f32::to_le_bytes));
        bytes.extend([0, 0]);
    }
    bytes
}

/// The document and its buffer.
fn gltf() -> (String, Vec<u8>) {
    let mut bin: Vec<u8> = CORNERS.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    bin.extend(FACES.iter().flatten().flat_map(|i| i.to_le_bytes()));
    let json = serde_json::json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0, 1] }],
        "nodes": [{ "name": "solid", "mesh": 0 }, { "name": "again", "mesh": 0, "scale": [-2, 1, 1] }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": 48 },
            { "buffer": 0, "byteOffset": 48, "byteLength": 24 },
        ],
        "buffers": [{ "uri": "my%20model.bin", "byteLength": 72 }],
    });
    (json.to_string(), bin)
}

/// A scene with one mesh, `lines` of its table.
fn scene(folder: &Path, lines: &str) -> Scene {
    let text = format!(
        "[camera]\nlook_from = [0, 0, 9]\nlook_at = [0, 0, 0]\n[material.glass]\ndiffuse = [0, 0, 0]\n\
        secondary = 1\nfresnel = \"exact\"\n[[mesh]]\n{lines}\n"
    );
    Scene::parse(&text, folder.join("scene.toml")).unwrap_or_else(|e| panic!("{e}"))
}

/// Corners of all triangles, in order.
fn triangles(scene: &Scene) -> Vec<[DVec3; 3]> {
    let mesh = |mesh: &whitted::scene::Mesh| {
        mesh.faces.iter().map(|f| f.vertices.map(|v| mesh.vertices[v as usize])).collect::<Vec<_>>()
    };
    scene.meshes.iter().flat_map(mesh).collect()
}

#[test]
fn one_solid_in_every_format_is_one_scene() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let (json, bin) = gltf();
    std::fs::write(folder.join("m.obj"), obj()).unwrap();
    std::fs::write(folder.join("m.mtl"), "newmtl m\nKd 0.8 0.8 0.8\n").unwrap();
    std::fs::write(folder.join("m.ply"), ply()).unwrap();
    std::fs::write(folder.join("m.stl"), stl()).unwrap();
    std::fs::write(folder.join("m.gltf"), json).unwrap();
    std::fs::write(folder.join("my model.bin"), bin).unwrap();

    for place in ["", "scale = 2\nrotate = [30, 40, 50]\ntranslate = [1, 2, 3]", "material = \"glass\""] {
        let expected = scene(folder, &format!("file = \"m.obj\"\n{place}"));
        assert!(expected.notes.is_empty());
        for file in ["file = \"m.ply\"", "file = \"m.stl\"", "file = \"m.gltf\"\nnode = \"solid\""] {
            let read = scene(folder, &format!("{file}\n{place}"));
            assert_eq!(triangles(&read), triangles(&expected), "{file} {place}");
            let of = |scene: &Scene| scene.materials[scene.meshes[0].faces[0].material].diffuse;
            assert_eq!(of(&read), of(&expected), "{file} {place}");
            // With the scene's own material nothing is assumed.
            assert_eq!(read.notes.is_empty(), place.starts_with("material"), "{file} {place}");
        }
    }
    // The mirrored copy: its faces are turned round as well, so that the outside stays outside.
    let both = triangles(&scene(folder, "file = \"m.gltf\""));
    let volume = |faces: &[[DVec3; 3]]| faces.iter().map(|[a, b, c]| a.dot(b.cross(*c)) / 6.0).sum::<f64>();
    let (one, mirrored) = both.split_at(4);
    assert!(volume(one) > 0.0 && (volume(mirrored) / volume(one) - 2.0).abs() < 1e-12);
}

#[test]
fn parts_without_names_and_missing_parts_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.stl"), stl()).unwrap();
    let text =
        "[camera]\nlook_from = [0, 0, 9]\nlook_at = [0, 0, 0]\n[[mesh]]\nfile = \"m.stl\"\nnode = \"x\"\n";
    let error = Scene::parse(text, folder.path().join("scene.toml")).unwrap_err();
    assert!(error.message.contains("no named parts"), "{error}");
    assert_eq!(error.object, "mesh `m.stl`");
}

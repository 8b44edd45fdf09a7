use super::*;
use crate::scene::model::testing::{read, read_part, survives_damage};

/// A tetrahedron: corners, and its faces with the outside to the right hand's thumb.
const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, -0.0, 3.5]];
const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

fn ascii() -> String {
    let mut text = String::from("solid a facet of no name\n");
    for face in FACES {
        text += "  facet normal nan -nan(ind) 0\n    outer loop\n";
        for corner in face {
            let [x, y, z] = CORNERS[corner];
            text += &format!("      vertex {x:e} {y} {z}\r\n");
        }
        text += "    endloop\n  endfacet\n";
    }
    text + "endsolid a facet of no name\n"
}

fn binary(header: &[u8], stated: u32, attributes: u16) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, b' ');
    bytes.extend(stated.to_le_bytes());
    for face in FACES {
        let corners = face.iter().flat_map(|c| CORNERS[*c]);
        bytes.extend([f32::NAN; 3].into_iter().chain(corners).flat_map(f32::to_le_bytes));
        bytes.extend(attributes.to_le_bytes());
    }
    bytes
}

#[test]
fn both_kinds_are_the_same_closed_mesh() {
    let expected = FACES.map(|face| face.map(|c| DVec3::from_array(CORNERS[c].map(f64::from))));
    let texts = [ascii(), ascii().to_uppercase(), ascii().replace('\n', "\r")];
    let binaries = [binary(b"", 4, 0), binary(b"solid facet", 4, 0)];
    for bytes in texts.iter().map(String::as_bytes).chain(binaries.iter().map(Vec::as_slice)) {
        let read = read("m.stl", bytes).unwrap();
        assert_eq!(read.triangles(), expected);
        // 0 and -0 are one place: four vertices, each edge once in each direction.
        let mesh = &read.model.meshes[0];
        assert_eq!((mesh.vertices.len(), mesh.normals.len()), (4, 0));
        let mut edges: Vec<_> = mesh
            .faces
            .iter()
            .flat_map(|f| [0, 1, 2].map(|i| (f.vertices[i], f.vertices[(i + 1) % 3])))
            .collect();
        edges.sort_unstable();
        edges.dedup();
        assert_eq!(edges.len(), 12);
        assert!(edges.iter().all(|(a, b)| edges.contains(&(*b, *a))));
        assert_eq!(read.materials.len(), 1);
        assert!(read.notes_hold("no materials"));
    }
}

#[test]
fn headers_that_lie() {
    let count = |bytes: &[u8]| read("m.stl", bytes).map(|read| (read.triangles().len(), read.notes.len()));
    // One note says that there is no material.
    assert_eq!(count(&binary(b"", 0, 0)).unwrap(), (4, 2));
    assert_eq!(count(&binary(b"solid", u32::MAX, 0)).unwrap(), (4, 2));
    assert_eq!(count(&binary(b"", 3, 0)).unwrap(), (3, 2));
    assert_eq!(count(&binary(b"", 4, 7)).unwrap(), (4, 2));
    let error = count(&binary(b"", 5, 0)).unwrap_err();
    assert!(error.message.contains("announces 5 facets, but the file ends after 4"), "{error}");
    assert!(count(b"solid x\nendsolid\n").unwrap_err().message.contains("no facets"));
    assert!(count(b"").unwrap_err().message.contains("0 bytes are no STL file"));
    assert!(read_part("m.stl", &binary(b"", 4, 0), None, true).unwrap_err().message.contains("no materials"));
    assert!(read_part("m.stl", &binary(b"", 4, 0), Some("x"), false).is_err());
}

#[test]
fn mistakes_have_a_line() {
    let wrong = |from: &str, to: &str| {
        let error = read("m.stl", ascii().replacen(from, to, 1).as_bytes()).unwrap_err();
        (error.line, error.message)
    };
    assert_eq!(wrong("vertex 0e0", "vertex z"), (4, "`z` is no number".to_owned()));
    assert_eq!(wrong("vertex", "vertx"), (4, "unknown word `vertx`".to_owned()));
    assert_eq!(
        wrong("    outer loop\n      vertex 0e0 0 0\r\n", ""),
        (2, "a facet with 2 vertices".to_owned())
    );
    assert_eq!(
        wrong("endloop\n  endfacet\nendsolid a facet of no name\n", ""),
        (28, "the file ends inside a facet".to_owned())
    );
    let lost = read("m.stl", ascii().replacen("vertex 1e0", "vertex inf", 1).as_bytes()).unwrap();
    assert_eq!(lost.triangles().len(), 3);
    assert!(lost.notes_hold("not finite"));
}

#[test]
fn damage_is_survived() {
    survives_damage("m.stl", ascii().as_bytes());
    survives_damage("m.stl", &binary(b"", 4, 0));
}

use super::*;
use crate::scene::model::testing::{read, read_part, survives_damage};

/// A square roof over a square: five corners, four triangles and a face of four corners.
const HEADER: &str = "element vertex 5\nproperty float x\nproperty double y\nproperty int z\n\
    property float nx\nproperty float ny\nproperty float nz\n\
    property uchar red\nproperty uchar green\nproperty uchar blue\n\
    element extra 1\nproperty list char short what\n\
    element face 5\nproperty uchar flags\nproperty list uchar uint vertex_indices\nend_header\n";

const CORNERS: [[f64; 3]; 5] =
    [[0.5, 0.25, 0.0], [2.0, 0.25, 0.0], [2.0, 2.0, 0.0], [0.5, 2.0, 0.0], [1.0, 1.0, -3.0]];
const FACES: [&[u32]; 5] = [&[0, 1, 2, 3], &[0, 4, 1], &[1, 4, 2], &[2, 4, 3], &[3, 4, 0]];

fn ascii(end: &str) -> String {
    let mut text = format!("ply\nformat ascii 1.0\ncomment TextureFile a.png\n{HEADER}");
    for [x, y, z] in CORNERS {
        text += &format!("{x} {y} {z} 0 1 1 255 0 188\n");
    }
    text += "2 -7 9\n";
    for face in FACES {
        let corners: Vec<_> = face.iter().map(u32::to_string).collect();
        text += &format!("1 {} {}\n", face.len(), corners.join(" "));
    }
    text.replace('\n', end)
}

fn binary(big: bool) -> Vec<u8> {
    let name = if big { "big" } else { "little" };
    let mut bytes = format!("ply\nformat binary_{name}_endian 1.0\n{HEADER}").into_bytes();
    let mut put = |mut number: Vec<u8>| {
        if !big {
            number.reverse();
        }
        bytes.extend(number);
    };
    for [x, y, z] in CORNERS {
        put((x as f32).to_be_bytes().to_vec());
        put(y.to_be_bytes().to_vec());
        put((z as i32).to_be_bytes().to_vec());
        for n in [0.0f32, 1.0, 1.0] {
            put(n.to_be_bytes().to_vec());
        }
        for c in [255, 0, 188] {
            put(vec![c]);
        }
    }
    put(vec![2]);
    put((-7i16).to_be_bytes().to_vec());
    put(9i16.to_be_bytes().to_vec());
    for face in FACES {
        put(vec![1]);
        put(vec![face.len() as u8]);
        for corner in face {
            put(corner.to_be_bytes().to_vec());
        }
    }
    bytes
}

#[test]
fn all_encodings_are_the_same_mesh() {
    let point = |i: u32| DVec3::from_array(CORNERS[i as usize]);
    let mut expected = vec![[0, 1, 2], [0, 2, 3]];
    expected.extend(FACES[1..].iter().map(|f| [f[0], f[1], f[2]]));
    let expected: Vec<_> = expected.into_iter().map(|face| face.map(point)).collect();
    for bytes in [
        ascii("\n").into_bytes(),
        ascii("\r\n").into_bytes(),
        ascii("\r").into_bytes(),
        binary(false),
        binary(true),
    ] {
        let read = read("m.ply", &bytes).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(read.triangles(), expected);
        let mesh = &read.model.meshes[0];
        assert!(mesh.faces.iter().all(|f| f.normals == Some(f.vertices)));
        assert!(
            mesh.normals.iter().all(|n| n.distance(DVec3::new(0.0, 0.5f64.sqrt(), 0.5f64.sqrt())) < 1e-15)
        );
        // sRGB 188 is 0.5029 (IEC 61966-2-1).
        assert!(read.materials[0].diffuse.distance(DVec3::new(1.0, 0.0, 0.5029)) < 1e-4);
        assert!(read.notes_hold("mean, diffuse [1.000, 0.000, 0.503]"));
    }
    assert!(read("m.ply", ascii("\n").as_bytes()).unwrap().notes_hold("texture"));
    assert!(read_part("m.ply", ascii("\n").as_bytes(), None, true).is_err());
}

#[test]
fn strips_turn_every_second_triangle() {
    let text = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n\
        element tristrips 1\nproperty list int int vertex_indices\nend_header\n\
        0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n9 0 1 2 3 -1 2 3 4 4\n";
    let read = read("m.ply", text.as_bytes()).unwrap();
    assert_eq!(read.triangles().len(), 3);
    assert!(read.triangles().iter().all(|[a, b, c]| (b - a).cross(c - a).z > 0.0));
    assert!(read.notes_hold("default material"));
}

#[test]
fn mistakes_are_told_and_cost_no_memory() {
    let wrong = |from: &str, to: &str| {
        let error = read("m.ply", ascii("\n").replacen(from, to, 1).as_bytes()).unwrap_err();
        (error.line, error.message)
    };
    for (from, to, line, message) in [
        ("vertex 5", "vertex 99999999999", 4, "more than the file can hold"),
        ("face 5", "face 9999", 16, "more than the file can hold"),
        ("face 5", "face 0", 0, "5 points without faces"),
        ("element vertex 5", "element vertex many", 4, "cannot be read in the header"),
        ("property float x", "property real x", 5, "cannot be read in the header"),
        ("property list uchar uint", "property list float uint", 18, "cannot be read in the header"),
        ("property float x", "property float u", 4, "no `x`, `y` and `z`"),
        ("ascii", "morse", 2, "cannot be read in the header"),
        ("format ascii 1.0\n", "", 0, "does not state the format"),
        ("end_header", "and so on", 0, "the header has no end"),
        ("1 3 3 4 0", "1 3 3 5 0", 0, "face 5 names vertex 5, but there are 5"),
        ("1 3 3 4 0", "1 3 3 -4 0", 30, "face 5 has the corner -4"),
        ("1 3 3 4 0", "1 3 3 4.5 0", 30, "face 5 has the corner 4.5"),
        ("1 3 3 4 0", "1 1e9 3 4 0", 30, "a list of 1000000000 items"),
        ("1 3 3 4 0", "1 3 3 4", 0, "ends before"),
        ("1 3 3 4 0", "1 3 3 \u{1b} 0", 30, "`\\u{1b}` is no number"),
    ] {
        let (at, told) = wrong(from, to);
        assert!(told.contains(message), "{from} -> {to}: {told}");
        assert!(line == 0 || line == at, "{from} -> {to}: line {at}");
    }
    let thin = read("m.ply", ascii("\n").replacen("1 3 3 4 0", "1 2 3 4", 1).as_bytes()).unwrap();
    assert_eq!(thin.triangles().len(), 5);
    assert!(thin.notes_hold("fewer than three corners"));
    let unknown = read("m.ply", ascii("\n").replacen("comment", "Created by", 1).as_bytes()).unwrap();
    assert!(unknown.notes_hold("unknown lines"));
}

#[test]
fn damage_is_survived() {
    survives_damage("m.ply", ascii("\n").as_bytes());
    survives_damage("m.ply", &binary(false));
    survives_damage("m.ply", &binary(true));
}

use super::*;
use crate::scene::notes::Notes;
use crate::scene::{Transform, rotation};
use glam::{DAffine3, DVec3};
use std::path::Path;

/// No change of place.
fn here() -> Transform {
    Transform::new(1.0, DVec3::ZERO, DVec3::ZERO)
}

fn wanted(material: Option<usize>, place: Transform) -> Wanted<'static> {
    Wanted { object: "mesh `m.obj`", material, place, node: None }
}

fn reading(strict: bool) -> Reading {
    Reading { strict, notes: Notes::default() }
}

fn source(text: &str) -> Source<'_> {
    Source { file: Path::new("m.obj"), text: text.as_bytes() }
}

fn read_with(
    text: &[u8],
    wanted: Wanted,
    strict: bool,
) -> Result<(Option<Mesh>, Vec<String>, Library), SceneError> {
    let (mut library, mut reading) = (Library::new(Vec::new()), reading(strict));
    let source = Source { file: Path::new("m.obj"), text };
    let model = read(source, wanted, &mut library, &mut reading)?;
    let notes = reading.notes.iter().map(|n| format!("{}: {} x{}", n.line, n.message, n.count)).collect();
    Ok((model.meshes.into_iter().next(), notes, library))
}

/// Strictly, with the scene's material 0.
fn read_plain(text: &str) -> Result<Mesh, SceneError> {
    read_with(text.as_bytes(), wanted(Some(0), here()), true).map(|(mesh, ..)| mesh.unwrap())
}

/// Not strictly: corners and corner normals of each triangle, and the notes.
type Triangles = Vec<([u32; 3], Option<[u32; 3]>)>;

fn lenient(text: &[u8]) -> Result<(Triangles, Vec<String>), SceneError> {
    let (mesh, notes, _) = read_with(text, wanted(Some(0), here()), false)?;
    let faces = mesh.map(|m| m.faces.iter().map(|f| (f.vertices, f.normals)).collect());
    Ok((faces.unwrap_or_default(), notes))
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nvn 0 0.6 0.8\n";

fn faces(line: &str) -> Vec<([u32; 3], Option<[u32; 3]>)> {
    let mesh = read_plain(&format!("{SQUARE}{line}\n")).unwrap();
    mesh.faces.iter().map(|f| (f.vertices, f.normals)).collect()
}

#[test]
fn corners_in_every_form() {
    for line in ["f 1 2 3", "f 1/1 2/2 3/3", "f -4 -3 -2", "f 1 2 \\\n 3", "f 1 2 3 # c", "f +1 2 3\r"] {
        assert_eq!(faces(line), [([0, 1, 2], None)], "{line}");
    }
    assert_eq!(faces("f 1//1 2//2 3//1"), [([0, 1, 2], Some([0, 1, 0]))]);
    assert_eq!(faces("f 1/1/-1 2//2 3/9/1"), [([0, 1, 2], Some([1, 1, 0]))]);
    assert_eq!(faces("f 1 2 3 4"), [([0, 1, 2], None), ([0, 2, 3], None)]);
}

#[test]
fn redundant_normals_are_dropped_and_bent_ones_kept() {
    assert_eq!(faces("f 1//1 2//1 3//1"), [([0, 1, 2], None)]);
    assert_eq!(faces("f 1//2 2//2 3//2"), [([0, 1, 2], Some([1, 1, 1]))]);
    assert!(read_plain(&format!("{SQUARE}f 1//1 2//1 3//1")).unwrap().normals.is_empty());
}

#[test]
fn weights_colours_and_groups_are_skipped() {
    let text = "o a\ng b\ns off\nv 0 0 0 1\nv 1 0 0 .5 .5 .5\nv 0 1 0\nvt 0 0\nusemtl x\nf 1 2 3\nl 1 2\n";
    assert_eq!(read_plain(text).unwrap().vertices, [DVec3::ZERO, DVec3::X, DVec3::Y]);
}

#[test]
fn meshes_are_put_in_place() {
    let place = Transform::new(2.0, DVec3::new(90.0, 0.0, 0.0), DVec3::X);
    let text = format!("{SQUARE}f 1//1 2//2 3//1");
    let mesh = read_with(text.as_bytes(), wanted(Some(0), place), true).unwrap().0.unwrap();
    assert_eq!(mesh.vertices[2], DVec3::new(3.0, 0.0, 2.0));
    assert_eq!(mesh.normals[0], DVec3::NEG_Y);
}

#[test]
fn errors_have_places() {
    for (text, line, column, part) in [
        ("", 1, 1, "no faces"),
        ("v 0 0\n", 1, 1, "`v` needs three numbers"),
        ("v 0 x 0\n", 1, 5, "`x` is no finite number"),
        ("v 0 inf 0\n", 1, 5, "`inf` is no finite number"),
        ("v 0 0 1e80\n", 1, 7, "larger than 1e75"),
        ("vn 0 0 0\n", 1, 1, "length 0"),
        ("v 0 0 0\nf 1 1\n", 2, 1, "2 corners"),
        ("v 0 0 0\nf 1 1 2\n", 2, 7, "vertex 2 of 1"),
        ("v 0 0 0\nf 1 0 1\n", 2, 5, "numbers start at 1"),
        ("v 0 0 0\nf 1 1 \\\n -2\n", 3, 2, "vertex -2 of 1"),
        ("v 0 0 0\nf 1//1 1 1\n", 2, 3, "normal 1 of 0"),
        ("v 0 0 0\nvn 0 0 1\nf 1//1 1 1\n", 3, 1, "only some corners"),
        ("v 0 0 0\nf 1/ 1/x 1\n", 2, 6, "`1/x` is no corner"),
        ("v 0 0 0\nf 1/1/1/1 1 1\n", 2, 3, "is no corner"),
        ("cstype bezier\n", 1, 1, "free-form"),
        ("v 0 0 0\nv 4 4 0\nv 4 0 0\nv 1 3 0\nf 1 2 3 4\n", 5, 1, "crosses itself"),
        ("v 0 0 0\nF 1 1 1\n", 2, 1, "unknown statement `F`; did you mean `f`?"),
    ] {
        let error = read_plain(text).unwrap_err();
        assert_eq!((error.line, error.column), (line, column), "{error}");
        assert!(error.message.contains(part), "{error}");
    }
    let bare = |text: &str| read_with(text.as_bytes(), wanted(None, here()), true).err().unwrap();
    assert!(bare("v 0 0 0\nf 1 1 1").message.contains("without a material"));
    assert_eq!(bare("\nusemtl red").column, 8);
    assert!(bare("mtllib nowhere.mtl").message.contains("there is no file `nowhere.mtl`"));
}

/// Each of these is read, with one note that says what was assumed and where it was first.
#[test]
fn what_exporters_write_is_read() {
    let triangle = vec![([0, 1, 2], None)];
    for (line, faces, note) in [
        // Normals that cannot be used.
        ("vn 0 0 0\nf 1//3 2//3 3//3", triangle.clone(), "8: triangles with a normal of length 0"),
        ("vn nan nan nan\nf 1//1 2//3 3//1", triangle.clone(), "8: triangles with a normal of length 0"),
        ("f 1//2 2//2 3", triangle.clone(), "7: triangles with normals on some corners"),
        ("f 1//2 2//2 3//", triangle.clone(), "7: triangles with normals on some corners"),
        ("f 1/1/0 2/2/2 3/3/2", triangle.clone(), "7: triangles with a normal's number that is 0"),
        ("f 1//9 2//2 3//2", triangle.clone(), "7: triangles with a normal's number that is 0"),
        ("f 1//-9 2//2 3//2", triangle.clone(), "7: triangles with a normal's number that is 0"),
        // Faces and statements that are skipped.
        ("f 1 2\nf 1 2 3\nf 2", triangle.clone(), "7: faces of less than three corners are skipped x2"),
        ("call other.obj\nF 1 2 3\nf 1 2 3", triangle.clone(), "7: unknown statements are skipped x2"),
        ("cstype bezier\ncurv 0 1 1 2\nf 1 2 3", triangle.clone(), "7: statements of free-form"),
        // A face that crosses itself.
        (
            "v .2 .9 0\nf 1 3 2 5",
            vec![([0, 2, 1], None), ([0, 1, 4], None)],
            "8: faces whose border crosses itself",
        ),
    ] {
        let text = format!("{SQUARE}{line}\n");
        let (found, notes) = lenient(text.as_bytes()).unwrap_or_else(|e| panic!("{line}: {e}"));
        assert_eq!(found, faces, "{line}");
        let [only] = &notes[..] else { panic!("{line}: {notes:?}") };
        assert!(only.starts_with(note), "{line}: {only}");
        assert!(read_plain(&text).is_err(), "{line}");
    }
    // Nothing is assumed here.
    for line in [
        "vn 0 0 0\nf 1 2 3",
        "vn nan nan nan\nf 1 2 3",
        "f 1// 2// 3//",
        "f 1/1/ 2/2/ 3/3/",
        "f 1/99 2/99 3/99",
        "f 1 2 3\nl 1 2\np 1",
        "f 1 2 3\n\0\0",
    ] {
        let (found, notes) = lenient(format!("{SQUARE}{line}").as_bytes()).unwrap();
        assert_eq!((found, notes), (triangle.clone(), vec![]), "{line}");
    }
    let early = "f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n";
    assert_eq!(lenient(early.as_bytes()).unwrap(), (triangle.clone(), vec![]));
    assert!(read_plain(early).is_err());
    assert_eq!(lenient(early.replace('\n', "\r").as_bytes()).unwrap(), (triangle, vec![]));
}

#[test]
fn what_has_no_meaning_is_an_error_all_the_same() {
    for (text, line, column, part) in [
        ("", 1, 1, "no faces"),
        ("v 0 0 0\nv 1 0 0\n", 1, 1, "no faces"),
        ("v 0 x 0\n", 1, 5, "`x` is no finite number"),
        ("v 0 0 0\nf 1 1 2\n", 2, 7, "vertex 2 of 1: the file has no more"),
        ("v 0 0 0\nf 1 1 -2\n", 2, 7, "vertex -2 of 1"),
        ("v 0 0 0\nf 1 0 1\n", 2, 5, "numbers start at 1"),
        ("v 0 0 0\nf 1 1 a/1\n", 2, 7, "`a/1` is no corner"),
    ] {
        let error = lenient(text.as_bytes()).unwrap_err();
        assert_eq!((error.line, error.column), (line, column), "{error}");
        assert!(error.message.contains(part), "{error}");
    }
    let utf16: Vec<u8> = "\u{feff}v 0 0 0\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
    assert!(lenient(&utf16).unwrap_err().message.contains("UTF-16 (little-endian)"));
    // Control characters are named, and long words cut.
    let error = lenient(b"v \x1b[2J 0 0\n").unwrap_err().to_string();
    assert!(error.contains("`\\u{1b}[2J`") && !error.contains('\u{1b}'), "{error}");
    let long = format!("v {}\n", "9x".repeat(1 << 20));
    assert!(lenient(long.as_bytes()).unwrap_err().to_string().len() < 1000);
}

#[test]
fn lines_points_and_curves_alone_are_nothing() {
    for text in ["v 0 0 0\nv 1 0 0\nl 1 2\n", "v 0 0 0\np 1\n"] {
        let (faces, notes) = lenient(text.as_bytes()).unwrap();
        assert!(faces.is_empty() && notes[0].contains("has no faces, only lines"), "{notes:?}");
    }
}

/// Concave faces with corners in straight sides, of a closed mesh: every side is shared by two triangles, in opposite senses.
#[test]
fn closed_meshes_stay_closed() {
    // An L-shaped block: two faces of seven corners (one in a straight side) and seven of four.
    let outline = [[0.0, 0.0], [1.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
    let n = outline.len();
    for turn in 0..n {
        let mut text = String::new();
        for z in [0, 1] {
            outline.iter().for_each(|[x, y]| text += &format!("v {x} {y} {z}\n"));
        }
        let corner = |i: usize, top: bool| (i + turn) % n + 1 + if top { n } else { 0 };
        let list = |corners: Vec<usize>| {
            let words: Vec<String> = corners.iter().map(ToString::to_string).collect();
            format!("f {}\n", words.join(" "))
        };
        text += &list((0..n).rev().map(|i| corner(i, false)).collect());
        text += &list((0..n).map(|i| corner(i, true)).collect());
        for i in 0..n {
            text += &list(vec![corner(i, false), corner(i + 1, false), corner(i + 1, true), corner(i, true)]);
        }
        let place = Transform::new(2.0, DVec3::new(11.0, 23.0, 47.0), DVec3::splat(0.3));
        let (mesh, notes, _) = read_with(text.as_bytes(), wanted(Some(0), place), false).unwrap();
        let mesh = mesh.unwrap();
        assert_eq!((mesh.faces.len(), notes.len()), (2 * (n - 2) + 2 * n, 0));
        let mut sides = std::collections::HashMap::new();
        let mut volume = 0.0;
        for face in &mesh.faces {
            let [a, b, c] = face.vertices.map(|v| mesh.vertices[v as usize]);
            assert!((b - a).cross(c - a).length() > 1e-3, "{face:?}");
            volume += a.dot(b.cross(c)) / 6.0;
            for k in 0..3 {
                let (from, to) = (face.vertices[k], face.vertices[(k + 1) % 3]);
                *sides.entry((from.min(to), from.max(to))).or_insert(0) += if from < to { 1 } else { -1 };
            }
        }
        assert!(sides.values().all(|n| *n == 0));
        assert!((volume - 5.0 * 8.0).abs() < 1e-12, "{volume}");
    }
}

#[test]
fn concave_faces_keep_their_corner_normals() {
    // The dent is the fourth corner; each corner has its own normal, of the same number.
    let mut text = String::from("v 0 0 0\nv 2 0 0\nv 2 2 0\nv 1 .5 0\n");
    (0..4).for_each(|i| text += &format!("vn 0.{i} 0 1\n"));
    let (faces, notes) = lenient(format!("{text}f 1//1 2//2 3//3 4//4\n").as_bytes()).unwrap();
    assert!(faces.len() == 2 && notes.is_empty());
    assert!(faces.iter().all(|(vertices, normals)| *normals == Some(*vertices)));
    assert!(faces.iter().all(|(vertices, _)| vertices.contains(&3) && vertices.contains(&1)), "{faces:?}");
}

#[test]
fn a_face_of_two_hundred_thousand_corners() {
    let n = 200_000;
    let mut text = String::new();
    for i in 0..n {
        let angle = 2.0 * std::f64::consts::PI * f64::from(i) / f64::from(n);
        // Every tenth corner is pulled in.
        let radius = if i % 10 == 0 { 0.9 } else { 1.0 };
        text += &format!("v {} {} 0\n", radius * angle.cos(), radius * angle.sin());
    }
    let face: Vec<String> = (1..=n).map(|i| i.to_string()).collect();
    text += &format!("f {}\n", face.join(" "));
    let mesh = read_with(text.as_bytes(), wanted(Some(0), here()), false).unwrap().0.unwrap();
    let area = |f: &crate::scene::Face| {
        let [a, b, c] = f.vertices.map(|v| mesh.vertices[v as usize]);
        (b - a).cross(c - a).z / 2.0
    };
    assert!(mesh.faces.iter().all(|f| area(f) >= 0.0));
    let whole: f64 = mesh.faces.iter().map(area).sum();
    let at = |i: usize| mesh.vertices[i % n as usize];
    let expected: f64 = (0..n as usize).map(|i| at(i).cross(at(i + 1)).z / 2.0).sum();
    assert!((whole - expected).abs() < 1e-9, "{whole} {expected}");
}

#[test]
fn mirrored_meshes_keep_their_outside() {
    let cube = crate::scene::procedural::shapes::cuboid(DVec3::ZERO, DVec3::ONE, 0);
    let mut text = String::new();
    cube.vertices.iter().for_each(|v| text += &format!("v {} {} {}\n", v.x, v.y, v.z));
    text += "vn 0 0 1\n";
    for face in &cube.faces {
        text += &format!("f {} {} {}\n", face.vertices[0] + 1, face.vertices[1] + 1, face.vertices[2] + 1);
    }
    let volume = |place: Transform| {
        let mesh = read_with(text.as_bytes(), wanted(Some(0), place), false).unwrap().0.unwrap();
        let corners = |f: &crate::scene::Face| f.vertices.map(|v| mesh.vertices[v as usize]);
        mesh.faces.iter().map(corners).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum::<f64>()
    };
    let scaled = |x, y, z| here().after(DAffine3::from_scale(DVec3::new(x, y, z))).unwrap();
    let plain = volume(here());
    assert!((plain.abs() - 1.0).abs() < 1e-12);
    for (place, factor) in
        [(scaled(2.0, 1.0, 3.0), 6.0), (scaled(-2.0, 1.0, 3.0), 6.0), (scaled(-1.0, -1.0, -1.0), 1.0)]
    {
        assert!((volume(place) - plain * factor).abs() < 1e-12);
    }
    // A normal of a sheared and mirrored plane stays perpendicular to it.
    let matrix = DAffine3::from_mat3(glam::DMat3::from_cols(
        DVec3::new(-2.0, 0.5, 0.0),
        DVec3::new(0.0, 1.0, 0.25),
        DVec3::new(1.0, 0.0, 3.0),
    ));
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvn 1 0 1\nf 1//1 2//1 3//2\n";
    let mesh = read_with(text.as_bytes(), wanted(Some(0), here().after(matrix).unwrap()), false).unwrap();
    let mesh = mesh.0.unwrap();
    let [a, b, c] = mesh.faces[0].vertices.map(|v| mesh.vertices[v as usize]);
    let plane = (b - a).cross(c - a).normalize();
    assert!(plane.distance(mesh.normals[mesh.faces[0].normals.unwrap()[0] as usize]) < 1e-14);
    assert_eq!(rotation(DVec3::ZERO), glam::DMat3::IDENTITY);
}

#[test]
fn parts_are_found_by_object_and_group() {
    let text =
        "o car\nv 0 0 0\nv 1 0 0\nv 0 1 0\ng body\nf 1 2 3\ng left wheel\nf 2 3 1\no red house\nf 3 1 2\n";
    let part = |name: &'static str| {
        let wanted = Wanted { node: Some(name), ..wanted(Some(0), here()) };
        read_with(text.as_bytes(), wanted, false)
            .map(|(mesh, ..)| mesh.unwrap().faces.iter().map(|f| f.vertices[0]).collect::<Vec<_>>())
    };
    assert_eq!(part("car").unwrap(), [0, 1]);
    assert_eq!(part("body").unwrap(), [0]);
    assert_eq!(part("wheel").unwrap(), [1]);
    assert_eq!(part("left wheel").unwrap(), [1]);
    assert_eq!(part("red house").unwrap(), [2]);
    let error = part("weel").unwrap_err();
    assert!(error.message.contains("no object or group `weel`"), "{error}");
    assert!(error.remedy.contains("`body`") && error.remedy.contains("`red house`"), "{error}");
}

#[test]
fn smoothing_groups_make_normals() {
    // A roof of two sides that meet at 60 degrees along the y axis.
    let roof = "v -1 0 0\nv 0 0 .57735026919\nv 1 0 0\nv -1 1 0\nv 0 1 .57735026919\nv 1 1 0\n";
    let with =
        |lines: &str| read_with(format!("{roof}{lines}").as_bytes(), wanted(Some(0), here()), false).unwrap();
    let (mesh, notes, _) = with("s 1\nf 1 2 5 4\nf 2 3 6 5\n");
    let mesh = mesh.unwrap();
    assert!(notes[0].starts_with("8: triangles of smoothing groups"), "{notes:?}");
    for face in &mesh.faces {
        for (v, n) in face.vertices.iter().zip(face.normals.unwrap()) {
            if [1, 4].contains(v) {
                assert!(mesh.normals[n as usize].distance(DVec3::Z) < 1e-9);
            }
        }
    }
    for lines in
        ["s off\nf 1 2 5 4\nf 2 3 6 5\n", "s 1\nf 1 2 5 4\ns 2\nf 2 3 6 5\n", "f 1 2 5 4\nf 2 3 6 5\n"]
    {
        let (mesh, notes, _) = with(lines);
        assert!(mesh.unwrap().faces.iter().all(|f| f.normals.is_none()) && notes.is_empty(), "{lines}");
    }
}

#[test]
fn faces_without_a_material_get_the_default() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("Sub")).unwrap();
    let paint = b"newmtl Red\nKd 1 0 0\nnewmtl \xba\xec\nKd 0 1 0\nnewmtl Paint #1\nKd 0 0 1\nnewmtl \xc0\xb6 # blue\nKd 0 0 .5\n";
    std::fs::write(folder.path().join("Sub/M.mtl"), paint).unwrap();
    let file = folder.path().join("m.obj");
    let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (text, diffuse, part) in [
        (&b"f 1 2 3\nf 1 2 3 1"[..], [0.8; 3], "without a material get the default one, of diffuse 0.8 x3"),
        (b"usemtl Red\nf 1 2 3", [0.8; 3], "no MTL file has"),
        (b"mtllib none.mtl\nf 1 2 3", [0.8; 3], "`mtllib` names a file that is missing"),
        (b"mtllib Sub/M.mtl\nusemtl (null)\nf 1 2 3", [0.8; 3], "no MTL file has"),
        (b"mtllib Sub/M.mtl\nusemtl\nf 1 2 3", [0.8; 3], "no MTL file has"),
        (b"mtllib Sub/M.mtl\nusemtl rED\nf 1 2 3", [1.0, 0.0, 0.0], "letter case"),
        (b"mtllib .\\sub\\m.mtl\nusemtl Red\nf 1 2 3", [1.0, 0.0, 0.0], "letter case"),
        (b"usemtl Red\nmtllib Sub/M.mtl\nf 1 2 3", [1.0, 0.0, 0.0], ""),
        (b"mtllib Sub/M.mtl\nusemtl Red # really\nf 1 2 3", [1.0, 0.0, 0.0], ""),
        (b"mtllib Sub/M.mtl\nusemtl \xba\xec\nf 1 2 3", [0.0, 1.0, 0.0], ""),
        (b"mtllib Sub/M.mtl\nusemtl \xc0\xb6\nf 1 2 3", [0.0, 0.0, 0.5], ""),
        (b"mtllib Sub/M.mtl\nusemtl Paint #1\nf 1 2 3", [0.0, 0.0, 1.0], ""),
    ] {
        let text = [corners.as_bytes(), text].concat();
        let shown = String::from_utf8_lossy(&text);
        let (mut library, mut reading) = (Library::new(Vec::new()), reading(false));
        let source = Source { file: &file, text: &text };
        let model = read(source, wanted(None, here()), &mut library, &mut reading).unwrap();
        let material = &library.materials[model.meshes[0].faces[0].material];
        assert_eq!(material.diffuse.to_array(), diffuse, "{shown}");
        assert_eq!(material.ambient, 0.1);
        let lines: Vec<String> =
            reading.notes.iter().map(|n| format!("{} x{}", n.message, n.count)).collect();
        assert_eq!(lines.is_empty(), part.is_empty(), "{shown} {lines:?}");
        assert!(lines.iter().any(|l| l.contains(part)) || part.is_empty(), "{shown} {lines:?}");
        // The same in pieces.
        let (mut other, mut again) = (Library::new(Vec::new()), self::reading(false));
        if let Some(mesh) = in_pieces(source, wanted(None, here()), &mut other, &mut again, 8).unwrap() {
            assert_eq!(
                (&mesh, &other.materials, &again.notes),
                (&model.meshes[0], &library.materials, &reading.notes)
            );
        }
    }
}

/// Every way of saying things that pieces read, and whole texts: the same mesh wherever it is cut.
#[test]
fn pieces_make_the_same_mesh() {
    let place = Transform::new(2.5, DVec3::new(10.0, 20.0, 30.0), DVec3::new(1.0, -2.0, 3.0));
    let mut text = String::from("\u{feff}# made for this\r\no thing\n");
    for i in 0..40 {
        let x = f64::from(i) * 0.37 - 3.0;
        text += &format!("v {x} {} {:e}\nv {x:.3} .5 -0.25 1.0\nv 1. {} 7 # note\n", x * x, x / 3.0, -i);
        text += &format!("vn 0 {} 1\nvt 0 0\n\n  s off\n", i % 5);
        text += match i % 6 {
            0 => "f 1 2 3\n",
            1 => "f -1 -2 -3 -4\n",
            2 => "f 1//1 2//2 3//1\r\n",
            3 => "f -1/1/-1 2/1/1 -3/2/-2 # corner by corner\n",
            4 => "f 1/1 2/2 5/1 4/1 3/3\n",
            _ => "\tf\t+1//1 2//1 3//1\n",
        };
    }
    // And what is wrong or missing in places.
    text += "vn 0 0 0\nf 1//-1 2//1 3//1\nf 1//9999 2//1 3//1 4//1\nf 1/1/0 2//1 3//1\nf 1/ 2/ 3/\nf 1// 2// 3//\n";
    // A dent, a bow tie, and smoothing groups.
    text += "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 1 .5 0\nf -4 -3 -2 -1\nv 4 4 0\nv 1 3 0\nf -6 -2 -5 -1\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 .3\ns 1\nf -4 -3 -2\nf -2 -3 -1\ns off\n";
    let source = source(&text);
    let wanted = wanted(Some(3), place);
    let library = || Library::new(Vec::new());
    let mut notes = reading(false);
    let whole = from_start(source, wanted, &mut library(), &mut notes).unwrap().unwrap();
    assert!(whole.faces.len() > 40 && whole.faces.iter().any(|f| f.normals.is_some()));
    assert!(notes.notes.iter().count() >= 4, "{:?}", notes.notes);
    for piece in [1, 7, 50, 333, 2000] {
        let mut again = reading(false);
        let mesh = in_pieces(source, wanted, &mut library(), &mut again, piece).unwrap();
        assert_eq!((mesh.as_ref(), again.notes), (Some(&whole), notes.notes.clone()), "{piece}");
    }
    // What a strict reading refuses, it leaves to the other reader.
    assert_eq!(in_pieces(source, wanted, &mut library(), &mut reading(true), 64).unwrap(), None);
}

#[test]
fn pieces_follow_the_material_in_use() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.mtl"), "newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n").unwrap();
    let text = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl blue\nf 1 2 3\nf 1 2 3\nusemtl red\n\
                f 1 2 3\nf 3 2 1\nusemtl blue\nf 1 2 3\n";
    let file = folder.path().join("m.obj");
    let source = Source { file: &file, text: text.as_bytes() };
    let wanted = wanted(None, here());
    let mut library = Library::new(Vec::new());
    let whole = from_start(source, wanted, &mut library, &mut reading(true)).unwrap().unwrap();
    assert_eq!(whole.faces.iter().map(|f| f.material).collect::<Vec<_>>(), [0, 0, 1, 1, 0]);
    for piece in [1, 20, 100] {
        let mut other = Library::new(Vec::new());
        let mesh = in_pieces(source, wanted, &mut other, &mut reading(true), piece).unwrap();
        assert_eq!(mesh, Some(whole.clone()));
        assert_eq!(other.materials, library.materials);
    }
}

/// Whatever is wrong, or merely unusual, is left to the reader of whole texts.
#[test]
fn pieces_leave_the_rest_alone() {
    for line in [
        "f 1 2",
        "f 1 2 9",
        "f 1 2 -9",
        "f 1 2 0",
        "f 1//1 2 3",
        "f 1//9 2//1 3//1",
        "f 1 2 3#x",
        "f 1/ 2/ 3/",
        "f 1 2 \\",
        "v 1 2",
        "v 1 2 x",
        "v 1 2 inf",
        "v 1 2 1e99",
        "vn 0 0 0",
        "curv 1",
        "what",
        "f 1 2 3 x",
        "f 1/1/1/1 2 3",
        "f 99999999999999999999 2 3",
    ] {
        let text = format!("{SQUARE}f 1 2 3\n{line}\n 3\n");
        let wanted = wanted(Some(0), here());
        let mesh = in_pieces(source(&text), wanted, &mut Library::new(Vec::new()), &mut reading(true), 16);
        assert_eq!(mesh.unwrap(), None, "{line}");
    }
}

/// Four words of no pattern: multiplicative hashing (Knuth, The Art of Computer Programming 3, 6.4).
fn words(i: u32) -> [u32; 4] {
    [1, 2, 3, 4]
        .map(|k: u32| (i * 4 + k).wrapping_mul(2_654_435_769).rotate_left(5 * k).wrapping_mul(2_654_435_769))
}

/// The shortest texts of many numbers, and longer ones.
#[test]
fn numbers_are_read_to_the_last_bit() {
    let mut text = String::new();
    let mut expected = Vec::new();
    for i in 0..3000u32 {
        let h = words(i);
        let x = f64::from(h[0]) / f64::from(1 << (h[1] % 32)) * if h[2] & 1 == 0 { -1.0 } else { 1.0 };
        let digits = (h[3] % 18) as usize;
        let words = [format!("{x}"), format!("{x:.digits$}"), format!("{x:e}")];
        text += &format!("v {}\n", words.join(" "));
        expected.push(DVec3::from_array(words.map(|w| w.parse().unwrap())));
    }
    text += "f 1 2 3\n";
    let wanted = wanted(Some(0), here());
    let mesh = in_pieces(source(&text), wanted, &mut Library::new(Vec::new()), &mut reading(true), 4096);
    let mesh = mesh.unwrap().unwrap();
    assert_eq!(mesh.vertices.len(), expected.len());
    for (a, b) in mesh.vertices.iter().zip(expected.iter().map(|v| here().point(*v))) {
        assert_eq!(a.to_array().map(f64::to_bits), b.to_array().map(f64::to_bits));
    }
}

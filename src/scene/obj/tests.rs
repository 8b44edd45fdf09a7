use super::*;

fn read_with(text: &str, whole: Option<usize>, place: Transform) -> Result<Mesh, SceneError> {
    let source = Source { file: Path::new("m.obj"), text: text.as_bytes() };
    read(source, "mesh `m.obj`", whole, place, &mut Library::new(Vec::new()))
}

fn read_plain(text: &str) -> Result<Mesh, SceneError> {
    read_with(text, Some(0), Transform::new(1.0, DVec3::ZERO, DVec3::ZERO))
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
    let mesh = read_with(&format!("{SQUARE}f 1//1 2//2 3//1"), Some(0), place).unwrap();
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
        ("v 0 0 0\nF 1 1 1\n", 2, 1, "unknown statement `F`; did you mean `f`?"),
    ] {
        let error = read_plain(text).unwrap_err();
        assert_eq!((error.line, error.column), (line, column), "{error}");
        assert!(error.message.contains(part), "{error}");
    }
    let bare = |text| read_with(text, None, Transform::new(1.0, DVec3::ZERO, DVec3::ZERO)).unwrap_err();
    assert!(bare("v 0 0 0\nf 1 1 1").message.contains("without a material"));
    assert_eq!(bare("\nusemtl red").column, 8);
    assert!(bare("mtllib nowhere.mtl").message.contains("there is no file `nowhere.mtl`"));
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
    let source = Source { file: Path::new("m.obj"), text: text.as_bytes() };
    let none = || Library::new(Vec::new());
    let whole = read_whole(source, "m", Some(3), place, &mut none()).unwrap();
    assert!(whole.faces.len() > 40 && whole.faces.iter().any(|f| f.normals.is_some()));
    for piece in [1, 7, 50, 333, 100_000] {
        assert_eq!(chunks::read(source, Some(3), place, &mut none(), piece), Some(whole.clone()), "{piece}");
    }
    // Without a material there is none to be had.
    assert_eq!(chunks::read(source, None, place, &mut none(), 64), None);
}

#[test]
fn pieces_follow_the_material_in_use() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.mtl"), "newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n").unwrap();
    let text = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl blue\nf 1 2 3\nf 1 2 3\nusemtl red\n\
                f 1 2 3\nf 3 2 1\nusemtl blue\nf 1 2 3\n";
    let file = folder.path().join("m.obj");
    let source = Source { file: &file, text: text.as_bytes() };
    let place = Transform::new(1.0, DVec3::ZERO, DVec3::ZERO);
    let mut library = Library::new(Vec::new());
    let whole = read_whole(source, "m", None, place, &mut library).unwrap();
    assert_eq!(whole.faces.iter().map(|f| f.material).collect::<Vec<_>>(), [0, 0, 1, 1, 0]);
    for piece in [1, 20, 1000] {
        let mut other = Library::new(Vec::new());
        assert_eq!(chunks::read(source, None, place, &mut other, piece), Some(whole.clone()));
        assert_eq!(other.materials, library.materials);
    }
}

/// Whatever is wrong, or merely unusual, is left to the reader of whole texts.
#[test]
fn pieces_leave_the_rest_alone() {
    let place = Transform::new(1.0, DVec3::ZERO, DVec3::ZERO);
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
        let source = Source { file: Path::new("m.obj"), text: text.as_bytes() };
        let mesh = chunks::read(source, Some(0), place, &mut Library::new(Vec::new()), 16);
        assert_eq!(mesh, None, "{line}");
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
    let source = Source { file: Path::new("m.obj"), text: text.as_bytes() };
    let place = Transform::new(1.0, DVec3::ZERO, DVec3::ZERO);
    let mesh = chunks::read(source, Some(0), place, &mut Library::new(Vec::new()), 4096).unwrap();
    assert_eq!(mesh.vertices.len(), expected.len());
    for (a, b) in mesh.vertices.iter().zip(expected.iter().map(|v| place.point(*v))) {
        assert_eq!(a.to_array().map(f64::to_bits), b.to_array().map(f64::to_bits));
    }
}

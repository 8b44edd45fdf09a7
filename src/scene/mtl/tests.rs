use super::*;
use crate::scene::notes::Notes;
use crate::scene::{Material, TextureFile};
use std::path::Path;

fn reading(strict: bool) -> Reading {
    Reading { strict, notes: Notes::default() }
}

/// All materials of an MTL text at `path`, and the notes.
fn read_at(path: &Path, text: &[u8], strict: bool) -> Result<(Vec<Material>, Vec<String>), SceneError> {
    let source = Source { file: path, text };
    let mut reading = reading(strict);
    let written = read(source, "material file `m.mtl`", &mut reading)?;
    let mut textures = Textures::default();
    let materials = written.iter().map(|m| m.material(source, &mut textures, &mut reading));
    let materials = materials.collect::<Result<_, _>>()?;
    Ok((materials, reading.notes.iter().map(|n| format!("{}: {}", n.line, n.message)).collect()))
}

fn lenient(text: &str) -> (Vec<Material>, Vec<String>) {
    read_at(Path::new("a/m.mtl"), text.as_bytes(), false).unwrap()
}

fn strict(text: &str) -> Result<Vec<Material>, SceneError> {
    read_at(Path::new("a/m.mtl"), text.as_bytes(), true).map(|(materials, _)| materials)
}

#[test]
fn strictly_the_letter_is_followed() {
    let text = "newmtl plain\nKd .2 .4 .6\nKa .1 .1 .1\nKs 1 1 1\nillum 2\nmap_Kd x.png\n\
        newmtl mirror\nKs 0.5\nillum 3\nnewmtl glass\nTr 0.75\nNi 1.33\nillum 7\n\
        newmtl own\nwhitted_ambient 0\nwhitted_secondary 0.8\nwhitted_fresnel schlick\n\
        newmtl bright\nKd 255 255 255\nd 0.5\nillum 2";
    let m = strict(text).unwrap();
    assert_eq!(m[0].diffuse, DVec3::new(0.2, 0.4, 0.6));
    assert!((m[0].ambient - 0.25).abs() < 1e-15);
    assert_eq!((m[0].secondary, m[0].ior), (0.0, 1.5));
    assert_eq!((m[1].secondary, m[1].fresnel), (0.5, Fresnel::Constant(1.0)));
    assert_eq!((m[2].secondary, m[2].fresnel, m[2].ior), (0.75, Fresnel::Exact, 1.33));
    assert_eq!((m[3].ambient, m[3].secondary, m[3].fresnel), (0.0, 0.8, Fresnel::Schlick));
    assert_eq!((m[4].diffuse, m[4].secondary), (DVec3::splat(255.0), 0.0));
}

#[test]
fn strict_errors_have_places() {
    for (text, line, column, part) in [
        ("Kd 1 1 1", 1, 1, "before the first `newmtl`"),
        ("newmtl", 1, 1, "without a name"),
        ("newmtl a\n\nnewmtl a", 3, 8, "defined twice"),
        ("newmtl a\nKd 1 1", 2, 6, "has 2 numbers"),
        ("newmtl a\nKd 1 -1 1", 2, 6, "`Kd` is -1"),
        ("newmtl a\n  Kd spectral x", 2, 6, "not supported"),
        ("newmtl a\nNi 0", 2, 4, "`Ni` is 0"),
        ("newmtl a\nd 1.5", 2, 3, "`d` is 1.5"),
        ("newmtl a\nillum 11", 2, 7, "`illum` is 11"),
        ("newmtl a\nNi", 2, 1, "without a value"),
        ("newmtl a\nwhitted_fresnel snell", 2, 17, "`snell`"),
        ("newmtl a\nwhitted_secundary 1", 2, 1, "did you mean `whitted_secondary`?"),
        ("newmtl a\nNi x", 2, 4, "`x` is no finite number"),
    ] {
        let error = strict(text).unwrap_err();
        assert_eq!((error.line, error.column), (line, column), "{error}");
        assert!(error.message.contains(part), "{error}");
    }
    // What is ours, and colours of another kind, are errors in any case.
    for text in ["newmtl a\nKd spectral x", "newmtl a\nwhitted_fresnel snell", "newmtl a\nwhitted_x 1"] {
        assert!(read_at(Path::new("m.mtl"), text.as_bytes(), false).is_err(), "{text}");
    }
}

/// Each of these renders, with one note that says what was assumed.
#[test]
fn what_exporters_write_is_mapped_as_viewers_show_it() {
    let plain = crate::scene::material::plain("a");
    let grey = |kd: f64| Material { diffuse: DVec3::splat(kd), ..plain.clone() };
    let clear =
        |share: f64, ior: f64| Material { secondary: share, fresnel: Fresnel::Exact, ior, ..plain.clone() };
    let blended = |share: f64| Material {
        secondary: share,
        fresnel: Fresnel::Constant(0.0),
        ior: 1.0,
        ..plain.clone()
    };
    for (statements, wanted, line, note) in [
        ("Ka 1 1 1", plain.clone(), 2, "`Ka` is not used"),
        ("Kd 255 255 255", grey(1.0), 2, "255ths"),
        ("Kd 51 51 51", grey(0.2), 2, "255ths"),
        ("d 0.5\nillum 2", blended(0.5), 2, "passes straight on"),
        ("Tr 0.25", blended(0.25), 2, "passes straight on"),
        ("Tr 255", plain.clone(), 2, "outside 0 to 1"),
        ("d 2", plain.clone(), 2, "outside 0 to 1"),
        ("d 1\nTr 1", plain.clone(), 2, "different things"),
        ("illum 7\nd 0\nNi 0", clear(1.0, 1.5), 4, "`Ni` outside"),
        ("illum 4\nd 0.5\nNi -1", clear(0.5, 1.5), 4, "`Ni` outside"),
        ("Ks 1 1 1\nillum 7", plain.clone(), 3, "opaque"),
        ("Ks 1 1 1\nd 1\nillum 9", plain.clone(), 4, "opaque"),
        ("illum 99", plain.clone(), 2, "`illum` without a possible value"),
        ("Kd nan nan nan", plain.clone(), 2, "`Kd` without a possible value"),
        ("Ks 0.5 0.5 0.5\nNs 20", plain.clone(), 2, "highlights are not drawn"),
        ("map_Bump -bm 0.3 no.png", plain.clone(), 2, "`map_Bump` is kept"),
        ("map_Kd no.png", plain.clone(), 2, "missing or cannot be read"),
    ] {
        let (materials, notes) = lenient(&format!("newmtl a\n{statements}\n"));
        let [material] = &materials[..] else { panic!("{statements}") };
        assert_eq!(Material { undrawn: None, ..material.clone() }, wanted, "{statements}");
        let [only] = &notes[..] else { panic!("{statements}: {notes:?}") };
        assert!(only.starts_with(&format!("{line}: ")) && only.contains(note), "{statements}: {only}");
    }
    for quiet in
        ["Ka 0.08 0.08 0.08", "Ni 0", "Ka 0.08 0.08 0.08\nKs 0 0 0\nd 1\nillum 2", "illum 1\nd 1\nTr 0"]
    {
        assert_eq!(lenient(&format!("newmtl a\n{quiet}\n")), (vec![plain.clone()], vec![]), "{quiet}");
    }
    // Glass by hand, as before.
    assert_eq!(lenient("newmtl a\nillum 7\nNi 1.33"), (vec![clear(1.0, 1.33)], vec![]));
    // Our own keys win and need no note.
    let own = "newmtl a\nKs 1 1 1\nillum 7\nNi 1.4\nwhitted_secondary 0.5\nwhitted_fresnel exact\nwhitted_ambient 1\nKa 1 1 1";
    let (materials, notes) = lenient(own);
    assert_eq!(materials, [Material { ambient: 1.0, ..clear(0.5, 1.4) }]);
    assert_eq!(notes, [] as [&str; 0]);
}

#[test]
fn names_are_the_rest_of_the_line() {
    let (materials, notes) = lenient("newmtl Paint #1\nKd 1 0 0\nnewmtl Paint #2\nKd 0 1 0\n");
    assert_eq!(materials.iter().map(|m| m.name.as_str()).collect::<Vec<_>>(), ["Paint #1", "Paint #2"]);
    assert_eq!(notes, [] as [&str; 0]);
    // Of two of one name the last counts; GBK and Latin-1 stay different.
    let (materials, notes) = lenient("newmtl a\nKd 1 0 0\nnewmtl a\nKd 0 1 0\n");
    assert_eq!((materials.len(), materials[0].diffuse), (1, DVec3::Y));
    assert!(notes[0].contains("the last is used"));
    let text = b"newmtl \xba\xec\nKd 1 0 0\nnewmtl \xc0\xb6\nKd 0 0 1\n";
    let (materials, _) = read_at(Path::new("m.mtl"), text, false).unwrap();
    assert_eq!(materials[0].name, "\\xba\\xec");
    assert_ne!(materials[0].name, materials[1].name);
}

#[test]
fn textures_give_their_mean_color() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.mtl");
    std::fs::create_dir(folder.path().join("Tex")).unwrap();
    let picture = image::ImageBuffer::from_fn(2, 1, |x, _| image::Rgb([if x == 0 { 255u8 } else { 0 }; 3]));
    let file = folder.path().join("Tex/Half white.png");
    picture.save(&file).unwrap();
    for (line, diffuse) in [
        ("map_Kd Tex/Half white.png", 0.5),
        ("Kd 0.5 0.5 0.5\nmap_Kd -s 1 1 1 -o 0 0 -clamp on tex\\half White.png", 0.25),
        ("map_Kd C:\\Users\\me\\Tex\\Half white.png", 0.8),
    ] {
        let text = format!("newmtl a\n{line}\n");
        let (materials, notes) = read_at(&path, text.as_bytes(), false).unwrap();
        assert_eq!(materials[0].diffuse, DVec3::splat(diffuse), "{line}");
        assert_eq!(notes.len(), 1, "{notes:?}");
        let undrawn = materials[0].undrawn.as_ref().unwrap();
        if diffuse < 0.8 {
            assert_eq!(undrawn.textures.len(), 1);
            let TextureFile { role, file: found } = &undrawn.textures[0];
            assert_eq!((*role, found.canonicalize().unwrap()), ("map_Kd", file.canonicalize().unwrap()));
        }
    }
}

#[test]
fn highlights_are_kept() {
    let (materials, _) = lenient("newmtl a\nKs 0.1 0.2 0.3\nNs 96\n");
    let undrawn = materials[0].undrawn.as_ref().unwrap();
    assert_eq!((undrawn.specular, undrawn.shininess), (Some(DVec3::new(0.1, 0.2, 0.3)), Some(96.0)));
    assert_eq!(lenient("newmtl a\nKd 1 1 1\n").0[0].undrawn, None);
}

/// None is looked for among all the others.
#[test]
fn many_materials() {
    let text: String = (0..100_000).map(|i| format!("newmtl m{i}\nKd 0.5 0.5 0.5\nKa 1 1 1\n")).collect();
    let (materials, notes) = lenient(&text);
    assert_eq!((materials.len(), notes.len()), (100_000, 1));
}

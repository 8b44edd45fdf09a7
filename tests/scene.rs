//! Scenes: every file in `scenes/` loads, every mistake is told with its place, nothing panics.
// Helpers of tests are not seen as tests: a panic is the failure report there too.
#![allow(clippy::unwrap_used)]

use clap::Parser;
use glam::DVec3;
use proptest::prelude::*;
use std::path::{Path, PathBuf};
use whitted::scene::procedural::{self, Shape, displaced_sphere, rotated_cube};
use whitted::scene::{Fresnel, ReadOptions, Scene, SceneError};

const CAMERA: &str = "[camera]\nlook_from = [0, 5, 14]\nlook_at = [0, 5, 0]\n";

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes")
}

/// Parses a text as if it lay in `scenes/`.
fn parse(text: &str) -> Result<Scene, SceneError> {
    Scene::parse(text, folder().join("test.toml"))
}

#[test]
fn every_scene_loads() {
    let mut count = 0;
    for entry in std::fs::read_dir(folder()).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "toml") {
            let scene = Scene::load(&path).unwrap_or_else(|e| panic!("{e}"));
            assert!(!scene.spheres.is_empty() || scene.triangle_count() > 0);
            count += 1;
        }
    }
    assert!(count >= 7, "only {count} scenes");
}

#[test]
fn defaults_are_those_documented() {
    let scene = parse(&format!("{CAMERA}[material.a]\ndiffuse = [1, 0.5, 0]\n")).unwrap();
    let c = scene.camera;
    assert_eq!((c.up, c.fov, c.width, c.height), (DVec3::Y, 45f64.to_radians(), 600, 500));
    assert_eq!((scene.render.samples, scene.render.depth, scene.render.background), (1, 4, DVec3::ZERO));
    let m = &scene.materials[0];
    assert_eq!((m.ambient, m.secondary, m.fresnel, m.ior), (0.1, 0.0, Fresnel::Constant(1.0), 1.5));
}

#[test]
fn the_format_is_read_whole() {
    let scene = parse(
        "render = {samples = 3, depth = 7, background = 0.25}\n\
        light = [{position = [1, 2, 3], intensity = 10}, {position = [0, 0, 0], intensity = [1, 2.5, 0]}]\n\
        [camera]\nlook_from = [0, 0, 5]\nlook_at = [0, 0, 0]\nup = [0, 3, 4]\nfov = 90\nwidth = 0x10\nheight = 8.0\n\
        [material.z]\ndiffuse = [1, 1, 1]\nsecondary = 1\nfresnel = \"exact\"\nior = 2\n\
        [material.a]\ndiffuse = [1, 1, 1]\nfresnel = 0\nambient = 3\n\
        [[sphere]]\ncenter = [1e3, -2, 0.5]\nradius = 2\nmaterial = \"a\"\n\
        [[polygon]]\nvertices = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]\nnormal = [0, 0, -7]\nmaterial = \"z\"\n\
        [[mesh]]\nfile = \"glass_prism.obj\"\nmaterial = \"z\"\nscale = 2\nrotate = [0, 90, 0]\ntranslate = [1, 0, 0]\n\
        [[mesh]]\nfile = \"glass_prism.obj\"\n[[mesh]]\nfile = \"glass_prism.obj\"\n",
    )
    .unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((scene.camera.width, scene.camera.height), (16, 8));
    assert!(scene.camera.up.distance(DVec3::new(0.0, 0.6, 0.8)) < 1e-15);
    assert_eq!((scene.render.samples, scene.render.depth), (3, 7));
    assert_eq!(scene.render.background, DVec3::splat(0.25));
    assert_eq!(scene.lights[0].intensity, DVec3::splat(10.0));
    assert_eq!(scene.lights[1].intensity, DVec3::new(1.0, 2.5, 0.0));
    // Materials keep the text's order; the MTL's follows once, though two meshes use it.
    let names: Vec<_> = scene.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["z", "a", "glass"]);
    assert_eq!(scene.spheres[0].material, 1);
    // The written normal turns the corners' order round.
    assert_eq!(scene.polygons[0].normal, DVec3::NEG_Z);
    assert_eq!(scene.polygons[0].vertices[1], DVec3::Y);
    assert_eq!(scene.meshes[0].vertices[0], DVec3::new(2.0, 0.0, 1.0));
    assert!(scene.meshes[0].faces.iter().all(|f| f.material == 0));
    assert!(scene.meshes[2].faces.iter().all(|f| f.material == 2));
    assert_eq!(scene.meshes[0].faces.len(), 8);
}

/// Mistakes below [`CAMERA`] (three lines) and a material on lines 4 and 5.
#[test]
fn mistakes_below_a_camera() {
    const SPHERE: &str = "[[sphere]]\ncenter = [0, 0, 0]\nradius = 1\nmaterial = \"white\"\n";
    let sphere = |line: &str| {
        let key = line.split(' ').next().unwrap();
        let lines = SPHERE.lines().map(|l| if l.starts_with(key) { line } else { l });
        format!("{}\n", lines.collect::<Vec<_>>().join("\n"))
    };
    let polygon = |v: &str| format!("[[polygon]]\nvertices = {v}\nmaterial = \"white\"\n");
    let light = |v: &str| format!("[[light]]\nposition = [0, 0, 0]\nintensity = {v}\n");
    let material = |v: &str| format!("[material.m]\ndiffuse = [1, 1, 1]\n{v}\n");
    let two = |second: String| format!("{SPHERE}{second}");
    let cases: Vec<(String, usize, usize, &str, &str)> = vec![
        (sphere("radius = -1"), 8, 10, "sphere 1", "`radius` is -1"),
        (sphere("radius = 0"), 8, 10, "sphere 1", "`radius` is 0"),
        (sphere("radius = nan"), 8, 10, "sphere 1", "not finite"),
        (sphere("radius = inf"), 8, 10, "sphere 1", "not finite"),
        (sphere("radius = 1e999"), 8, 10, "sphere 1", "not finite"),
        (sphere("radius = \"1\""), 8, 10, "sphere 1", "is a string where a number"),
        (sphere("radius = [1]"), 8, 10, "sphere 1", "is a list where a number"),
        (sphere("center = [0, 0]"), 7, 10, "sphere 1", "2 numbers; three"),
        (sphere("center = [0, 0, true]"), 7, 17, "sphere 1", "is a boolean"),
        (sphere("center = [0, 1e80, 0]"), 7, 10, "sphere 1", "at most 1e75"),
        (sphere("center = 3"), 7, 10, "sphere 1", "is a number where a list"),
        (sphere("material = \"wite\""), 9, 12, "sphere 1", "did you mean `white`?"),
        (sphere("material = 7"), 9, 12, "sphere 1", "is a number where a string"),
        (sphere("radius = 1\nraduis = 2"), 9, 1, "sphere 1", "unknown key `raduis`; did you mean `radius`?"),
        (two(sphere("radius = -3")), 12, 10, "sphere 2", "`radius` is -3"),
        (two("[[sphere]]\nradius = 1\n".into()), 10, 1, "sphere 2", "`center` is missing"),
        ("[sphere]\n".into(), 6, 1, "scene", "not a list of tables"),
        ("[[render]]\n".into(), 6, 1, "scene", "`render` is not one table"),
        ("[spheres]\n".into(), 6, 2, "scene", "did you mean `sphere`?"),
        ("[render]\nsamples = 0\n".into(), 7, 11, "render", "`samples` is 0"),
        ("[render]\nsamples = 1.5\n".into(), 7, 11, "render", "whole number"),
        ("[render]\nsamples = 99999999999\n".into(), 7, 11, "render", "from 1 to 16777216"),
        ("[render]\ndepth = 0\n".into(), 7, 9, "render", "`depth` is 0"),
        ("[render]\ndepth = -4\n".into(), 7, 9, "render", "`depth` is -4"),
        ("[render]\nbackground = [0, -1, 0]\n".into(), 7, 18, "render", "`background` is -1"),
        (light("-1"), 8, 13, "light 1", "`intensity` is -1"),
        (light("[1, 2, -3]"), 8, 20, "light 1", "`intensity` is -3"),
        (light("\"bright\""), 8, 13, "light 1", "number or [r, g, b]"),
        (light("1e39"), 8, 13, "light 1", "single precision"),
        ("[[light]]\nintensity = 1\n".into(), 6, 1, "light 1", "`position` is missing"),
        (material("ior = 0"), 8, 7, "material `m`", "`ior` is 0"),
        (material("ior = 1001"), 8, 7, "material `m`", "from 0.001 to 1000"),
        (material("secondary = 1.1"), 8, 13, "material `m`", "from 0 to 1"),
        (material("fresnel = -0.1"), 8, 11, "material `m`", "`fresnel` is -0.1"),
        (material("fresnel = \"snell\""), 8, 11, "material `m`", "\"schlick\" or \"exact\""),
        (material("fresnel = true"), 8, 11, "material `m`", "a number from 0 to 1"),
        (material("ambient = -1"), 8, 11, "material `m`", "`ambient` is -1"),
        (material("difuse = [1, 1, 1]"), 8, 1, "material `m`", "did you mean `diffuse`?"),
        ("[material]\nm = 3\n".into(), 7, 5, "material `m`", "a material is a table"),
        ("[material.m]\nior = 1\n".into(), 6, 1, "material `m`", "`diffuse` is missing"),
        ("[material.m]\ndiffuse = [1, 1, -1]\n".into(), 7, 18, "material `m`", "`diffuse` is -1"),
        (polygon("[[0, 0, 0], [1, 0, 0]]"), 7, 12, "polygon 1", "2 corners"),
        (polygon("[[0, 0, 0], [1, 0, 0], [2, 0, 0]]"), 7, 12, "polygon 1", "without area"),
        (polygon("[[0, 0, 0], [1, 0, 0], [1, 1, 0.1], [0, 1, 0]]"), 7, 12, "polygon 1", "not planar"),
        (
            polygon("[[0, 0, 0], [4, 4, 0], [4, 0, 0], [1, 3, 0]]"),
            7,
            12,
            "polygon 1",
            "the side from corner 1 meets the side from corner 3",
        ),
        (polygon("[[0, 0, 0], [1, 0], [0, 1, 0]]"), 7, 24, "polygon 1", "2 numbers"),
        (
            polygon("[[0, 0, 0], [1, 0, 0], [0, 1, 0]]\nnormal = [1, 0, 1]"),
            8,
            10,
            "polygon 1",
            "perpendicular",
        ),
        (polygon("[[0, 0, 0], [1, 0, 0], [0, 1, 0]]\nnormal = [0, 0, 0]"), 8, 10, "polygon 1", "length 0"),
        ("[[mesh]]\nfile = \"none.obj\"\n".into(), 7, 8, "mesh `none.obj`", "cannot be read"),
        ("[[mesh]]\nscale = 1\n".into(), 6, 1, "mesh 1", "`file` is missing"),
        ("[[mesh]]\nfile = \"a.obj\"\nscale = 0\n".into(), 8, 9, "mesh `a.obj`", "`scale` is 0"),
        ("[[mesh]]\nfile = \"a.obj\"\nrotate = 90\n".into(), 8, 10, "mesh `a.obj`", "list of three"),
        ("[[mesh]]\nfile = \"a.obj\"\nmaterial = \"b\"\n".into(), 8, 12, "mesh `a.obj`", "no material `b`"),
        ("[render]\nsamples = 1\nsamples = 2\n".into(), 8, 1, "scene", "duplicate key"),
        ("[[sphere]]\nradius = = 1\n".into(), 7, 10, "scene", ""),
    ];
    assert!(cases.len() >= 50);
    for (text, line, column, object, part) in cases {
        let whole = format!("{CAMERA}[material.white]\ndiffuse = [1, 1, 1]\n{text}");
        let error = parse(&whole).expect_err(&whole);
        assert_eq!(
            (error.line, error.column, error.object.as_str()),
            (line, column, object),
            "{text}\n{error}"
        );
        assert!(error.message.contains(part), "{text}\n{error}");
        assert!(!error.remedy.is_empty(), "{text}\n{error}");
    }
}

#[test]
fn mistakes_in_the_camera() {
    let camera =
        |from: &str, at: &str, more: &str| format!("[camera]\nlook_from = {from}\nlook_at = {at}\n{more}\n");
    let plain = |more: &str| camera("[0, 0, 1]", "[0, 0, 0]", more);
    for (text, line, column, part) in [
        (String::new(), 1, 1, "`[camera]` is missing"),
        ("camera = 1".into(), 1, 10, "`camera` is not one table"),
        ("[camera]\nlook_at = [0, 0, 0]".into(), 1, 1, "`look_from` is missing"),
        (camera("[1, 2, 3]", "[1, 2.0, 3]", ""), 3, 11, "equals `look_from`"),
        (camera("[0, 5, 0]", "[0, 0, 0]", ""), 3, 11, "parallel"),
        (plain("up = [0, 0, -2]"), 4, 6, "parallel"),
        (plain("up = [0, 0, 0]"), 4, 6, "length 0"),
        (plain("fov = 0"), 4, 7, "`fov` is 0"),
        (plain("fov = 180"), 4, 7, "`fov` is 180"),
        (plain("fov = -20"), 4, 7, "between 0 and 180"),
        (plain("width = 0"), 4, 9, "`width` is 0"),
        (plain("height = 65536"), 4, 10, "from 1 to 65535"),
        (plain("widht = 3"), 4, 1, "did you mean `width`?"),
        (plain("é = 3"), 4, 1, ""),
    ] {
        let error = parse(&text).expect_err(&text);
        assert_eq!((error.line, error.column), (line, column), "{text}\n{error}");
        assert!(error.message.contains(part), "{text}\n{error}");
    }
    let error = parse(&camera("[0, 5, 0]", "[0, 0, 0]", "")).unwrap_err();
    assert_eq!(error.remedy, "write `up = [0, 0, 1]`");
}

#[test]
fn files_that_cannot_be_read_are_named() {
    let error = Scene::load(Path::new("no/such/scene.toml")).unwrap_err();
    assert_eq!((error.line, error.file.as_path()), (0, Path::new("no/such/scene.toml")));
    assert!(error.to_string().starts_with("no/such/scene.toml: scene: cannot be read"), "{error}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("latin1.toml");
    std::fs::write(&path, b"[camera]\n# \xe9t\xe9\n").unwrap();
    let error = Scene::load(&path).unwrap_err();
    assert_eq!((error.line, error.column), (2, 3));
    assert!(error.message.contains("UTF-8"));
}

#[test]
fn mistakes_in_a_mesh_name_the_meshes_file() {
    let folder = tempfile::tempdir().unwrap();
    let text = format!("{CAMERA}[[mesh]]\nfile = \"m.obj\"\n");
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, text).unwrap();
    std::fs::write(folder.path().join("m.mtl"), "newmtl red\n").unwrap();
    let strict = ReadOptions { strict: true, ..ReadOptions::default() };
    for (obj, line, column, part) in [
        ("v 0 0 0\r\nv 1 0 0\r\nf 1 2 3\r\n", 3, 1, "without a material"),
        ("mtllib m.mtl\nusemtl rde\n", 2, 8, "did you mean `red`?"),
        ("mtllib m.mtl\nv 0 0 0\nusemtl red\nf 1 1 4\n", 4, 7, "vertex 4 of 1"),
    ] {
        std::fs::write(folder.path().join("m.obj"), obj).unwrap();
        let error = Scene::load_with(&path, &strict).unwrap_err();
        assert_eq!(error.file, folder.path().join("m.obj"));
        assert_eq!(
            (error.line, error.column, error.object.as_str()),
            (line, column, "mesh `m.obj`"),
            "{error}"
        );
        assert!(error.message.contains(part), "{error}");
    }
}

#[test]
fn meshes_are_put_in_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    std::fs::write(folder.path().join("m.obj"), "o a\nv 1 2 3\nv 2 2 3\nv 1 3 3\nf 1 2 3\no b\nf 3 1 2\n")
        .unwrap();
    let load = |keys: &str| {
        std::fs::write(&path, format!("{CAMERA}[[mesh]]\nfile = \"m.obj\"\n{keys}\n")).unwrap();
        Scene::load(&path)
    };
    let first = |keys: &str| load(keys).unwrap().meshes[0].vertices[0];
    let matrix = "matrix = [[0, -1, 0, 10], [1, 0, 0, 20], [0, 0, 2, 30], [0, 0, 0, 1]]";
    assert_eq!(first(matrix), DVec3::new(8.0, 21.0, 36.0));
    // The matrix first, then scale, rotate and translate.
    let all = format!("{matrix}\nscale = [1, -2, 3]\nrotate = [0, 0, 90]\ntranslate = [0.5, 0, 0]");
    assert_eq!(first(&all), DVec3::new(42.5, 8.0, 108.0));
    assert_eq!(first("scale = -2"), DVec3::new(-2.0, -4.0, -6.0));
    assert_eq!(first("scale = [2, 2, 2]"), first("scale = 2"));
    // A mirror turns the order of corners, so that the outside stays outside.
    assert_eq!(load("scale = [-1, 1, 1]").unwrap().meshes[0].faces[0].vertices, [0, 2, 1]);
    assert_eq!(load("scale = [-1, -1, 1]").unwrap().meshes[0].faces[0].vertices, [0, 1, 2]);
    let part = load("node = \"b\"").unwrap();
    assert_eq!(part.meshes[0].faces.iter().map(|f| f.vertices).collect::<Vec<_>>(), [[2, 0, 1]]);
    for (keys, part) in [
        ("scale = [1, 0, 1]", "`scale` is 0"),
        ("matrix = [[1, 0, 0, 0]]", "has 1 rows"),
        ("matrix = [[1, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]", "3 numbers"),
        ("matrix = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 1, 1]]", "no affine one"),
        ("matrix = [[1, 2, 3, 0], [2, 4, 6, 0], [0, 0, 1, 0], [0, 0, 0, 1]]", "made flat"),
        ("node = \"c\"", "no object or group `c`"),
    ] {
        let error = load(keys).unwrap_err();
        assert!(error.message.contains(part), "{error}");
    }
}

#[test]
fn polygons_with_dents_and_holes() {
    let polygon = |vertices: &str| {
        parse(&format!(
            "{CAMERA}[material.m]\ndiffuse = [1, 1, 1]\n[[polygon]]\nvertices = {vertices}\nmaterial = \"m\"\n"
        ))
    };
    let area = |scene: &Scene| {
        scene.polygons[0]
            .triangles()
            .map(|[a, b, c]| (b - a).cross(c - a).dot(scene.polygons[0].normal) / 2.0)
            .sum::<f64>()
    };
    let dent = polygon("[[0, 0, 0], [2, 0, 0], [2, 2, 0], [1, 0.5, 0]]").unwrap();
    assert_eq!((area(&dent), dent.triangle_count()), (1.5, 2));
    let hole = "[[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0], [0, 0, 0], [1, 1, 0], [1, 3, 0], [3, 3, 0], [3, 1, 0], [1, 1, 0]]";
    let hole = polygon(hole).unwrap();
    assert_eq!((area(&hole), hole.triangle_count(), hole.notes.is_empty()), (12.0, 8, true));
    let closed = polygon("[[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 0]]").unwrap();
    assert_eq!((area(&closed), closed.notes.iter().count()), (0.5, 1));
}

#[derive(Parser)]
struct Line {
    #[command(subcommand)]
    shape: Shape,
}

/// Runs `generate` with `flags`, writing to `path`.
fn generate(flags: &str, path: &Path) {
    let line = ["generate"].into_iter().chain(flags.split(' ')).chain(["-o", path.to_str().unwrap()]);
    procedural::run(&Line::try_parse_from(line).unwrap().shape).unwrap();
}

#[test]
fn generated_meshes_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let scene_path = folder.path().join("s.toml");
    std::fs::write(&scene_path, format!("{CAMERA}[[mesh]]\nfile = \"m.obj\"\n")).unwrap();
    let obj = folder.path().join("m.obj");

    let flags = "rotated-cube --size 2 --rotate 10,20,30 --translate 1,2,-3 --color 0.5,1,0.25";
    generate(flags, &obj);
    let first = std::fs::read(&obj).unwrap();
    let scene = Scene::load(&scene_path).unwrap_or_else(|e| panic!("{e}"));
    let cube = rotated_cube(2.0, DVec3::new(10.0, 20.0, 30.0), DVec3::new(1.0, 2.0, -3.0));
    let mesh = &scene.meshes[0];
    assert!(mesh.vertices.iter().zip(&cube.vertices).all(|(a, b)| a.distance(*b) < 1e-6));
    assert!(mesh.faces.iter().map(|f| f.vertices).eq(cube.faces.iter().map(|f| f.vertices)));
    assert_eq!(scene.materials[0].diffuse, DVec3::new(0.5, 1.0, 0.25));
    assert!(!scene.materials[0].has_secondary());
    generate(flags, &obj);
    assert_eq!(std::fs::read(&obj).unwrap(), first);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 3);

    generate("displaced-sphere --triangles 1000 --size 2", &obj);
    let scene = Scene::load(&scene_path).unwrap_or_else(|e| panic!("{e}"));
    let sphere = displaced_sphere(7, 1.0, 7);
    assert!(scene.meshes[0].vertices.iter().zip(&sphere.vertices).all(|(a, b)| a.distance(2.0 * *b) < 1e-6));
    assert!(scene.meshes[0].faces.iter().map(|f| f.vertices).eq(sphere.faces.iter().map(|f| f.vertices)));

    let flake = folder.path().join("flake.toml");
    generate("sphereflake --level 2", &flake);
    assert_eq!(Scene::load(&flake).unwrap_or_else(|e| panic!("{e}")).spheres.len(), 91);
}

#[test]
fn the_cube_in_scenes_is_the_generators() {
    let folder_out = tempfile::tempdir().unwrap();
    let readme = std::fs::read_to_string(folder().join("README.md")).unwrap();
    let command =
        readme.lines().find_map(|l| l.trim().strip_prefix("whitted generate rotated-cube ")).unwrap();
    let flags = command.strip_suffix(" -o scenes/rotated_cube.obj").unwrap();
    generate(&format!("rotated-cube {flags}"), &folder_out.path().join("rotated_cube.obj"));
    for name in ["rotated_cube.obj", "rotated_cube.mtl"] {
        let new = std::fs::read_to_string(folder_out.path().join(name)).unwrap();
        assert_eq!(new, std::fs::read_to_string(folder().join(name)).unwrap());
    }
}

#[test]
fn generate_refuses_what_it_cannot_write() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["missing/m.obj", "m.mtl"] {
        let path = folder.path().join(name);
        let line = ["generate", "rotated-cube", "-o", path.to_str().unwrap()];
        assert!(procedural::run(&Line::try_parse_from(line).unwrap().shape).is_err());
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

/// Loads `text` as an OBJ file with an MTL beside it.
fn load_obj(text: &[u8]) -> Result<Scene, SceneError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, format!("{CAMERA}[[mesh]]\nfile = \"m.obj\"\n")).unwrap();
    std::fs::write(folder.path().join("m.mtl"), "newmtl a\n").unwrap();
    std::fs::write(folder.path().join("m.obj"), text).unwrap();
    Scene::load(&path)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn no_bytes_panic(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        let _ = parse(&String::from_utf8_lossy(&bytes));
        let _ = load_obj(&bytes);
    }

    #[test]
    fn no_mutated_scene_panics(
        edits in proptest::collection::vec((any::<prop::sample::Index>(), 0usize..4, "[-0-9a-z.\\[\\]\"= \n]{0,6}"), 1..5),
        name in prop::sample::select(vec!["cornell_glass", "mesh_glass", "nested_glass", "furnace"]),
    ) {
        let text = std::fs::read_to_string(folder().join(name).with_extension("toml")).unwrap();
        let mut text: Vec<char> = text.chars().collect();
        for (at, removed, new) in edits {
            let at = at.index(text.len());
            let end = (at + removed).min(text.len());
            text.splice(at..end, new.chars());
        }
        if let Err(error) = parse(&text.into_iter().collect::<String>()) {
            prop_assert!(error.line > 0 && error.column > 0 && !error.remedy.is_empty());
        }
    }

    #[test]
    fn no_obj_panics(
        lines in proptest::collection::vec(
            "(v|vn|f|f|f|usemtl|mtllib|#|s|vt)( (-?[0-9]{1,2}(/{1,2}[0-9])?|a|m.mtl|nan|1e300|\\\\\n)){0,5}", 0..30),
        head in prop::sample::select(vec!["", "mtllib m.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\n"]),
    ) {
        let text = format!("{head}{}\n", lines.join("\n"));
        match load_obj(text.as_bytes()) {
            Ok(scene) => for mesh in &scene.meshes {
                for face in &mesh.faces {
                    prop_assert!(face.vertices.iter().all(|v| (*v as usize) < mesh.vertices.len()));
                    prop_assert!(face.normals.iter().flatten().all(|n| (*n as usize) < mesh.normals.len()));
                    prop_assert!(face.material < scene.materials.len());
                }
            },
            Err(error) => prop_assert!(error.line > 0 && !error.remedy.is_empty(), "{}", error),
        }
    }
}

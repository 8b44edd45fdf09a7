use super::*;
use crate::scene::Scene;
use std::path::Path;

const SCENE: &str = "\
[camera]
look_from = [0, 2, 6]
look_at = [0, 1, 0]

[[light]]
position = [2, 5, 3]
intensity = 20

[material.floor]
diffuse = [0.8, 0.8, 0.8]

[material.glass]
diffuse = [0, 0, 0]
secondary = 1
fresnel = \"exact\"

[[polygon]]
vertices = [[-5, 0, -5], [-5, 0, 5], [5, 0, 5], [5, 0, -5]]
material = \"floor\"

[[sphere]]
center = [0, 1, 0]
radius = 1
material = \"glass\"
";

#[test]
fn a_scene_is_told_by_its_shapes() {
    let scene = Scene::parse(SCENE, "a.toml").unwrap();
    let about = About::Scene(SceneFile::of(Path::new("a.toml"), &scene));
    assert_eq!(
        about.text(),
        "a.toml: scene\n\
         shapes    2 triangles, 1 sphere, 1 polygon\n\
         bounds    (-5, 0, -5) to (5, 2, 5)\n\
         camera    at (0, 2, 6) to (0, 1, 0), 45 degrees, 600x500 pixels\n\
         light     at (2, 5, 3), intensity 20\n\
         material  `floor`: 1 shape, diffuse 0.8, ambient 0.1\n\
         material  `glass`: 1 shape, diffuse 0, ambient 0.1, mirror and glass 1, fresnel exact, ior 1.5\n"
    );
    let json = serde_json::to_value(&about).unwrap();
    assert_eq!((&json["kind"], &json["triangles"]), (&"scene".into(), &2.into()));
    assert_eq!(json["materials"][1]["fresnel"], "exact");
}

//! Near things keep their digits whatever else is in the scene, at default settings; what f32 cannot hold is
//! rendered in f64, and said.

use std::path::Path;
use whitted::compare::metrics::pixel_error;
use whitted::render::{Rendered, Renderer};
use whitted::scene::Scene;
use whitted::settings::{DeviceChoice, Precision, Settings};

/// Balls of 20 cm on a ground of 10^5 m.
const SMALL_THINGS: &str = r#"
[camera]
look_from = [0.4, 0.3, 0.8]
look_at = [0.05, 0.08, 0]
fov = 45
width = 160
height = 120
[render]
samples = 1
depth = 4
[material.matte]
diffuse = [0.8, 0.7, 0.6]
ambient = 0.1
[material.mirror]
diffuse = [1, 1, 1]
secondary = 0.8
[[light]]
position = [1, 2, 1]
intensity = 3
[[polygon]]
vertices = [[-1e5, 0, -1e5], [-1e5, 0, 1e5], [1e5, 0, 1e5], [1e5, 0, -1e5]]
material = "matte"
[[sphere]]
center = [0, 0.1, 0]
radius = 0.1
material = "matte"
[[sphere]]
center = [0.22, 0.1, 0.1]
radius = 0.1
material = "mirror"
"#;

const MOON: &str = "[[sphere]]\ncenter = [-3.8e8, 1e7, 1e8]\nradius = 1.74e6\nmaterial = \"matte\"\n";

fn scene(more: &str) -> Scene {
    Scene::parse(&format!("{SMALL_THINGS}{more}"), Path::new("small_things.toml")).expect("a scene")
}

fn renderer() -> Renderer {
    Renderer::new(&DeviceChoice::Cpu).expect("a Vulkan device")
}

fn rendered(renderer: &mut Renderer, scene: &Scene, precision: Precision) -> Rendered {
    renderer.render(scene, &Settings { precision, ..Settings::of(scene) }).expect("an image")
}

#[test]
fn a_ground_and_a_moon_leave_small_things_as_they_are() {
    let mut renderer = renderer();
    for scene in [scene(""), scene(MOON)] {
        let by_default = renderer.render(&scene, &Settings::of(&scene)).expect("an image");
        let double = rendered(&mut renderer, &scene, Precision::Double);
        let pixels = by_default.linear.iter().zip(&double.linear);
        let changed = pixels.filter(|(a, b)| pixel_error(*a, *b).1 > 1).count();
        // M + 3 sqrt M + 3 with M below 1: 2000 pixels of edge, u * 64 * 3 of 5e-3.
        assert!(changed <= 7, "{changed}");
        assert_eq!((by_default.report.warnings.len(), &*by_default.report.settings.precision), (0, "robust"));
    }
}

#[test]
fn what_single_precision_cannot_hold_is_rendered_in_double_and_said() {
    let mut renderer = renderer();
    let mut scene = scene("");
    // Through a lens whose pixels are narrower than single precision tells directions apart.
    scene.camera.look_from = [3e4, 4e4, 8.66e4].into();
    scene.camera.fov = 1e-5;
    let by_default = renderer.render(&scene, &Settings::of(&scene)).expect("an image");
    let double = rendered(&mut renderer, &scene, Precision::Double);
    assert_eq!(by_default.linear, double.linear);
    assert_eq!(by_default.report.settings.precision, "f64");
    assert!(by_default.report.warnings[0].starts_with("rendered in f64 because the scene has two scales"));
    assert!(double.report.warnings.is_empty());
    let single = rendered(&mut renderer, &scene, Precision::Robust);
    assert_eq!(single.report.settings.precision, "robust", "what is asked for is obeyed");
    let said = &single.report.warnings[0];
    assert!(said.contains("may be wrong at --precision robust"), "{said}");
}

#[test]
fn a_scene_of_one_scale_has_the_frame_of_all_of_it() {
    let scene = Scene::load("scenes/cornell.toml").expect("a scene");
    let settings = Settings { width: 60, height: 50, samples: 1, ..Settings::of(&scene) };
    let mut renderer = renderer();
    let mut at =
        |precision| renderer.render(&scene, &Settings { precision, ..settings.clone() }).expect("an image");
    let (by_default, robust) = (at(Precision::default()), at(Precision::Robust));
    assert_eq!(by_default.linear, robust.linear);
    assert!(by_default.report.warnings.is_empty());
}

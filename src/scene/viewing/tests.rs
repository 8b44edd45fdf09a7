use super::*;
use crate::scene::import;
use std::fs;

/// A needle, a plate and a lump far from the origin, and spheres.
const SHAPES: [(&str, &str); 5] = [
    ("needle.nff", "p 3\n0 0 0\n0.01 0 0\n0 -100 0\n"),
    ("plate.nff", "p 4\n-5 -1 0\n5 -1 0\n5 1 0\n-5 1 0\n"),
    ("far.nff", "p 3\n1e6 2e6 -3e6\n1000001 2e6 -3e6\n1e6 2000002 -2999999\n"),
    ("balls.nff", "s 0 0 0 1\ns 3 0 0 0.5\ns 0 -2 4 0.25\n"),
    ("tiny.nff", "s 0 0 0 1e-9\np 3\n0 0 0\n1e-8 0 0\n0 0 3e-8\n"),
];

fn view(name: &str, text: &str, size: Option<[u32; 2]>) -> Scene {
    let options = ReadOptions { size, ..ReadOptions::default() };
    around(Path::new(name), text.as_bytes(), &options).unwrap_or_else(|e| panic!("{e}"))
}

/// Where a ball's ends show in the picture, in half pictures from its middle: the greatest size of x and y.
fn reach(scene: &Scene) -> [f64; 2] {
    let camera = &scene.camera;
    let [right, up, forward] = camera.axes();
    let tan = (camera.fov / 2.0).tan();
    let tans = [tan * f64::from(camera.width) / f64::from(camera.height), tan];
    let mut most = [0.0f64; 2];
    let mut ball = |center: DVec3, radius: f64| {
        let at = center - camera.look_from;
        for ((most, tan), along) in most.iter_mut().zip(tans).zip([right, up]) {
            let (x, z) = (at.dot(along), at.dot(forward));
            // The cone from the eye around the sphere, seen along the other axis of the picture.
            let (angle, half) = (x.abs().atan2(z), (radius / x.hypot(z)).asin());
            *most = most.max((angle + half).tan() / tan);
            assert!(z > radius, "behind the eye");
        }
    };
    for mesh in &scene.meshes {
        mesh.faces.iter().flat_map(|f| f.vertices).for_each(|v| ball(mesh.vertices[v as usize], 0.0));
    }
    scene.spheres.iter().for_each(|s| ball(s.center, s.radius));
    most
}

#[test]
fn all_of_a_model_is_in_the_picture_and_fills_it() {
    for (name, text) in SHAPES {
        for size in [[600, 500], [1000, 100], [100, 1000], [1, 1], [65_535, 7]] {
            let scene = view(name, text, Some(size));
            assert_eq!([scene.camera.width, scene.camera.height], size);
            let [x, y] = reach(&scene);
            assert!(x < 0.91 && y < 0.91, "{name} {size:?}: {x} {y}");
            // The needle's near end keeps its distance.
            assert!(x.max(y) > 0.89 || name == "needle.nff", "{name} {size:?}: {x} {y}");
        }
    }
}

/// Diffuse 0.8, ambient 0.1, facing the key light at the model's centre.
#[test]
fn a_surface_that_faces_the_key_light_is_as_bright_as_its_colour() {
    for (name, text) in SHAPES {
        let scene = view(name, text, None);
        let boxes = scene.meshes.iter().map(|m| m.bounds());
        let balls = scene.spheres.iter().map(|s| Bounds::of_sphere(s.center, s.radius));
        let center = middle(&boxes.chain(balls).fold(Bounds::EMPTY, Bounds::union));
        let normal = (scene.lights[0].position - center).normalize();
        let light = |light: &Light| {
            let to = light.position - center;
            light.intensity.x * to.normalize().dot(normal).max(0.0) / to.length_squared()
        };
        let color = 0.8 * (0.1 + scene.lights.iter().map(light).sum::<f64>());
        assert!((color - 0.8).abs() < 1e-3, "{name}: {color}");
    }
}

#[test]
fn up_is_that_of_the_format() {
    assert_eq!(up_axis(Path::new("a.obj")), Axis::Y);
    assert_eq!(view(SHAPES[3].0, SHAPES[3].1, None).camera.up, DVec3::Z);
    assert_eq!(up_axis(Path::new("a.STL")), Axis::Z);
    assert_eq!(up_axis(Path::new("a.glb")), Axis::Y);
}

const WITH_VIEW: &str =
    "v\nfrom 0 9 0\nat 0 0 0\nup 0 0 1\nangle 33.3\nhither 1\nresolution 30 20\nl 0 9 9\ns 0 0 0 1\n";

#[test]
fn the_files_own_camera_and_lights_are_used() {
    let scene = view("a.nff", WITH_VIEW, None);
    assert_eq!((scene.camera.look_from, scene.camera.width, scene.camera.height), (9.0 * DVec3::Y, 30, 20));
    assert_eq!(scene.lights.len(), 1);
    assert_eq!(view("a.nff", WITH_VIEW, Some([9, 8])).camera.height, 8);
    // A camera that looks along `up` is none.
    let odd = view("a.nff", &WITH_VIEW.replace("up 0 0 1", "up 0 1 0"), None);
    assert_eq!(odd.camera.up, DVec3::Z);
    assert!(odd.notes.lines().iter().any(|note| note.contains("look nowhere")), "{:?}", odd.notes);
    // Without lights there is one at the camera.
    let dark = view("a.nff", &WITH_VIEW.replace("l 0 9 9\n", ""), None);
    assert_eq!(dark.lights[0].position, dark.camera.look_from);
    assert!((dark.lights[0].intensity.x / 81.0 - 0.9).abs() < 1e-3);
}

#[test]
fn lights_for_another_exposure_are_scaled_together() {
    let bounds = Bounds::of_sphere(DVec3::ZERO, 1.0);
    let light = |x: f64, intensity: f64| Light { position: DVec3::X * x, intensity: DVec3::splat(intensity) };
    let mut reading = Reading { strict: false, notes: Notes::default() };
    let mut scaled = |lights: &[Light]| exposed(lights, &bounds, Path::new("a.glb"), &mut reading);
    let sensible = [light(10.0, 100.0), light(5.0, 50.0)];
    assert_eq!(scaled(&sensible), sensible);
    let watts = [light(10.0, 5000.0), light(5.0, 2500.0)];
    let dimmed = scaled(&watts);
    assert!(
        (dimmed[1].intensity.x / 25.0 - RECEIVED).abs() < 1e-3,
        "the brightest gives what a key light gives"
    );
    assert!((dimmed[0].intensity.x / dimmed[1].intensity.x - 2.0).abs() < 1e-12);
    assert_eq!(reading.notes.iter().count(), 1);
}

#[test]
fn the_text_of_an_import_is_the_same_scene() {
    let folder = tempfile::tempdir().unwrap();
    let named = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a \"b\"\nf 1 2 3\n";
    fs::write(folder.path().join("m.mtl"), "newmtl a \"b\"\nKd 0.1 0.2 0.3\nillum 5\nKs 1 1 1\n").unwrap();
    let cases = SHAPES.into_iter().chain([("a.nff", WITH_VIEW), ("with materials.obj", named)]);
    for (name, text) in cases {
        let model = folder.path().join(name);
        fs::write(&model, text).unwrap();
        for size in [None, Some([31, 77])] {
            let options = ReadOptions { size, ..ReadOptions::default() };
            let direct = Scene::load_with(&model, &options).unwrap();
            let text = import(&direct, name);
            let mut again = Scene::parse(&text, folder.path().join("scene.toml"))
                .unwrap_or_else(|e| panic!("{e}\n{text}"));
            (again.file, again.notes) = (direct.file.clone(), direct.notes.clone());
            assert_eq!(again, direct, "{text}");
        }
    }
    // An edit is noticed.
    let scene = view(SHAPES[0].0, SHAPES[0].1, None);
    assert!(import(&scene, "x.nff").contains("fov       = 45\n"));
}

#[test]
fn what_cannot_be_seen_is_an_error() {
    let error = |text: &str| {
        around(Path::new("a.nff"), text.as_bytes(), &ReadOptions::default()).unwrap_err().to_string()
    };
    assert!(error("s 1e50 0 0 1\n").contains("too far"));
    assert!(error("s 0 0 0 1e25\n").contains("too large"));
}

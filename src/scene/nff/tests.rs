use super::*;
use crate::scene::notes::Notes;
use crate::scene::{Fresnel, Material, Transform};
use glam::{DAffine3, DMat3};
use std::path::Path;

/// Model, materials and notes of a text.
fn read_at(text: &str, place: Transform, strict: bool) -> Result<(Model, Vec<Material>, Notes), SceneError> {
    let source = Source { file: Path::new("a.nff"), text: text.as_bytes() };
    let mut library = Library::new(Vec::new());
    let mut reading = Reading { strict, notes: Notes::default() };
    let wanted = Wanted { object: "mesh `a.nff`", material: None, place, node: None };
    let model = read(source, wanted, &mut library, &mut reading)?;
    Ok((model, library.materials, reading.notes))
}

fn unplaced() -> Transform {
    Transform::new(1.0, DVec3::ZERO, DVec3::ZERO)
}

fn text(text: &str) -> (Model, Vec<Material>, Notes) {
    read_at(text, unplaced(), false).unwrap_or_else(|e| panic!("{e}"))
}

fn error(text: &str) -> String {
    read_at(text, unplaced(), false).unwrap_err().to_string()
}

const BALLS: &str = "\
# comment
b 0.078 0.361 0.753
v
from 2.1 1.3 1.7
at 0 0 0
up 0 0 1
angle 45
hither 0.01
resolution 512 256
l 4 3 2
l 1 -4 4 1 0.5 0
f 1 0.75 0.33 1 0 0 0 0
p 4
12 12 -0.5
-12 12 -0.5
-12 -12 -0.5
12 -12 -0.5
f 1 0.9 0.7 0.5 0.5 3.0827 0 0
s 0 0 0 0.5
s 0.272166 0.272166 0.544331 -0.166667
f 1 0.75 0.33 1 0 0 0 0
p 3 0 0 1 1 0 1 0 1 1
";

#[test]
fn a_scene_of_the_spd_is_read() {
    let (model, materials, notes) = text(BALLS);
    assert_eq!(model.background, Some(DVec3::new(0.078, 0.361, 0.753)));
    let [camera] = model.cameras[..] else { panic!("one camera") };
    assert_eq!((camera.look_from, camera.up), (DVec3::new(2.1, 1.3, 1.7), DVec3::Z));
    assert_eq!((camera.width, camera.height, camera.fov), (512, 256, 45f64.to_radians()));
    assert_eq!(model.spheres.len(), 2);
    assert_eq!(model.spheres[1].radius, 0.166667);
    assert_eq!(model.meshes.len(), 1);
    assert_eq!(model.meshes[0].faces.len(), 3);
    // Equal fills are one material.
    assert_eq!(materials.len(), 2);
    assert_eq!((materials[0].secondary, materials[0].diffuse), (0.0, DVec3::new(1.0, 0.75, 0.33)));
    assert_eq!((materials[1].secondary, materials[1].fresnel), (0.5, Fresnel::Constant(1.0)));
    assert_eq!(materials[1].diffuse, DVec3::new(1.0, 0.9, 0.7));
    assert!(notes.lines().iter().any(|n| n.contains("highlights")), "{notes:?}");
}

/// At the centre of the scene each light gives 1 / sqrt(2), whatever its distance.
#[test]
fn lights_give_the_centre_what_the_spd_says() {
    let (model, ..) = text(BALLS);
    let bounds = model.bounds();
    let center = (bounds.lo + bounds.hi) / 2.0;
    for (light, color) in model.lights.iter().zip([DVec3::ONE, DVec3::new(1.0, 0.5, 0.0)]) {
        // These lights are nearer than a quarter of the floor's diagonal, from where on they grow no more.
        let least = (bounds.hi - bounds.lo).length_squared() / 16.0;
        let square = light.position.distance_squared(center).max(least);
        assert!((light.intensity / square - color * 0.5f64.sqrt()).length() < 1e-12);
    }
    let (far, ..) = text("l 30 0 0\nl 0 40 0\ns 0 0 0 1");
    let received = far.lights.iter().map(|l| l.intensity.x / l.position.length_squared());
    assert!(received.into_iter().all(|x| (x - 0.5f64.sqrt()).abs() < 1e-15));
}

/// Kd c light + Ks reflected + T refracted, for any light.
#[test]
fn materials_weigh_as_the_fill_says() {
    for [kd, ks, t] in [[1.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.3, 0.2, 0.4], [0.0, 0.0, 1.0], [0.0, 0.25, 0.75]]
    {
        let (_, materials, _) = text(&format!("f 0.2 0.4 1 {kd} {ks} 0 {t} 1.3\ns 0 0 0 1"));
        let m = &materials[0];
        let Fresnel::Constant(f) = m.fresnel else { panic!("a constant") };
        let own = m.diffuse * (1.0 - m.secondary);
        assert!((own - DVec3::new(0.2, 0.4, 1.0) * kd).length() < 1e-15, "{m:?}");
        assert!((m.secondary * f - ks).abs() < 1e-15 && (m.secondary * (1.0 - f) - t).abs() < 1e-15, "{m:?}");
        assert_eq!((m.ambient, m.refracts()), (0.0, t > 0.0));
        assert_eq!(m.ior, if t > 0.0 { 1.3 } else { 1.5 });
    }
    let (_, materials, notes) = text("f 1 1 1 1 1 0 0 0\ns 0 0 0 1");
    assert!((materials[0].diffuse.x * (1.0 - materials[0].secondary) - 0.5).abs() < 1e-15);
    assert!(notes.lines()[0].contains("dimmed"), "{notes:?}");
}

/// Every corner lies on the cone, the middle of every side within the stated thousandth, and every normal is the
/// cone's gradient.
#[test]
fn cones_are_as_near_as_stated() {
    for (base, apex) in [
        ((0.0, 2.0), (3.0, 2.0)),
        ((1.0, 2.0), (4.0, 0.5)),
        ((-1.0, 0.0), (2.0, 1.0)),
        ((0.0, 1.0), (5.0, 0.0)),
    ] {
        let ends = format!("c 0 0 {} {} 0 0 {} {}", base.0, base.1, apex.0, apex.1);
        let (model, _, notes) = text(&ends);
        assert!(notes.lines().iter().any(|n| n.contains("72 sides")), "{notes:?}");
        let radius = |z: f64| base.1 + (apex.1 - base.1) * (z - base.0) / (apex.0 - base.0);
        let slope = (apex.1 - base.1) / (apex.0 - base.0);
        let mesh = &model.meshes[0];
        let open = [base.1, apex.1].contains(&0.0);
        assert_eq!(mesh.faces.len(), if open { 72 } else { 144 });
        for face in &mesh.faces {
            let corners = face.vertices.map(|v| mesh.vertices[v as usize]);
            let around = |p: DVec3| p.truncate().length();
            for (corner, normal) in corners.iter().zip(face.normals.unwrap()) {
                assert!((around(*corner) - radius(corner.z)).abs() < 1e-12);
                let normal = mesh.normals[normal as usize];
                if around(*corner) > 0.0 {
                    let want = (corner.truncate() / around(*corner)).extend(-slope).normalize();
                    assert!(normal.distance(want) < 1e-12, "{normal} {want}");
                }
            }
            for (a, b) in [(0, 1), (1, 2), (2, 0)] {
                let middle = (corners[a] + corners[b]) / 2.0;
                let off = radius(middle.z) - around(middle);
                assert!((-1e-12..=0.001 * base.1.max(apex.1)).contains(&off), "{off}");
            }
            let outside = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            assert!(outside.truncate().dot(corners.iter().sum::<DVec3>().truncate()) > 0.0);
        }
    }
}

#[test]
fn patches_keep_their_normals_and_glass_is_a_solid_of_its_own() {
    let (model, materials, _) = text(
        "f 1 1 1 1 0 0 0 0\npp 3\n0 0 0 0 0 2\n1 0 0 0 0 1\n0 1 0 0 1 1\nf 1 1 1 0 0 0 1 1.5\np 3\n0 0 1\n1 0 1\n0 1 1\n",
    );
    assert_eq!(model.meshes.len(), 2);
    let slope = DVec3::new(0.0, 0.5f64.sqrt(), 0.5f64.sqrt());
    assert!(model.meshes[0].normals[2].distance(slope) < 1e-15);
    assert!(materials[model.meshes[1].faces[0].material].refracts());
    assert_eq!(model.meshes[1].faces[0].normals, None);
}

#[test]
fn everything_goes_to_its_place() {
    let place = Transform::new(2.0, DVec3::new(0.0, 0.0, 90.0), DVec3::X);
    let (model, ..) = read_at("l 1 0 0\ns 1 0 0 3", place, false).unwrap();
    assert_eq!((model.spheres[0].center, model.spheres[0].radius), (DVec3::new(1.0, 2.0, 0.0), 6.0));
    assert_eq!(model.lights[0].position, DVec3::new(1.0, 2.0, 0.0));
    let stretched =
        |x| unplaced().after(DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(x, 2.0, 2.0)))).unwrap();
    let (model, ..) = read_at("s 1 0 0 3\np 3 0 0 0 1 0 0 0 1 0", stretched(-2.0), false).unwrap();
    assert_eq!(model.spheres[0].radius, 6.0);
    let mesh = &model.meshes[0];
    let [a, b, c] = mesh.faces[0].vertices.map(|v| mesh.vertices[v as usize]);
    assert!((b - a).cross(c - a).z > 0.0, "a mirrored face keeps its outside");
    assert!(read_at("s 1 0 0 3", stretched(3.0), false).unwrap_err().to_string().contains("stretched"));
}

#[test]
fn what_is_missing_or_odd_is_assumed_or_refused() {
    let (_, materials, notes) =
        text("s 0 0 0 1\nf 1 0 0 0.5 0.5 4 0 1 a.jpg\ntess 4\ns 0 0 0 2 1 1\np 2\n0 0 0\n1 0 0\n");
    assert_eq!(materials.len(), 2);
    let lines = notes.lines().join("\n");
    for part in ["white", "textures", "does not have", "two corners"] {
        assert!(lines.contains(part), "{part}: {lines}");
    }
    assert!(read_at("s 0 0 0 1", unplaced(), true).is_err(), "strict");
    for (bad, part) in [
        ("nff\nversion 2.0", "WorldToolKit"),
        ("# nothing", "no shapes"),
        ("s 0 0 x 1", "1:7"),
        ("s 0 0 0", "ends too early"),
        ("p 4\n0 0 0\n1 0 0\n", "ends too early"),
        ("p 1e30\n", "no number of corners"),
        (
            "v\nfrom 0 0 0\nangle 200\nup 0 0 1\nat 0 0 1\nhither 1\nresolution 9 9\ns 0 0 0 1",
            "impossible angle",
        ),
        ("v\nfrom 0 0 0\ns 0 0 0 1", "within the viewpoint"),
        ("f 1 1 1 -1 0 0 0 0", "negative weight"),
        ("f -1 1 1 1 0 0 0 0", "negative channel"),
        ("s 1e80 0 0 1", "larger than"),
    ] {
        assert!(error(bad).contains(part), "{bad}: {}", error(bad));
    }
}

//! Alpha and layers of first surfaces: against the oracle's hits, closed forms, and as files.

// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

mod common;

use assert_cmd::Command;
use common::build::{Add, everything, matte, scene};
use common::{render, renderer, small};
use glam::DVec3;
use whitted::image::Picture;
use whitted::reference::oracle::Oracle;
use whitted::render::{Quiet, SurfaceLayer, Surfaces};
use whitted::scene::Scene;
use whitted::settings::{Precision, Settings};

fn layer(found: &Surfaces, wanted: SurfaceLayer) -> &[[f32; 3]] {
    &found.layers.iter().find(|(layer, _)| *layer == wanted).unwrap().1
}

fn surfaces(scene: &Scene, settings: &Settings) -> Surfaces {
    renderer().surfaces(scene, settings, true, &SurfaceLayer::ALL, &mut Quiet).unwrap().unwrap()
}

/// Object and material of the oracle's primitives, in its order.
fn owners(scene: &Scene) -> Vec<[usize; 2]> {
    let (polygons, spheres) = (scene.polygons.len(), scene.spheres.len());
    let mut all = Vec::new();
    for (i, p) in scene.polygons.iter().enumerate() {
        all.extend((0..p.triangle_count()).map(|_| [i + 1, p.material + 1]));
    }
    for (i, mesh) in scene.meshes.iter().enumerate() {
        all.extend(mesh.faces.iter().map(|f| [polygons + spheres + i + 1, f.material + 1]));
    }
    all.extend(scene.spheres.iter().enumerate().map(|(i, s)| [polygons + i + 1, s.material + 1]));
    all
}

/// Numbers, coverage and albedo follow from which primitive each sample of the oracle hits, numbers from the one at the
/// pixel's centre.
#[test]
fn they_are_those_of_the_primitives_that_the_oracle_hits() {
    for precision in [Precision::Robust, Precision::Double] {
        let scene = everything();
        let settings = Settings { precision, ..small(&scene, 64, 5, 3) };
        let found = surfaces(&scene, &settings);
        let truth = Oracle::new(&scene).render(&Settings { depth: 1, ..settings.clone() });
        let centers = Oracle::new(&scene).render(&Settings { depth: 1, samples: 1, ..settings.clone() });
        let owners = owners(&scene);
        let n = settings.samples as usize;
        // A sample within rounding of an edge may fall to either side.
        let mut others = 0;
        for (i, hits) in truth.first_hit.chunks(n).enumerate() {
            let covered = hits.iter().flatten().count() as f32 / n as f32;
            let albedo: DVec3 =
                hits.iter().flatten().map(|id| scene.materials[owners[*id as usize][1] - 1].diffuse).sum();
            let [object, material] = centers.first_hit[i].map_or([0, 0], |id| owners[id as usize]);
            let alike = (found.alpha.as_ref().unwrap()[i] - covered).abs() < 1e-6
                && layer(&found, SurfaceLayer::Object)[i][0] == object as f32
                && layer(&found, SurfaceLayer::Material)[i][0] == material as f32
                && (DVec3::from(layer(&found, SurfaceLayer::Albedo)[i].map(f64::from)) - albedo / n as f64)
                    .abs()
                    .max_element()
                    < 1e-6;
            others += usize::from(!alike);
        }
        let pixels = truth.first_hit.len() / n;
        assert!(pixels > 2000 && others <= 2, "{others} of {pixels} pixels differ");
        let numbers = |wanted| layer(&found, wanted).iter().map(|p| p[0] as u32).max().unwrap();
        assert_eq!([SurfaceLayer::Object, SurfaceLayer::Material].map(numbers), [7, 5]);
    }
}

/// Of one sample, distance and normal say where on a sphere or a floor it is: there it must lie in its own pixel.
#[test]
fn distance_and_normal_lead_to_the_pixel() {
    let mut s = scene();
    let white = s.material(matte());
    let (center, radius) = (DVec3::new(0.3, 0.4, -0.2), 0.75);
    s.sphere(center, radius, white);
    s.camera.look_from = DVec3::new(1.0, 2.0, 6.0);
    s.camera.look_at = center;
    let settings = Settings { precision: Precision::Robust, samples: 1, ..small(&s, 90, 1, 5) };
    let found = surfaces(&s, &settings);
    let (z, normal) = (layer(&found, SurfaceLayer::Z), layer(&found, SurfaceLayer::Normal));
    let [right, up, forward] = s.camera.axes();
    let half = (s.camera.fov / 2.0).tan();
    let (w, h) = (f64::from(settings.width), f64::from(settings.height));
    let mut seen = 0;
    for (i, (z, n)) in z.iter().zip(normal).enumerate() {
        if found.alpha.as_ref().unwrap()[i] == 0.0 {
            assert!(z[0].is_infinite() && *n == [0.0; 3]);
            continue;
        }
        seen += 1;
        let n = DVec3::from(n.map(f64::from));
        assert!((n.length() - 1.0).abs() < 1e-5);
        let to = center + radius * n - s.camera.look_from;
        assert!((to.dot(forward) - f64::from(z[0])).abs() < 1e-4, "{} {}", to.dot(forward), z[0]);
        assert!(n.dot(to) < 0.0, "the normal is on the side of the eye");
        let x = (to.dot(right) / to.dot(forward) / (half * w / h) + 1.0) / 2.0 * w;
        let y = (1.0 - to.dot(up) / to.dot(forward) / half) / 2.0 * h;
        let (left, top) = ((i % w as usize) as f64, (i / w as usize) as f64);
        assert!(
            (left - 0.01..=left + 1.01).contains(&x) && (top - 0.01..=top + 1.01).contains(&y),
            "{x} {y}"
        );
    }
    assert!(seen > 500, "{seen}");
}

/// Layers cost the picture nothing, and are the same in any order of tiles.
#[test]
fn the_picture_keeps_its_bits() {
    let scene = everything();
    let mut renderer = renderer();
    let settings = Settings { precision: Precision::Robust, ..small(&scene, 40, 4, 1) };
    let before = render(&mut renderer, &scene, &settings).linear;
    let whole = renderer.surfaces(&scene, &settings, true, &SurfaceLayer::ALL, &mut Quiet).unwrap();
    let mut tiles = settings.clone();
    tiles.schedule.tile_pixels = Some(77);
    assert_eq!(whole, renderer.surfaces(&scene, &tiles, true, &SurfaceLayer::ALL, &mut Quiet).unwrap());
    assert_eq!(before, render(&mut renderer, &scene, &settings).linear);
    let crop = Settings { crop: Some([7, 3, 25, 20]), ..settings.clone() };
    let part = renderer.surfaces(&scene, &crop, true, &[SurfaceLayer::Z], &mut Quiet).unwrap().unwrap();
    let whole = whole.unwrap();
    let row = |y: usize| &layer(&whole, SurfaceLayer::Z)[40 * y + 7..40 * y + 25];
    let expected: Vec<[f32; 3]> = (3..20).flat_map(row).copied().collect();
    assert_eq!(layer(&part, SurfaceLayer::Z), expected);
}

const SCENE: &str = "[camera]\nlook_from = [0, 1, 5]\nlook_at = [0, 0.5, 0]\nfov = 40\n\
    [render]\nsamples = 8\ndepth = 3\nbackground = [0.25, 0.5, 0.75]\n\
    [[light]]\nposition = [3, 5, 4]\nintensity = 40\n[material.red]\ndiffuse = [0.8, 0.2, 0.1]\n\
    [[sphere]]\ncenter = [0, 0.5, 0]\nradius = 0.5\nmaterial = \"red\"\n";

/// Put back over the background, a picture with alpha is the one without.
#[test]
fn alpha_over_the_background_is_the_picture() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("s.toml"), SCENE).unwrap();
    let run = |out: &str, more: &[&str]| {
        let mut command = Command::cargo_bin("whitted").unwrap();
        command.arg("render").arg(at("s.toml")).arg("-o").arg(at(out));
        command.args(["--device", "cpu", "-q", "--size", "60x40"]).args(more);
        command.assert().success();
    };
    run("plain.exr", &[]);
    run("alpha.exr", &["--alpha", "--layers", "z,normal,albedo,object,material"]);
    run(
        "alpha.png",
        &["--alpha", "--layers", "z,object", "--bits", "16", "--page", at("p.html").to_str().unwrap()],
    );
    let plain = Picture::read(at("plain.exr")).unwrap();
    let exr = image::open(at("alpha.exr")).unwrap().into_rgba32f();
    let png = image::open(at("alpha.png")).unwrap().into_rgba16();
    let mut partly = 0;
    for ((over, behind), straight) in exr.pixels().zip(&plain.linear).zip(png.pixels()) {
        let a = over.0[3];
        partly += usize::from(a > 0.0 && a < 1.0);
        for c in 0..3 {
            let full = over.0[c] + (1.0 - a) * [0.25, 0.5, 0.75][c];
            assert!((full - behind[c]).abs() < 1e-6, "{over:?} {behind:?}");
            let code = f32::from(straight.0[c]) / 65_535.0;
            let linear = if code <= 0.04045 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) };
            assert!((linear * a - over.0[c].min(a)).abs() < 1e-4, "{straight:?} {over:?}");
        }
        assert!((f32::from(straight.0[3]) / 65_535.0 - a).abs() < 1e-5);
    }
    assert!(partly > 20, "{partly}");
    assert!(at("alpha.z.png").exists() && at("alpha.object.png").exists());
    assert!(std::fs::read_to_string(at("p.html")).unwrap().contains("distance along the view"));
    // A picture that lets through what is behind it is no number to compare.
    whitted_compare(&at("alpha.exr"), &at("plain.exr"));
}

fn whitted_compare(a: &std::path::Path, b: &std::path::Path) {
    let out = Command::cargo_bin("whitted").unwrap().arg("compare").args([a, b]).assert().failure();
    let said = String::from_utf8(out.get_output().stderr.clone()).unwrap();
    assert!(said.contains("transparent"), "{said}");
}

/// A picture of too short a time has less than one sample per pixel: it is written all the same, with its layers.
#[test]
fn a_picture_without_samples_keeps_its_layers() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("s.toml"), SCENE).unwrap();
    let mut command = Command::cargo_bin("whitted").unwrap();
    command.arg("render").arg(at("s.toml")).arg("-o").arg(at("a.png"));
    command.args(["--device", "cpu", "-q", "--size", "600x400", "--time", "0.001", "--layers", "z"]);
    command.assert().code(7);
    assert!(at("a.png").exists() && at("a.z.png").exists());
}

#[test]
fn what_does_not_go_together_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("s.toml");
    std::fs::write(&scene, SCENE).unwrap();
    for (out, options, said) in [
        ("a.hdr", &["--alpha"][..], "--alpha needs a PNG or an EXR"),
        ("a.png", &["--layers", "depth"], "one of z, normal, albedo, object, material"),
        ("a.png", &["--alpha", "--error", "0.1"], "cannot be used with"),
        ("a.share", &["--share", "1/2", "--layers", "z"], "cannot be used with"),
        ("-", &["--layers", "z"], "-o needs a file name"),
    ] {
        let mut command = Command::cargo_bin("whitted").unwrap();
        let out = if out == "-" { "-".into() } else { folder.path().join(out) };
        command.arg("render").arg(&scene).arg("-o").arg(out).args(options);
        let result = command.assert().code(2);
        let stderr = String::from_utf8(result.get_output().stderr.clone()).unwrap();
        assert!(stderr.contains(said), "{options:?}: {stderr}");
    }
}

//! Every scene in `scenes`: nothing that ought not to happen happens, and neither place nor scale
//! changes the picture beyond what is derived.

use glam::DVec3;
use std::path::{Path, PathBuf};
use whitted::compare::metrics::{edge_length, mismatch_bound};
use whitted::kernel::defects::Defect;
use whitted::lab::stress::moved;
use whitted::reference::oracle::Oracle;
use whitted::render::Renderer;
use whitted::report::Counters;
use whitted::scene::Scene;
use whitted::settings::{DeviceChoice, Settings};

fn scenes() -> Vec<(PathBuf, Scene)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).expect("scenes").map(|e| e.expect("an entry").path()).collect();
    files.retain(|f| f.extension().is_some_and(|e| e == "toml"));
    files.sort();
    assert!(files.len() >= 7, "{files:?}");
    files
        .into_iter()
        .map(|f| {
            let scene = Scene::load(&f).expect("a sound scene");
            (f, scene)
        })
        .collect()
}

/// Small: 64 pixels wide, one sample.
fn small(scene: &Scene) -> Settings {
    let height = (64 * scene.camera.height).div_ceil(scene.camera.width);
    Settings { width: 64, height, samples: 1, ..Settings::of(scene) }
}

fn picture(renderer: &mut Renderer, scene: &Scene) -> Vec<[f32; 3]> {
    renderer.render(scene, &small(scene)).expect("an image").linear
}

#[test]
fn no_scene_raises_a_counter() {
    let mut renderer = Renderer::new(&DeviceChoice::Cpu).unwrap();
    for (file, scene) in scenes() {
        let report = renderer.render(&scene, &small(&scene)).unwrap().report;
        assert_eq!(report.counters, Counters::default(), "{}", file.display());
        assert!(report.warnings.is_empty(), "{}: {:?}", file.display(), report.warnings);
    }
}

#[test]
fn a_power_of_two_in_scale_changes_no_bit() {
    let mut renderer = Renderer::new(&DeviceChoice::Cpu).unwrap();
    for (file, scene) in scenes() {
        let reference = picture(&mut renderer, &scene);
        for k in [-60, -9, 13, 60] {
            let scaled = picture(&mut renderer, &moved(&scene, 2f64.powi(k), DVec3::ZERO));
            assert!(scaled == reference, "{} at 2^{k}", file.display());
        }
    }
}

/// The comparison above can fail: without the local frame it does.
#[test]
fn without_the_local_frame_scale_changes_bits() {
    let mut renderer = Renderer::new(&DeviceChoice::Cpu).unwrap();
    renderer.plant(Defect::WorldFrame);
    let (_, scene) = scenes().remove(0);
    let scaled = moved(&scene, 2f64.powi(-60), DVec3::ZERO);
    assert!(picture(&mut renderer, &scene) != picture(&mut renderer, &scaled));
}

#[test]
fn a_move_changes_no_more_pixels_than_derived() {
    let mut renderer = Renderer::new(&DeviceChoice::Cpu).unwrap();
    for (file, scene) in scenes() {
        let settings = small(&scene);
        let reference = picture(&mut renderer, &scene);
        let edges = edge_length(&Oracle::new(&scene).render(&settings).first_hit, 64).unwrap();
        let distance = scene.camera.look_from.distance(scene.camera.look_at);
        let footprint = 2.0 * distance * (scene.camera.fov / 2.0).tan() / f64::from(settings.height);
        for k in [0, 3, 6, 9] {
            let far = 10f64.powi(k);
            let image = picture(&mut renderer, &moved(&scene, 1.0, DVec3::new(far, -far / 2.0, far)));
            let close = |a: f32, b: f32| (a - b).abs() <= 1.0 / 255.0;
            let changed =
                image.iter().zip(&reference).filter(|(a, b)| !(0..3).all(|c| close(a[c], b[c]))).count();
            // The file's coordinates and the frame's centre are off by 2^-53 of their size, and every
            // mirror or lens on the way turns that into another edge.
            let depth = f64::from(settings.depth);
            let bound = mismatch_bound(depth * 2f64.powi(-52) * far / footprint, edges, 1);
            assert!(changed as f64 <= bound, "{} at 10^{k}: {changed} > {bound}", file.display());
        }
    }
}

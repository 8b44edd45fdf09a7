//! Surveys trace the same samples as an image, and their marks say what the paths did.

mod common;

use whitted::render::samples::{Mark, Traced};
use whitted::render::{Quiet, Renderer, Survey};
use whitted::scene::Scene;
use whitted::settings::{DeviceChoice, Schedule, Settings};

fn scene(name: &str) -> (Scene, Settings) {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name);
    let scene = Scene::load(&path).expect("a scene of the repository");
    let settings = Settings { width: 40, height: 30, ..Settings::of(&scene) };
    (scene, settings)
}

fn renderer() -> Renderer {
    Renderer::with_validation(&DeviceChoice::Cpu).expect("a device")
}

fn trace(r: &mut Renderer, scene: &Scene, settings: &Settings, pixels: &[u32], end: u32) -> (Traced, u64) {
    let mut survey = Survey::new(r, scene, settings).expect("a survey");
    let traced = survey.trace(pixels, 0..end, &mut Quiet).expect("traced");
    let rays = survey.report().rays;
    (traced, rays.primary + rays.reflection + rays.refraction + rays.shadow)
}

#[test]
fn a_survey_traces_the_samples_of_the_image() {
    let mut r = renderer();
    for name in ["cornell_glass.toml", "many_lights.toml"] {
        let (scene, settings) = scene(name);
        for replicates in [1, 3] {
            let settings = Settings { samples: 6, replicates, ..settings.clone() };
            let image = r.render(&scene, &settings).unwrap();
            let rays = &image.report.rays;
            // Backwards, and in odd parts.
            let all: Vec<u32> = (0..40 * 30).rev().collect();
            let settings =
                Settings { schedule: Schedule { tile_pixels: Some(333), ..Schedule::default() }, ..settings };
            let (traced, counted) = trace(&mut r, &scene, &settings, &all, 6);
            assert_eq!(counted, rays.primary + rays.reflection + rays.refraction + rays.shadow);
            assert_eq!(traced.marks.iter().map(|m| u64::from(m.rays)).sum::<u64>(), counted, "{name}");
            for (at, sums) in
                all.iter().zip(traced.sums.chunks(whitted::render::samples::sets(replicates as usize)))
            {
                let sum = sums.iter().fold([0.0; 3], |a, b| std::array::from_fn(|c| a[c] + b[c]));
                let mean = sum.map(|x: f64| (x / 6.0) as f32);
                assert_eq!(mean, image.linear[*at as usize], "{name}, pixel {at}");
            }
        }
    }
    assert_eq!(r.validation_messages(), Vec::<String>::new());
}

#[test]
fn lists_and_batches_change_nothing() {
    let mut r = renderer();
    let (scene, settings) = scene("nested_glass.toml");
    let settings = Settings { depth: 7, replicates: 2, ..settings };
    let whole: Vec<u32> = (0..40 * 30).collect();
    let (all, _) = trace(&mut r, &scene, &settings, &whole, 4);
    let some: Vec<u32> = whole.iter().copied().filter(|p| p % 7 == 3).collect();
    // So small a queue overflows.
    let schedule = Schedule { capacity: Some(64), tile_pixels: Some(31), ..Schedule::default() };
    let (few, _) = trace(&mut r, &scene, &Settings { schedule, ..settings }, &some, 4);
    for (i, p) in some.iter().enumerate() {
        let p = *p as usize;
        assert_eq!(few.marks[i], all.marks[p]);
        assert_eq!(few.sums[2 * i..2 * i + 2], all.sums[2 * p..2 * p + 2]);
    }
}

#[test]
fn cut_throughput_is_that_of_the_rays_beyond_the_depth() {
    let mut r = renderer();
    // Every ray goes on, with the mirrors' weight: depth d cuts 0.75^d.
    let weight: f64 = 0.75;
    let wall = |z| {
        format!(
            "[[polygon]]\nvertices = [[-9, -9, {z}], [9, -9, {z}], [9, 9, {z}], [-9, 9, {z}]]\nmaterial = \"m\"\n"
        )
    };
    let text = format!(
        "[camera]\nlook_from = [0, 0, 0]\nlook_at = [0.01, 0, -1]\nfov = 1\nwidth = 40\nheight = 30\n\
         [material.m]\ndiffuse = [0, 0, 0]\nsecondary = 0.75\n{}{}",
        wall(-1),
        wall(1)
    );
    let scene = Scene::parse(&text, "mirrors.toml").expect("a scene");
    let settings = Settings::of(&scene);
    let middle = [15 * 40 + 20];
    let cut = |r: &mut Renderer, depth, cutoff| {
        let settings = Settings { depth, cutoff, ..settings.clone() };
        trace(r, &scene, &settings, &middle, 4).0.marks[0]
    };
    for depth in [1, 2, 5, 9] {
        let Mark { cut, depth: longest, .. } = cut(&mut r, depth, 0.0);
        let expected = 4.0 * weight.powi(depth as i32);
        assert!((cut - expected).abs() < 1e-6, "depth {depth}: {cut}, expected {expected}");
        assert_eq!(longest, depth);
    }
    // A weight cut between two powers ends the path there, whatever the depth.
    let least = weight.powi(3) as f32 * 0.999;
    let mark = cut(&mut r, 20, least);
    assert!((mark.cut - 4.0 * weight.powi(4)).abs() < 1e-6 && mark.depth == 4, "{mark:?}");
}

#[test]
fn hashes_tell_an_edge_from_a_smooth_pixel() {
    let mut r = renderer();
    let (scene, settings) = scene("cornell.toml");
    let whole: Vec<u32> = (0..40 * 30).collect();
    let (traced, _) = trace(&mut r, &scene, &settings, &whole, 16);
    let edges = traced.marks.iter().filter(|m| m.hash_least != m.hash_most).count();
    assert!((100..900).contains(&edges), "{edges} of 1200 pixels are edges");
}

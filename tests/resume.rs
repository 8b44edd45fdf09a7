//! Interrupted renders: what is kept, and that going on gives the same image, bit for bit.
// Helpers of tests are not seen as tests: a panic is the failure report there too.
#![allow(clippy::unwrap_used)]

use std::path::Path;
use whitted::render::{Observer, Quiet, RenderError, Rendered, Renderer, ResumeState, Tiles};
use whitted::scene::Scene;
use whitted::settings::sampler::Sampler;
use whitted::settings::{DeviceChoice, Schedule, Settings};

/// Lets so many submits through.
struct StopAfter(u32);

impl Observer for StopAfter {
    fn progress(&mut self, _done: u64, _total: u64) {
        self.0 = self.0.saturating_sub(1);
    }
    fn cancelled(&self) -> bool {
        self.0 == 0
    }
}

fn scene(name: &str) -> Scene {
    Scene::load(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name)).unwrap()
}

/// A small image in tiles of `tile_pixels`.
fn settings(scene: &Scene, tile_pixels: u32) -> Settings {
    let schedule = Schedule { tile_pixels: Some(tile_pixels), batch_samples: Some(2), ..Schedule::default() };
    Settings { width: 30, height: 20, samples: 6, seed: 5, schedule, ..Settings::of(scene) }
}

fn renderer() -> Renderer {
    Renderer::new(&DeviceChoice::Cpu).unwrap()
}

fn bits(rendered: &Rendered) -> Vec<u32> {
    rendered.linear.as_flattened().iter().map(|c| c.to_bits()).collect()
}

/// Through a file's bytes, as `--resume` goes.
fn stored(unfinished: &ResumeState<Tiles>) -> ResumeState<Tiles> {
    let mut bytes = Vec::new();
    unfinished.write(&mut bytes).unwrap();
    ResumeState::read(&mut bytes.as_slice()).unwrap()
}

#[test]
fn the_image_is_the_same_however_often_it_was_interrupted() {
    let scene = scene("cornell_glass.toml");
    let mut renderer = renderer();
    let whole = renderer.render(&scene, &settings(&scene, 600)).unwrap();

    // Tiles of another size each time: 7 leaves rows cut in the middle.
    let mut earlier = None;
    for (stops, (tile_pixels, submits)) in [(7, 20), (50, 3), (7, 31), (90, 4)].into_iter().enumerate() {
        let settings = settings(&scene, tile_pixels);
        let stop = &mut StopAfter(submits);
        let part = match earlier.take() {
            Some(earlier) => renderer.resume(&scene, &settings, earlier, stop).unwrap(),
            None => renderer.render_with(&scene, &settings, stop).unwrap(),
        };
        assert!(part.done < 1.0, "stop {stops}");
        earlier = part.unfinished.as_ref().map(stored);
        assert!(earlier.is_some(), "stop {stops}");
    }
    let last = renderer.resume(&scene, &settings(&scene, 7), earlier.unwrap(), &mut Quiet).unwrap();
    assert_eq!((last.done, last.unfinished), (1.0, None));
    assert_eq!(bits(&whole), last.linear.as_flattened().iter().map(|c| c.to_bits()).collect::<Vec<_>>());

    // Rays are counted once each, whatever was thrown away between.
    let counts = |r: &whitted::report::Report| {
        (r.rays.primary, r.rays.reflection, r.rays.refraction, r.rays.shadow, r.counters)
    };
    assert_eq!(counts(&last.report), counts(&whole.report));
    let generated = |r: &whitted::report::Report| r.passes[0].items;
    assert_eq!(generated(&last.report), generated(&whole.report));
}

#[test]
fn a_crop_resumes_too() {
    let scene = scene("cornell.toml");
    let crop = Settings { crop: Some([3, 2, 28, 17]), ..settings(&scene, 40) };
    let mut renderer = renderer();
    let whole = renderer.render(&scene, &crop).unwrap();
    let part = renderer.render_with(&scene, &crop, &mut StopAfter(8)).unwrap();
    let last = renderer.resume(&scene, &crop, part.unfinished.unwrap(), &mut Quiet).unwrap();
    assert_eq!(bits(&last), bits(&whole));
    assert!(part.report.time.render < last.report.time.render, "times are of both parts");
}

#[test]
fn nothing_is_kept_of_an_unfinished_tile() {
    let scene = scene("cornell.toml");
    let part = renderer().render_with(&scene, &settings(&scene, 600), &mut StopAfter(1)).unwrap();
    assert!(part.done > 0.0 && part.done < 1.0);
    assert_eq!(part.unfinished, None);
}

#[test]
fn another_render_is_refused() {
    let scene = scene("cornell.toml");
    let settings = settings(&scene, 40);
    let mut renderer = renderer();
    let part = renderer.render_with(&scene, &settings, &mut StopAfter(8)).unwrap().unfinished.unwrap();
    let mut refused =
        |scene: &Scene, settings: &Settings| match renderer.resume(scene, settings, part.clone(), &mut Quiet)
        {
            Err(RenderError::Mismatch(why)) => why.0,
            other => panic!("{:?}", other.map(|r| r.done)),
        };
    let why = refused(&scene, &Settings { samples: 7, ..settings.clone() });
    assert!(why.contains("--samples 6") && why.contains("--samples 7"), "{why}");
    let why = refused(&scene, &Settings { sampler: Sampler::Random, ..settings.clone() });
    assert!(why.contains("--sampler owen") && why.contains("--sampler random"), "{why}");
    let why = refused(&scene, &Settings { replicates: 2, ..settings.clone() });
    assert!(why.contains("(replicates 2)"), "{why}");
    let mut moved = scene.clone();
    moved.meshes[0].vertices[0].x += 1e-3;
    let why = refused(&moved, &settings);
    assert!(why.contains("scene"), "{why}");
    let mut dimmed = scene.clone();
    dimmed.lights[0].intensity *= 0.5;
    refused(&dimmed, &settings);
}

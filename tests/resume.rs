//! Interrupted renders: what is kept, and that going on gives the same image, bit for bit.
// Helpers of tests are not seen as tests: a panic is the failure report there too.
#![allow(clippy::unwrap_used)]

use std::path::Path;
use whitted::render::{Observer, Quiet, RenderError, Rendered, Renderer, ResumeState, State, Sums};
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
fn stored(unfinished: &ResumeState<Sums>) -> ResumeState<Sums> {
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
        earlier = part.state.as_ref().map(stored);
        assert!(earlier.is_some(), "stop {stops}");
    }
    let last = renderer.resume(&scene, &settings(&scene, 7), earlier.unwrap(), &mut Quiet).unwrap();
    assert_eq!(last.done, 1.0);
    assert_eq!(bits(&whole), last.linear.as_flattened().iter().map(|c| c.to_bits()).collect::<Vec<_>>());

    // Rays are counted once each, whatever was thrown away between.
    assert_eq!(counts(&last.report), counts(&whole.report));
}

#[test]
fn a_crop_resumes_too() {
    let scene = scene("cornell.toml");
    let crop = Settings { crop: Some([3, 2, 28, 17]), ..settings(&scene, 40) };
    let mut renderer = renderer();
    let whole = renderer.render(&scene, &crop).unwrap();
    let part = renderer.render_with(&scene, &crop, &mut StopAfter(8)).unwrap();
    let last = renderer.resume(&scene, &crop, part.state.unwrap(), &mut Quiet).unwrap();
    assert_eq!(bits(&last), bits(&whole));
    assert!(part.report.time.render < last.report.time.render, "times are of both parts");
}

#[test]
fn another_render_is_refused() {
    let scene = scene("cornell.toml");
    let settings = settings(&scene, 40);
    let mut renderer = renderer();
    let part = renderer.render_with(&scene, &settings, &mut StopAfter(8)).unwrap().state.unwrap();
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

/// Writes the state after every submit, and stops after some of them.
struct KeepAll {
    stop: StopAfter,
    states: Vec<Vec<u8>>,
}

impl Observer for KeepAll {
    fn progress(&mut self, done: u64, total: u64) {
        assert!(done <= total);
        self.stop.progress(done, total);
    }
    fn cancelled(&self) -> bool {
        self.stop.cancelled()
    }
    fn wants_state(&self) -> bool {
        true
    }
    fn keep(&mut self, state: &dyn State) {
        let mut bytes = Vec::new();
        state.write(&mut bytes).unwrap();
        self.states.push(bytes);
    }
}

/// Counts that must not depend on how often a render was left.
fn counts(r: &whitted::report::Report) -> impl PartialEq + std::fmt::Debug + use<> {
    let items: Vec<_> = r.passes.iter().map(|p| (p.name.clone(), p.depth, p.items)).collect();
    let items: Vec<_> = items.into_iter().filter(|(name, ..)| name != "scan").collect();
    (
        r.rays.primary,
        r.rays.reflection,
        r.rays.refraction,
        r.rays.shadow,
        r.rays.by_depth.clone(),
        r.counters,
        items,
    )
}

#[test]
fn from_every_state_on_the_way_the_image_is_the_same() {
    let scene = scene("cornell_glass.toml");
    let mut renderer = renderer();
    let whole = renderer.render(&scene, &settings(&scene, 600)).unwrap();
    let mut keeper = KeepAll { stop: StopAfter(1000), states: Vec::new() };
    let last = renderer.render_with(&scene, &settings(&scene, 170), &mut keeper).unwrap();
    // Inside the first tile, and after each but the last.
    assert!(keeper.states.len() >= 4, "{}", keeper.states.len());
    assert_eq!((bits(&last), counts(&last.report)), (bits(&whole), counts(&whole.report)));
    for (at, state) in keeper.states.iter().enumerate() {
        let state = ResumeState::read(&mut &state[..]).unwrap();
        // Inside a tile and between tiles, with the same tiles and others.
        let tile = [170, 600, 37][at % 3];
        let last = renderer.resume(&scene, &settings(&scene, tile), state, &mut Quiet).unwrap();
        assert_eq!(bits(&last), bits(&whole), "state {at}");
        assert_eq!(counts(&last.report), counts(&whole.report), "state {at}");
    }
}

#[test]
fn a_tile_goes_on_from_the_samples_it_has() {
    let scene = scene("cornell.toml");
    let settings = settings(&scene, 600);
    let mut renderer = renderer();
    let part = renderer.render_with(&scene, &settings, &mut StopAfter(1)).unwrap();
    assert_eq!(part.done, 2.0 / 6.0);
    let last = renderer.resume(&scene, &settings, stored(part.state.as_ref().unwrap()), &mut Quiet).unwrap();
    let whole = renderer.render(&scene, &settings).unwrap();
    assert_eq!((bits(&last), counts(&last.report)), (bits(&whole), counts(&whole.report)));
}

#[test]
fn a_finished_picture_takes_more_samples() {
    let scene = scene("cornell_glass.toml");
    let mut renderer = renderer();
    for (sampler, replicates) in [(Sampler::Owen, 1), (Sampler::Stratified, 1), (Sampler::Random, 3)] {
        let of = |samples| Settings { sampler, replicates, samples, ..settings(&scene, 170) };
        let whole = renderer.render(&scene, &of(99)).unwrap();
        let mut state = None;
        for samples in [3, 6, 66, 99] {
            let next = match state.take() {
                None => renderer.render(&scene, &of(samples)),
                Some(state) => renderer.more(&scene, &of(samples), state, &mut Quiet),
            };
            let next = next.unwrap();
            state = Some(stored(next.state.as_ref().unwrap()));
            if samples == 99 {
                assert_eq!(bits(&next), bits(&whole));
                assert_eq!(counts(&next.report), counts(&whole.report));
            }
        }
        let mut refused =
            |settings: &Settings| match renderer.more(&scene, settings, state.clone().unwrap(), &mut Quiet) {
                Err(RenderError::Mismatch(why)) => why.0,
                other => panic!("{:?}", other.map(|r| r.done)),
            };
        assert!(refused(&of(9)).contains("99 samples"), "{}", refused(&of(9)));
        assert!(refused(&Settings { seed: 6, ..of(198) }).contains("--seed"));
    }
    let one = Settings { samples: 1, ..settings(&scene, 170) };
    let state = renderer.render(&scene, &one).unwrap().state.unwrap();
    let more = renderer.more(&scene, &Settings { samples: 2, ..one }, state, &mut Quiet);
    assert!(matches!(more, Err(RenderError::Mismatch(_))));
    let unfinished =
        renderer.render_with(&scene, &settings(&scene, 40), &mut StopAfter(2)).unwrap().state.unwrap();
    let more = renderer.more(&scene, &settings(&scene, 40), unfinished, &mut Quiet);
    assert!(matches!(more, Err(RenderError::Mismatch(why)) if why.0.contains("--resume")));
}

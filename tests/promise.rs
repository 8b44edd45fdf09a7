//! Images with a known error: cut short anywhere and gone on with, they are the same, bit for bit.

// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

use std::path::Path;
use std::time::{Duration, Instant};
use whitted::accuracy::promise::{Bounded, BoundedImage, Layer, Request, Target};
use whitted::render::{Observer, Quiet, Renderer, ResumeState, State, Survey};
use whitted::scene::Scene;
use whitted::settings::{DeviceChoice, Schedule, Settings};

/// Lets so many submits of the whole's second half through; checks that progress goes forward only.
struct StopAfter {
    submits: u32,
    beyond: f64,
    last: u64,
}

impl Observer for StopAfter {
    fn progress(&mut self, done: u64, total: u64) {
        assert!(done >= self.last && done <= total, "{done} of {total} after {}", self.last);
        self.last = done;
        if done as f64 >= self.beyond * total as f64 {
            self.submits = self.submits.saturating_sub(1);
        }
    }
    fn cancelled(&self) -> bool {
        self.submits == 0
    }
}

fn scene(name: &str) -> Scene {
    Scene::load(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name)).unwrap()
}

fn settings(scene: &Scene, tile_pixels: u32) -> Settings {
    let schedule = Schedule { tile_pixels: Some(tile_pixels), ..Schedule::default() };
    Settings { width: 24, height: 20, seed: 5, schedule, ..Settings::of(scene) }
}

fn request(target: Target) -> Request {
    Request { keep_precision: true, ..Request::to(target) }
}

/// Through a file's bytes, as `--resume` goes.
fn stored(kept: &ResumeState<Bounded>) -> ResumeState<Bounded> {
    let mut bytes = Vec::new();
    kept.write(&mut bytes).unwrap();
    ResumeState::read(&mut bytes.as_slice()).unwrap()
}

fn whole_and_pieces(
    name: &str,
    request: &Request,
    samples: u32,
    stops: &[(u32, u32, f64)],
) -> [BoundedImage; 2] {
    let scene = scene(name);
    let mut renderer = Renderer::new(&DeviceChoice::Cpu).unwrap();
    let own = |tile| {
        let settings = settings(&scene, tile);
        Settings { samples, replicates: if samples > 1 { 4 } else { 1 }, ..settings }
    };
    let whole = renderer.render_bounded(&scene, &own(480), request).unwrap();
    assert!(whole.unfinished.is_none() && !whole.cancelled);
    let mut earlier = None;
    for &(tile, submits, beyond) in stops {
        let mut stop = StopAfter { submits, beyond, last: 0 };
        let part = match earlier {
            Some(earlier) => renderer.resume_bounded(&scene, &own(tile), request, earlier, &mut stop),
            None => renderer.render_bounded_with(&scene, &own(tile), request, &mut stop),
        }
        .unwrap();
        assert!(part.cancelled && part.done > 0.0, "{tile} {submits}");
        let kept = part.unfinished.as_ref().unwrap();
        assert_eq!(&stored(kept), kept);
        // Pixels without samples are filled in, or there are none.
        assert_eq!(part.linear().len(), 480);
        earlier = Some(stored(kept));
    }
    let last = renderer.resume_bounded(&scene, &own(55), request, earlier.unwrap(), &mut Quiet).unwrap();
    [whole, last]
}

#[test]
fn an_error_is_the_same_image_however_often_it_was_interrupted() {
    // In the pilot, and in steps after it.
    let stops = [(16, 2, 0.09), (7, 4, 0.2), (16, 5, 0.4), (7, 3, 0.7)];
    let request = request(Target::Error(0.008));
    let [whole, pieces] = whole_and_pieces("cornell.toml", &request, 1, &stops);
    assert_eq!(whole.report.asked.met, Some(true), "{:?}", whole.report.asked);
    assert_eq!(pieces.samples, whole.samples);
    assert_eq!((&pieces.report.error, &pieces.report.asked), (&whole.report.error, &whole.report.asked));
    let rays = |k: &whitted::report::Report| (k.rays.primary, k.rays.reflection, k.rays.shadow);
    assert_eq!(rays(&pieces.report), rays(&whole.report));
}

#[test]
fn a_budget_is_the_same_image_however_often_it_was_interrupted() {
    let stops = [(16, 3, 0.1), (7, 4, 0.3), (16, 2, 0.7)];
    let [whole, pieces] = whole_and_pieces("cornell_glass.toml", &request(Target::Settings), 16, &stops);
    assert_eq!(pieces.samples, whole.samples);
    assert_eq!((pieces.report.error, pieces.rounding), (whole.report.error, whole.rounding));
}

#[test]
fn an_error_interrupted_at_once_keeps_nothing() {
    let scene = scene("cornell.toml");
    let mut renderer = Renderer::new(&DeviceChoice::Cpu).unwrap();
    let mut stop = StopAfter { submits: 1, beyond: 0.0, last: 0 };
    let request = request(Target::Error(0.01));
    let part = renderer.render_bounded_with(&scene, &settings(&scene, 480), &request, &mut stop).unwrap();
    assert!(part.cancelled && part.done == 0.0 && part.unfinished.is_none() && part.report.error.is_none());
}

#[test]
fn a_survey_ends_in_time_with_the_first_pixels() {
    let scene = scene("nested_glass.toml");
    let mut renderer = Renderer::new(&DeviceChoice::Cpu).unwrap();
    let settings = Settings { width: 300, height: 250, replicates: 4, ..settings(&scene, 1 << 20) };
    let mut survey = Survey::new(&mut renderer, &scene, &settings).unwrap();
    let all: Vec<u32> = (0..300 * 250).collect();
    survey.finish_by(Some(Instant::now()));
    assert_eq!(survey.trace(&all, 0..4, &mut Quiet).unwrap().marks.len(), 0);

    // More than fits in any such time.
    let far = Duration::from_millis(300);
    survey.finish_by(Some(Instant::now() + far));
    let some = survey.trace(&all, 0..4096, &mut Quiet).unwrap();
    assert!(some.marks.len() < all.len(), "{}", some.marks.len());

    survey.finish_by(Some(Instant::now() + far));
    let some = survey.trace(&all, 0..4, &mut Quiet).unwrap();
    assert!(!some.marks.is_empty());
    survey.finish_by(None);
    let first = &all[..some.marks.len().min(500)];
    let again = survey.trace(first, 0..4, &mut Quiet).unwrap();
    assert_eq!(again.marks[..], some.marks[..first.len()]);
    assert_eq!(again.sums[..], some.sums[..4 * first.len()]);
}

/// Writes the state after every part, and stops after some of them.
struct KeepSome {
    states: Vec<Vec<u8>>,
    most: usize,
}

impl Observer for KeepSome {
    fn progress(&mut self, _done: u64, _total: u64) {}
    fn cancelled(&self) -> bool {
        self.states.len() >= self.most
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

#[test]
fn from_every_state_on_the_way_an_error_and_a_budget_are_the_same() {
    let scene = scene("cornell.toml");
    let mut renderer = Renderer::new(&DeviceChoice::Cpu).unwrap();
    for (request, samples) in [(request(Target::Error(0.008)), 1), (request(Target::Settings), 16)] {
        let own = |tile| Settings { samples, ..settings(&scene, tile) };
        let whole = renderer.render_bounded(&scene, &own(480), &request).unwrap();
        let mut keeper = KeepSome { states: Vec::new(), most: usize::MAX };
        let kept = renderer.render_bounded_with(&scene, &own(100), &request, &mut keeper).unwrap();
        assert_eq!((&kept.samples, &kept.report.error), (&whole.samples, &whole.report.error));
        let states = keeper.states;
        assert!(states.len() >= 5, "{}", states.len());
        for state in states.iter().step_by(states.len().div_ceil(6)) {
            let state = ResumeState::read(&mut &state[..]).unwrap();
            let last = renderer.resume_bounded(&scene, &own(37), &request, state, &mut Quiet).unwrap();
            assert_eq!((&last.samples, &last.report.error), (&whole.samples, &whole.report.error));
            let rays = |k: &whitted::report::Report| (k.rays.primary, k.rays.reflection, k.rays.shadow);
            assert_eq!(rays(&last.report), rays(&whole.report));
        }
    }
}

/// Where only a few samples fit, the image is that of a render with so many samples, bit for bit.
#[test]
fn a_short_time_gives_the_plain_render_that_fits() {
    let scene = scene("cornell.toml");
    let mut renderer = Renderer::new(&DeviceChoice::Cpu).unwrap();
    let own = Settings { width: 500, height: 400, ..settings(&scene, 100_000) };
    // Kernels are compiled before the clock starts.
    let plain = renderer.render(&scene, &Settings { samples: 1, ..own.clone() }).unwrap();
    let mut few = 0;
    for share in [2.0, 3.0, 4.0, 6.0] {
        let seconds = share * (plain.report.time.render + 0.05);
        let request = Request::to(Target::Time { seconds, from: Instant::now(), layers: 0 });
        let image = renderer.render_bounded(&scene, &own, &request).unwrap();
        let samples = image.report.settings.samples;
        if image.samples.samples.is_empty() {
            let same = renderer.render(&scene, &Settings { samples, ..own.clone() }).unwrap();
            assert_eq!(image.linear(), same.linear, "{samples} samples");
            assert_eq!((image.done, image.report.asked.met, &image.report.error), (1.0, Some(true), &None));
            assert_eq!(image.layer(Layer::Samples), vec![f64::from(samples); 500 * 400]);
            assert!(image.layer(Layer::Cost).iter().all(|cost| cost.is_nan()));
            few += 1;
        }
    }
    assert!(few > 0, "no time was short");
}

#[test]
fn a_time_goes_on_for_what_is_left_of_it_with_the_samples_it_has() {
    let scene = scene("cornell.toml");
    let mut renderer = Renderer::new(&DeviceChoice::Cpu).unwrap();
    let seconds = 6.0;
    let request = |seconds| Request::to(Target::Time { seconds, from: Instant::now(), layers: 0 });
    let mut keeper = KeepSome { states: Vec::new(), most: 5 };
    let own = settings(&scene, 100);
    let part = renderer.render_bounded_with(&scene, &own, &request(seconds), &mut keeper).unwrap();
    assert!(part.cancelled && part.report.asked.met == Some(false));
    let of = |image: &BoundedImage| image.samples.samples.iter().map(|n| u64::from(*n)).sum::<u64>();
    let state = stored(part.unfinished.as_ref().unwrap());
    let spent = state.time.wall;
    assert!(spent > 0.0 && spent < seconds, "{spent}");
    let start = Instant::now();
    let last = renderer.resume_bounded(&scene, &own, &request(seconds), state, &mut Quiet).unwrap();
    assert!(of(&last) > of(&part) && last.report.time.wall > spent);
    assert!(start.elapsed().as_secs_f64() < 2.0 * seconds, "it ends");
    // One whose time is over gives what it has, and no other time is mistaken for it.
    let mut late = stored(part.unfinished.as_ref().unwrap());
    late.time.wall = 2.0 * seconds;
    let last = renderer.resume_bounded(&scene, &own, &request(seconds), late.clone(), &mut Quiet).unwrap();
    assert_eq!(of(&last), of(&part));
    assert!(renderer.resume_bounded(&scene, &own, &request(7.0), late, &mut Quiet).is_err());
}

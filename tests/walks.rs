//! Walks that stop and go on in other dispatches change no bit, of no picture and of no count.

// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

mod common;

use common::{render, renderer, scenes, small};
use std::process::Command;
use whitted::lab::receipt::differing;
use whitted::render::{ImageSoFar, Observer, Quiet, Rendered, Survey};
use whitted::scene::Scene;
use whitted::settings::forced_features::{Feature, ForcedFeatures};
use whitted::settings::{Precision, Schedule, Settings};

/// Steps so few that every scene with a hierarchy has walks that take more.
const FEW: u32 = 1;

fn subjects() -> Vec<(String, Scene)> {
    let mut all = scenes();
    all.retain(|(name, _)| ["cornell_glass", "fence", "many_lights", "mesh_glass"].contains(&name.as_str()));
    assert_eq!(all.len(), 4);
    all
}

/// Few pixels of a hierarchy, whatever the scene, whose walks take any number of steps.
fn settings(scene: &Scene, features: &[Feature]) -> Settings {
    let mut settings = small(scene, 25, 3, 11);
    settings.depth = settings.depth.clamp(2, 4);
    let features = features.iter().fold(ForcedFeatures::default(), |set, f| set.with(*f));
    settings.schedule.forced_features = features.with(Feature::Hierarchy);
    settings
}

/// The same, walks taking few steps at a time.
fn in_parts(settings: &Settings) -> Settings {
    let schedule = Schedule { walk_steps: Some(FEW), ..settings.schedule };
    Settings { schedule, ..settings.clone() }
}

fn goes_on(rendered: &Rendered) -> bool {
    rendered.report.passes.iter().any(|p| p.name == "walk" && p.launches > 1)
}

#[test]
fn no_bit_and_no_count_depends_on_where_walks_stop() {
    let mut renderer = renderer();
    let mut went_on = 0;
    for (name, scene) in subjects() {
        let of = |features: &[Feature]| settings(&scene, features);
        let fused = Schedule { fused: Some(true), ..of(&[]).schedule };
        let counting = Schedule { count_tests: true, ..of(&[]).schedule };
        let batches = Schedule { batch_samples: Some(1), tile_pixels: Some(60), ..of(&[]).schedule };
        for own in [
            of(&[]),
            of(&[Feature::LoneRays]),
            of(&[Feature::Storage, Feature::MixedLeaves]),
            Settings { schedule: fused, ..of(&[]) },
            Settings { schedule: counting, ..of(&[]) },
            Settings { schedule: batches, ..of(&[]) },
            Settings { precision: Precision::Double, ..of(&[]) },
            Settings { precision: Precision::Fast, ..of(&[]) },
        ] {
            let whole = render(&mut renderer, &scene, &own);
            let parts = render(&mut renderer, &scene, &in_parts(&own));
            let what = format!("{name}, {:?}, {:?}", own.precision, own.schedule);
            assert_eq!(differing(&whole.linear, &parts.linear), 0, "{what}");
            assert_eq!(whole.report.counters, parts.report.counters, "{what}");
            let rays = |r: &Rendered| serde_json::to_string(&r.report.rays).unwrap();
            assert_eq!(rays(&whole), rays(&parts), "{what}");
            assert_eq!(whole.report.tests, parts.report.tests, "{what}");
            assert!(!goes_on(&whole), "{what}");
            // Packets of a scene with few triangles may be through in one step.
            assert!(goes_on(&parts) || name == "many_lights", "{what}");
            went_on += usize::from(goes_on(&parts));
        }
    }
    assert!(went_on > 3 * 8, "every walk of many_lights ends within {FEW} steps");
}

/// Sums and marks of a survey, in which a path's hash tells what it met.
#[test]
fn surveys_do_not_depend_on_where_walks_stop() {
    let mut renderer = renderer();
    for (name, scene) in subjects() {
        let own = settings(&scene, &[]);
        let mut trace = |settings: &Settings| {
            let mut survey = Survey::new(&mut renderer, &scene, settings).unwrap();
            let pixels: Vec<u32> = (0..own.width * own.height).step_by(7).collect();
            let mut all = Vec::new();
            for samples in [0..3, 3..8] {
                let traced = survey.trace(&pixels, samples, &mut Quiet).unwrap();
                all.push(format!("{:?} {:?}", traced.sums, traced.marks));
            }
            all
        };
        assert_eq!(trace(&own), trace(&in_parts(&own)), "{name}");
    }
}

/// Gives up after so many questions, or watches the image grow.
struct Impatient(std::cell::Cell<u32>, bool);

impl Observer for Impatient {
    fn progress(&mut self, _done: u64, _total: u64) {}
    fn cancelled(&self) -> bool {
        self.0.set(self.0.get().saturating_sub(1));
        self.0.get() == 0
    }
    fn watches(&self) -> bool {
        self.1
    }
    fn image(&mut self, _so_far: &ImageSoFar<'_>) {}
}

#[test]
fn what_was_stopped_on_the_way_goes_on_to_the_same_bits() {
    let mut renderer = renderer();
    let (_, scene) = subjects().swap_remove(3);
    let mut own = settings(&scene, &[]);
    (own.schedule.tile_pixels, own.schedule.batch_samples) = (Some(60), Some(1));
    let whole = render(&mut renderer, &scene, &own);
    let parts = in_parts(&own);
    let watched = renderer.render_with(&scene, &parts, &mut Impatient(u32::MAX.into(), true)).unwrap();
    assert_eq!(differing(&whole.linear, &watched.linear), 0);
    let mut resumed = 0;
    for patience in [20, 60, 200] {
        let stopped = renderer.render_with(&scene, &parts, &mut Impatient(patience.into(), false)).unwrap();
        assert!(stopped.done < 1.0, "{patience}");
        let Some(state) = stopped.state else { continue };
        let rest = renderer.resume(&scene, &parts, state, &mut Quiet).unwrap();
        assert_eq!(differing(&whole.linear, &rest.linear), 0, "{patience}");
        resumed += 1;
    }
    assert!(resumed > 0);
}

/// The cases of long walks at every vector width and precision, and with each ray alone.
#[test]
fn long_walks_end_at_every_vector_width() {
    let cases = ["needles", "overlapping-boxes", "fan", "stacked-triangles", "hair-and-lights"];
    for width in ["128", "256", "512"] {
        for precision in ["robust", "f64", "fast"] {
            let out = Command::new(env!("CARGO_BIN_EXE_whitted"))
                .args(["stress", "--device", "cpu", "--precision", precision])
                .args(cases.iter().flat_map(|name| ["--only", name]))
                .env("LP_NATIVE_VECTOR_WIDTH", width)
                // Mesa 25's cache mixes widths.
                .env("MESA_SHADER_CACHE_DISABLE", "true")
                .output()
                .unwrap();
            let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
            assert!(out.status.success(), "{width} {precision}: {}{}", text(&out.stdout), text(&out.stderr));
        }
    }
}

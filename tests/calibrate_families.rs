//! Scenes drawn from families render, and a calibration on them runs to its end, goes on after an interruption, and
//! notices a bound that claims too much.

mod common;

use common::renderer;
use std::cell::Cell;
use std::rc::Rc;
use whitted::lab::calibrate::{Aim, Coverage, Judgement, Plan, SceneRecord, Store, Tally, Trials, choose};
use whitted::reference::oracle::Oracle;
use whitted::render::Observer;
use whitted::scene::procedural::families::Family;
use whitted::settings::Settings;

#[test]
fn twenty_draws_of_each_family_have_a_finite_picture() {
    for family in Family::ALL {
        let mut lit = 0;
        for number in 0..20 {
            let scene = family.scene(number, 5, [16, 12]).expect("a scene");
            // Deep glass takes the oracle long, and adds no new way to be infinite.
            let depth = scene.render.depth.min(4);
            let settings = Settings { samples: 1, depth, ..Settings::of(&scene) };
            let image = Oracle::new(&scene).render(&settings);
            assert_eq!(image.linear.len(), 16 * 12);
            assert!(image.linear.iter().all(|c| c.is_finite()), "{} {number}", family.name());
            lit += usize::from(image.linear.iter().any(|c| c.max_element() > 1e-5));
        }
        assert!(lit >= 18, "{}: only {lit} of 20 scenes show anything", family.name());
    }
}

/// Cancels everything from the scene at `stop` on.
struct Until {
    place: usize,
    stop: usize,
}

impl Observer for Until {
    fn progress(&mut self, _done: u64, _total: u64) {}

    fn cancelled(&self) -> bool {
        self.place >= self.stop
    }
}

fn plan() -> Plan {
    let trials = Trials {
        seed: 2026,
        width: 48,
        height: 36,
        seeds: 2,
        samples: vec![4, 16],
        errors: vec![0.03],
        times: Vec::new(),
        confidence: 0.95,
        truth_rays: 1e6,
    };
    Plan { files: Vec::new(), families: choose(&["all".to_owned()]).expect("families"), scenes: 1, trials }
}

/// All judgements of total bounds and kept errors, with every bound multiplied by `scale`.
fn judged(scenes: &[SceneRecord], scale: f64) -> Tally {
    let budget = scenes.iter().flat_map(|s| &s.budget);
    let budget = budget.filter_map(|b| Some(b.error.judge(scale * b.stated.total?)));
    let error =
        scenes.iter().flat_map(|s| &s.error).flat_map(|e| e.trials.iter().map(move |t| (e.target, t)));
    let error = error.filter(|(_, t)| t.met).map(|(target, t)| t.error.judge(scale * target));
    Tally::of(budget.chain(error).collect::<Vec<Judgement>>())
}

#[test]
fn a_calibration_resumes_is_complete_and_notices_a_false_bound() {
    let plan = plan();
    let mut renderer = renderer();
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("families.jsonl");
    let header = plan.header(&renderer);
    let mut measure = |stop: usize| {
        let mut store = Store::open(&path, &header).expect("a store");
        let begun = Rc::new(Cell::new(0));
        let count = begun.clone();
        let mut begin = move |place: usize, _of: usize, name: &str| -> Box<dyn Observer> {
            println!("{place} {name}");
            count.set(count.get() + 1);
            Box::new(Until { place, stop })
        };
        plan.measure(&mut renderer, &mut store, &mut begin).expect("measured");
        (begun.get(), plan.collect(header.clone(), &store))
    };
    // Interrupted in the third scene, the file holds two; the rest follows.
    let (begun, part) = measure(3);
    assert_eq!((begun, part.scenes.len(), part.is_complete()), (3, 2, false));
    assert!(part.markdown("whitted").contains("**Interrupted**: 2 of 11 scenes"));
    let (begun, all) = measure(usize::MAX);
    assert_eq!((begun, all.scenes.len(), all.is_complete()), (9, 11, true));
    assert_eq!(measure(usize::MAX).0, 0);

    // Other trials are another file's.
    let mut other = header.clone();
    other.trials.errors = vec![0.01];
    let refused = Store::open(&path, &other).expect_err("refused").to_string();
    assert!(refused.contains("--errors [0.03] there, [0.01] now"), "{refused}");

    for scene in &all.scenes {
        let name = &scene.family;
        assert_eq!(scene.failure, None, "{name}");
        assert_eq!((scene.budget.len(), scene.error.len(), scene.error[0].trials.len()), (4, 1, 2), "{name}");
        assert!(scene.truth.seeds >= 4 && scene.truth.error.is_finite(), "{name}");
        for b in &scene.budget {
            assert!(b.stated.total.is_some() && b.rays > 0 && b.plain_rays > 0 && b.error.square.is_finite());
            assert!(b.layer.all.of + b.layer.undecided == 48 * 36, "{name}: {:?}", b.layer);
        }
        let truth = &scene.truth;
        println!(
            "{name}: {:.1} s; truth {} x {} samples, depth {}, {:.1e} of {:.1e}, hidden {:.1e}; {}; error {}; gain {:?}",
            scene.seconds,
            truth.seeds,
            truth.samples,
            truth.depth,
            truth.error,
            truth.sought,
            truth.hidden,
            judged(std::slice::from_ref(scene), 1.0).decided,
            Coverage::of(scene.error[0].trials.iter().map(|t| t.met)),
            scene.error[0].gain(),
        );
        for b in &scene.budget {
            let [least, most] = b.error.range();
            println!(
                "    {} samples: {:.2e} stated, {least:.2e} to {most:.2e} true",
                b.samples,
                b.stated.total.unwrap_or(0.0)
            );
        }
    }

    let (markdown, html) = (all.markdown("whitted"), all.html("whitted").expect("plots"));
    for family in Family::ALL {
        assert!(markdown.contains(&format!("| {} |", family.name())) && html.contains(family.name()));
    }
    assert!(html.contains("<svg") && !html.contains("src=") && !html.contains("NaN"));

    let (tally, scaled) = (judged(&all.scenes, 1.0), judged(&all.scenes, 0.3));
    println!("{tally:?}; bounds times 0.3: {scaled:?}");
    let aim = Aim::at_least(0.95);
    assert!(tally.undecided <= 7, "{tally:?}");
    assert!(!aim.missed(tally.decided), "{}", aim.say(tally.decided));
    // The planted defect.
    assert!(aim.missed(scaled.decided), "{}", aim.say(scaled.decided));
}

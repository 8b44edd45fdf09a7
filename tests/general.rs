//! The specialised kernels' image is the general ones', bit for bit: on every scene, each feature that it lacks
//! switched on alone, and all together.

// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

mod common;

use common::{render, renderer, scenes, small};
use whitted::kernel::abi::Specialisation;
use whitted::kernel::defects::Defect;
use whitted::lab::receipt::differing;
use whitted::plan::{Limits, Plan, pack_for};
use whitted::reference::twin;
use whitted::scene::Scene;
use whitted::settings::forced_features::{Feature, ForcedFeatures};
use whitted::settings::{Schedule, Settings};

/// Settings with `forced_features` switched on.
fn with(settings: &Settings, forced_features: ForcedFeatures) -> Settings {
    let schedule = Schedule { forced_features, ..settings.schedule };
    Settings { schedule, ..settings.clone() }
}

/// A few pixels of few samples.
fn tiny(scene: &Scene) -> Settings {
    let settings = small(scene, 33, 2, 3);
    Settings { depth: settings.depth.clamp(3, 5), ..settings }
}

/// On the device, since kernels take long to prepare, in one test: each scene's own image is rendered once.
#[test]
fn general_kernels_change_no_bit() {
    let mut renderer = renderer();
    let limits = renderer.device().limits();
    // Scenes with fused kernels: of brute force, and of a hierarchy.
    let (mut fused_ways, mut alone) = ([0, 0], Vec::new());
    for (name, scene) in scenes() {
        let settings = tiny(&scene);
        let plan = |s: &Settings| Plan::new(&pack_for(&scene, s, &limits), s, &limits).unwrap();
        let own = render(&mut renderer, &scene, &settings);

        let all = render(&mut renderer, &scene, &with(&settings, ForcedFeatures::all()));
        assert_eq!(differing(&own.linear, &all.linear), 0, "{name}");
        assert_eq!(own.report.counters, all.report.counters, "{name}");
        let rays = |r: &whitted::report::RayInfo| (r.primary, r.reflection, r.refraction);
        assert_eq!(rays(&own.report.rays), rays(&all.report.rays), "{name}");

        // Kernels as for a long render, on top of all else that is specialised.
        let schedule = Schedule { fused: Some(true), ..settings.schedule };
        let long = Settings { schedule, ..settings.clone() };
        let Specialisation { fused, use_bvh, .. } = plan(&long).specialisation;
        if fused != 0 {
            fused_ways[use_bvh as usize] += 1;
            let fused = render(&mut renderer, &scene, &long);
            assert_eq!(differing(&own.linear, &fused.linear), 0, "{name}");
        }

        // Each feature alone, in the first of these scenes that lacks it; the twins do so in every scene.
        if !["cornell", "fence", "many_lights"].contains(&name.as_str()) {
            continue;
        }
        for feature in Feature::ALL {
            let general = with(&settings, ForcedFeatures::default().with(*feature));
            let (a, b) = (plan(&settings), plan(&general));
            let is_absent = a.specialisation != b.specialisation || a.last_depth != b.last_depth;
            if is_absent && !alone.contains(feature) {
                alone.push(*feature);
                let other = render(&mut renderer, &scene, &general);
                assert_eq!(differing(&own.linear, &other.linear), 0, "{name} with {feature}");
            }
        }
    }
    assert!(fused_ways[0] >= 3 && fused_ways[1] >= 1, "{fused_ways:?}");
    // Of these scenes none is without triangles, and none of these renders is long enough to be fused.
    let untried: Vec<_> = Feature::ALL.iter().filter(|f| !alone.contains(*f)).collect();
    assert_eq!(untried, [&Feature::Triangles, &Feature::SplitKernels]);
}

/// The image by the kernels' twins.
fn by_twins(scene: &Scene, settings: &Settings) -> Vec<[f32; 3]> {
    let packed = pack_for(scene, settings, &Limits::LAVAPIPE);
    let plan = Plan::new(&packed, settings, &Limits::LAVAPIPE).unwrap();
    twin::single::render(&packed, scene, settings, &plan).unwrap().0
}

#[test]
fn each_feature_alone_changes_no_bit_of_any_scene() {
    for (name, scene) in scenes() {
        let settings = tiny(&scene);
        let own = by_twins(&scene, &settings);
        for feature in Feature::ALL {
            let general = by_twins(&scene, &with(&settings, ForcedFeatures::default().with(*feature)));
            assert_eq!(differing(&own, &general), 0, "{name} with {feature}");
        }
    }
}

/// A scene of nothing but a sphere lacks what no scene of the repository does: triangles. An empty one lacks all.
#[test]
fn scenes_of_one_thing_and_of_none() {
    let text = "[camera]\nlook_from = [0, 0, 5]\nlook_at = [0, 0, 0]\nwidth = 20\nheight = 20\n\
                [render]\nbackground = [0.1, 0.2, 0.3]\nsamples = 2\n\
                [[light]]\nposition = [2, 3, 4]\nintensity = 30\n";
    let material = "[material.m]\ndiffuse = [0.5, 0.6, 0.7]\nsecondary = 0.5\nfresnel = \"exact\"\n";
    let sphere = "[[sphere]]\ncenter = [0, 0, 0]\nradius = 1\nmaterial = \"m\"\n";
    for text in [text.to_owned() + material + sphere, text.to_owned() + material] {
        let scene = Scene::parse(&text, std::path::Path::new("one.toml")).unwrap();
        let settings = Settings { depth: 3, ..Settings::of(&scene) };
        let own = by_twins(&scene, &settings);
        for forced in
            Feature::ALL.iter().map(|f| ForcedFeatures::default().with(*f)).chain([ForcedFeatures::all()])
        {
            assert_eq!(differing(&own, &by_twins(&scene, &with(&settings, forced))), 0, "{forced:?}");
        }
        let mut renderer = renderer();
        let device = render(&mut renderer, &scene, &with(&settings, ForcedFeatures::all()));
        assert_eq!(differing(&render(&mut renderer, &scene, &settings).linear, &device.linear), 0);
    }
}

/// A general kernel that is wrong in one detail is caught.
#[test]
fn a_planted_defect_is_noticed() {
    let (_, scene) = scenes().into_iter().find(|(name, _)| name == "cornell").unwrap();
    let settings = tiny(&scene);
    let mut renderer = renderer();
    let own = render(&mut renderer, &scene, &settings);
    let general = with(&settings, ForcedFeatures::all());
    renderer.plant(Defect::Nothing);
    let sound = render(&mut renderer, &scene, &general);
    assert_eq!(differing(&own.linear, &sound.linear), 0);
    // Another triangle test: t has other last bits.
    renderer.plant(Defect::MoellerTrumbore);
    let wrong = render(&mut renderer, &scene, &general);
    assert!(differing(&own.linear, &wrong.linear) > 0, "a defect in the general kernels is not noticed");
}

#[test]
fn passes_end_where_light_must() {
    let (_, scene) = scenes().into_iter().find(|(name, _)| name == "many_lights").unwrap();
    let settings = Settings { depth: 9, ..tiny(&scene) };
    let mut renderer = renderer();
    let own = render(&mut renderer, &scene, &settings);
    assert!(own.report.passes.iter().all(|p| p.depth <= 1 && p.name != "scan" && p.name != "spawn"));
    let deep = with(&settings, ForcedFeatures::default().with(Feature::Secondary));
    let general = render(&mut renderer, &scene, &deep);
    assert_eq!(general.report.passes.iter().map(|p| p.depth).max(), Some(9));
    assert_eq!(differing(&own.linear, &general.linear), 0);
}

/// Cornell's surfaces hand on 0.85 of a ray at most: 0.85^4 = 0.52 is traced at --cutoff 0.5, 0.85^5 = 0.44 is not.
#[test]
fn a_cutoff_ends_the_passes_and_changes_no_bit() {
    let (_, scene) = scenes().into_iter().find(|(name, _)| name == "cornell").unwrap();
    let mut settings = Settings { depth: 8, cutoff: 0.5, ..tiny(&scene) };
    let last = |s: &Settings| {
        Plan::new(&pack_for(&scene, s, &Limits::LAVAPIPE), s, &Limits::LAVAPIPE).unwrap().last_depth
    };
    assert_eq!((pack_for(&scene, &settings, &Limits::LAVAPIPE).max_depth.weight, last(&settings)), (0.85, 5));
    let own = by_twins(&scene, &settings);
    let general = by_twins(&scene, &with(&settings, ForcedFeatures::default().with(Feature::Secondary)));
    assert_eq!(differing(&own, &general), 0);
    settings.cutoff = 0.0;
    assert_eq!(last(&settings), 8);
}

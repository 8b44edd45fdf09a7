//! What is said of an image's error is true: budgets hold it, what was not traced adds no more than its certificate,
//! and errors that were asked for are kept. Each check is shown to fail when a part is left out.

mod common;

use common::{renderer, scenes};
use whitted::accuracy::pixel_sums::PixelSums;
use whitted::accuracy::promise::{BoundedImage, Request, Target};
use whitted::accuracy::radiance_bound::{RadianceLimit, radiance_limit};
use whitted::accuracy::sampling::Noise;
use whitted::accuracy::truncation::hidden;
use whitted::lab::calibrate::{Aim, Coverage, Judgement, Reference, Shown, reference};
use whitted::reference::oracle::Oracle;
use whitted::render::{Quiet, Renderer, Survey};
use whitted::scene::Scene;
use whitted::settings::{Precision, Schedule, Settings};

const CONFIDENCE: f64 = 0.95;

fn scene(name: &str) -> Scene {
    scenes().into_iter().find(|(n, _)| n == name).expect("a scene of the repository").1
}

fn sized(scene: &Scene, width: u32, height: u32) -> Settings {
    Settings { width, height, ..Settings::of(scene) }
}

fn known(r: &mut Renderer, scene: &Scene, settings: &Settings, target: Target) -> BoundedImage {
    let fixed = target == Target::Settings;
    let request =
        Request { confidence: CONFIDENCE, keep_depth: fixed, keep_precision: fixed, ..Request::to(target) };
    r.render_bounded(scene, settings, &request).expect("an image")
}

fn truth(r: &mut Renderer, scene: &Scene, settings: &Settings, depth: Option<u32>, error: f64) -> Reference {
    let found = reference(r, scene, settings, depth, (error, 4e6), &mut Quiet);
    found.expect("a truth").expect("not cancelled")
}

/// The true error of an image, RMSE.
fn error(truth: &Reference, image: &PixelSums) -> f64 {
    truth.measure(&Shown::of(&image.linear())).error()
}

/// True unless the error is more than `bound`.
fn holds(truth: &Reference, image: &PixelSums, bound: f64) -> bool {
    truth.measure(&Shown::of(&image.linear())).judge(bound) != Judgement::Broken
}

#[test]
fn the_true_error_lies_within_the_budget() {
    let mut r = renderer();
    let (mut kept, mut without_cut) = (Coverage::default(), Coverage::default());
    for (name, scene) in scenes() {
        let settings = Settings { samples: 16, replicates: 4, ..sized(&scene, 32, 24) };
        let to_the_end = truth(&mut r, &scene, &settings, None, 1e-3);
        for seed in 1..=4 {
            // Cut early, so that the truncation part has something to do.
            let settings = Settings { seed, depth: 2, ..settings.clone() };
            let image = known(&mut r, &scene, &settings, Target::Settings);
            let stated = image.report.error.clone().expect("a bound");
            let inside = holds(&to_the_end, &image.samples, stated.total);
            println!("{name}: {inside}, truth {:.1e}, {:.2e}", to_the_end.error(), stated.total);
            kept = kept.plus(Coverage::of([inside]));
            // The planted defect: a budget that says nothing was cut.
            let forgot = stated.total - stated.truncation;
            without_cut = without_cut.plus(Coverage::of([holds(&to_the_end, &image.samples, forgot)]));
        }
    }
    let aim = Aim::at_least(CONFIDENCE);
    println!("{}; without truncation {}", aim.say(kept), aim.say(without_cut));
    assert!(!aim.missed(kept), "{kept}");
    assert!(aim.missed(without_cut), "{without_cut}");
}

/// With confidence 95 % the sampling part holds the sampling error about that often.
#[test]
fn the_sampling_part_holds_as_often_as_it_says() {
    let mut r = renderer();
    // The earlier report scene, whose few pixels on edges make half a variance too little.
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/scenes/cornell.toml");
    let scene = Scene::load(file).expect("a scene");
    let settings = Settings { samples: 64, replicates: 4, depth: 2, ..sized(&scene, 32, 24) };
    let settings = Settings { precision: Precision::Double, ..settings };
    let same_depth = truth(&mut r, &scene, &settings, Some(2), 2e-4);
    let (mut kept, mut halved) = (Coverage::default(), Coverage::default());
    for seed in 1..=40 {
        let image = gathered(&mut r, &scene, &Settings { seed, ..settings.clone() });
        let error = error(&same_depth, &image);
        let noise = image.noise();
        // The planted defect: replicates of half the variance.
        let less = Noise {
            squares: noise.squares / 2.0,
            fourths: noise.fourths / 4.0,
            eighths: noise.eighths / 16.0,
            ..noise
        };
        let bound = |noise: &Noise| noise.bound(4, CONFIDENCE, 0.0).bound;
        kept = kept.plus(Coverage::of([error <= bound(&noise)]));
        halved = halved.plus(Coverage::of([error <= bound(&less)]));
    }
    println!("{kept}; halved {halved}; truth {:.1e}", same_depth.error());
    let aim = Aim::of(CONFIDENCE);
    assert!(!aim.missed(kept), "{kept}");
    assert!(aim.missed(halved), "{halved}");
}

/// All samples of the whole image.
fn gathered(r: &mut Renderer, scene: &Scene, settings: &Settings) -> PixelSums {
    let mut survey = Survey::new(r, scene, settings).expect("a survey");
    let places: Vec<u32> = (0..settings.width * settings.height).collect();
    let traced = survey.trace(&places, 0..settings.samples, &mut Quiet).expect("traced");
    let mut image = PixelSums::new(settings.width, settings.height, settings.replicates as usize);
    image.add(&places, settings.samples, &traced);
    image
}

/// Pixels whose deeper image is not within what the shallow one said was hidden: it only adds light, and no
/// more than that. 2^-16 is what sums in f32 and the throughput's fixed point may be off by.
fn broken(shallow: &PixelSums, deep: &PixelSums, limit: &RadianceLimit, keep_cut: bool) -> usize {
    let slack = 2f64.powi(-16);
    let bad = |at: &usize| {
        let (a, b) = (shallow.mean(*at), deep.mean(*at));
        let cut = if keep_cut { shallow.marks[*at].cut / f64::from(shallow.samples[*at]) } else { 0.0 };
        let lacks = hidden(a, cut, limit);
        (0..3).any(|c| {
            let more = b[c].clamp(0.0, 1.0) - a[c].clamp(0.0, 1.0);
            more < -slack || more > lacks[c] + slack
        })
    };
    (0..shallow.samples.len()).filter(bad).count()
}

#[test]
fn what_is_not_traced_adds_no_more_than_its_certificate() {
    let mut r = renderer();
    let (mut with_half, mut without_cut) = (0, 0);
    for (name, scene) in scenes() {
        let limit = radiance_limit(&scene);
        let settings = Settings { samples: 2, precision: Precision::Double, ..sized(&scene, 32, 24) };
        let mut at = |depth| gathered(&mut r, &scene, &Settings { depth, ..settings.clone() });
        let images: Vec<PixelSums> = [1, 2, 3, 4, 9].into_iter().map(&mut at).collect();
        let half = RadianceLimit { rgb: limit.rgb.map(|c| c / 2.0), unbounded: None };
        for (n, shallow) in images.iter().enumerate() {
            for deep in &images[n + 1..] {
                assert_eq!(broken(shallow, deep, &limit, true), 0, "{name}, depth {}", n + 1);
                with_half += broken(shallow, deep, &half, true);
                without_cut += broken(shallow, deep, &limit, false);
            }
        }
    }
    // The planted defects: half the radiance, and no throughput.
    println!("half the limit: {with_half} pixels; no cut: {without_cut} pixels");
    assert!(with_half > 0 && without_cut > with_half);
}

/// A budget traces some pixels with longer paths instead of taking every ray that was cut for the brightest there is.
/// What it states then holds what the same samples lack, and is the same however the work is cut.
#[test]
fn longer_paths_of_some_pixels_bound_what_all_lack() {
    let mut r = renderer();
    let (mut measured, mut halved, mut tighter) = (0, 0, Vec::new());
    for (name, scene) in scenes() {
        for (seed, depth) in [(1, 2), (2, 3), (3, 5)] {
            let settings = Settings { samples: 8, depth, seed, ..sized(&scene, 48, 36) };
            let image = known(&mut r, &scene, &settings, Target::Settings);
            let stated = image.report.error.clone().expect("a bound");
            let Some(certain) = stated.truncation_certain else { continue };
            let deep = gathered(&mut r, &scene, &Settings { depth: 48, cutoff: 1e-5, ..settings.clone() });
            let real = Shown::of(&image.samples.linear()).distance(&Shown::of(&deep.linear()));
            assert!(real <= stated.truncation, "{name} {depth}: {real} above {}", stated.truncation);
            assert!(stated.truncation < certain && stated.truncation_pixels >= Some(32), "{stated:?}");
            let parts = [stated.sampling, stated.truncation, stated.rounding.unwrap_or(0.0)];
            assert!((stated.total - parts.iter().sum::<f64>()).abs() < 1e-12);
            measured += 1;
            tighter.push(certain / stated.truncation);
            // The planted defect: half of what is stated.
            halved += u32::from(real > 0.5 * stated.truncation);
            let schedule = Schedule { tile_pixels: Some(97), ..settings.schedule };
            let again = known(&mut r, &scene, &Settings { schedule, ..settings }, Target::Settings);
            let again = again.report.error.expect("a bound");
            assert_eq!(again.truncation.to_bits(), stated.truncation.to_bits(), "{name} {depth}");
        }
    }
    tighter.sort_by(f64::total_cmp);
    assert!(measured >= 8 && halved > 0, "{measured} {halved}");
    assert!(tighter[tighter.len() / 2] > 1.5, "{tighter:?}");
}

#[test]
fn light_without_a_limit_is_called_unbounded_and_bounded_by_white() {
    let text = r#"
        [camera]
        look_from = [0, 2, 4]
        look_at = [0, 0, 0]
        fov = 40
        width = 32
        height = 24
        [[light]]
        position = [0.5, 0, 0]
        intensity = 0.3
        [[light]]
        position = [0, 3, 2]
        intensity = 4
        [material.floor]
        diffuse = [0.4, 0.5, 0.6]
        secondary = 0.5
        [material.ball]
        diffuse = [0.5, 0.5, 0.5]
        secondary = 0.6
        [[polygon]]
        vertices = [[-4, 0, -4], [-4, 0, 4], [4, 0, 4], [4, 0, -4]]
        material = "floor"
        [[sphere]]
        center = [-0.4, 0.6, 0]
        radius = 0.5
        material = "ball"
    "#;
    let scene = Scene::parse(text, "touch.toml").expect("a scene");
    let mut r = renderer();
    let settings = Settings { samples: 4, replicates: 4, depth: 1, ..Settings::of(&scene) };
    let stated = known(&mut r, &scene, &settings, Target::Settings).report.error.expect("a budget");
    let why = stated.truncation_unbounded_why.expect("a reason");
    assert!(!stated.truncation_bounded && why.contains("light"), "{why}");
    let at = |r: &mut Renderer, depth| {
        gathered(r, &scene, &Settings { depth, precision: Precision::Double, ..settings.clone() })
    };
    let (shallow, deep) = (at(&mut r, 1), at(&mut r, 8));
    assert_eq!(broken(&shallow, &deep, &radiance_limit(&scene), true), 0);
}

/// However few rays it gets, a truth compares its paths with longer ones: it would find errors where there are none.
#[test]
fn a_truth_of_few_rays_knows_what_longer_paths_add() {
    let mut r = renderer();
    let scene = scene("two_mirrors");
    let settings = sized(&scene, 24, 16);
    let found = reference(&mut r, &scene, &settings, None, (1e-3, 1.0), &mut Quiet);
    let short = found.expect("a truth").expect("not cancelled");
    assert!(short.hidden > 1e-3, "{}", short.hidden);
    assert!(truth(&mut r, &scene, &settings, None, 1e-3).hidden < 1e-3);
}

/// The oracle shares nothing with the kernels but the sampler.
#[test]
fn the_oracle_finds_the_same_truth_and_the_budget_holds_it() {
    let mut r = renderer();
    let scene = scene("cornell_glass");
    let settings = Settings { depth: 6, ..sized(&scene, 24, 16) };
    let found = truth(&mut r, &scene, &settings, Some(6), 1e-3);
    let oracle = Oracle::new(&scene).render(&Settings { samples: 256, ..settings.clone() });
    let pixels: Vec<[f32; 3]> = oracle.linear.iter().map(|c| c.to_array().map(|x| x as f32)).collect();
    // The noise of one sequence of 256 samples is no more than that of the truth's, which are shorter.
    let judge = Reference { pixels: Shown::of(&pixels), ..found.clone() };
    let apart = judge.pixels.distance(&found.pixels);
    assert!(apart < 4.0 * found.error(), "{apart} {}", found.error());
    for seed in 1..=6 {
        let settings = Settings { samples: 16, replicates: 4, depth: 3, seed, ..settings.clone() };
        let image = known(&mut r, &scene, &settings, Target::Settings);
        let stated = image.report.error.clone().expect("a bound");
        assert!(holds(&judge, &image.samples, stated.total), "{stated:?}");
    }
}

#[test]
fn errors_asked_for_are_kept() {
    let mut r = renderer();
    let target = 0.02;
    let (mut kept, mut of_a_quarter) = (Coverage::default(), Coverage::default());
    for name in ["cornell", "fence", "two_mirrors"] {
        let scene = scene(name);
        let settings = sized(&scene, 48, 36);
        let to_the_end = truth(&mut r, &scene, &settings, None, 1e-3);
        for seed in 1..=8 {
            let image = known(&mut r, &scene, &Settings { seed, ..settings.clone() }, Target::Error(target));
            let asked = &image.report.asked;
            assert_eq!(asked.met, Some(true), "{name}: {:?}", asked.unmet_why);
            let error = error(&to_the_end, &image.samples);
            println!("{name} {seed}: {error:.2e} of {target}, {:?}", image.report.settings);
            kept = kept.plus(Coverage::of([error <= target]));
            of_a_quarter = of_a_quarter.plus(Coverage::of([error <= target / 4.0]));
        }
    }
    let aim = Aim::at_least(CONFIDENCE);
    assert!(!aim.missed(kept), "{kept}");
    // The same check, had four times as much been promised.
    assert!(aim.missed(of_a_quarter), "{of_a_quarter}");
}

use super::*;
use crate::plan::{Limits, pack_for};
use crate::report::DepthInfo;
use crate::scene::Scene;
use crate::settings::Settings;
use crate::settings::forced_features::{Feature, ForcedFeatures};
use std::path::Path;

/// The plan of a scene's kernels at a depth, one for each stage, as the rows below were recorded.
fn plan(name: &str, depth: u32) -> Plan {
    planned(name, depth, ForcedFeatures::default().with(Feature::SplitKernels))
}

fn planned(name: &str, depth: u32, forced_features: ForcedFeatures) -> Plan {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name);
    let scene = Scene::load(&path).expect("a scene");
    let mut settings = Settings { depth, ..Settings::of(&scene) };
    settings.schedule.forced_features = forced_features;
    settings.schedule.fused = Some(true);
    Plan::new(&pack_for(&scene, &settings, &Limits::LAVAPIPE), &settings, &Limits::LAVAPIPE).expect("a plan")
}

/// Kernel, depth and microseconds.
type Row = (&'static str, u32, f64);

/// A report of so many launches a pass, with rays and shadow rays by depth.
fn report(rows: &[Row], launches: u64, rays: &[(u64, u64)]) -> Report {
    let mut report = Report::default();
    for (name, depth, micros) in rows {
        let seconds = micros * 1e-6;
        report.passes.push(PassInfo { name: (*name).into(), depth: *depth, launches, seconds, items: 0 });
    }
    report.rays.primary = rays[0].0;
    report.rays.by_depth = (1..)
        .zip(rays)
        .map(|(depth, &(traced, shadow))| DepthInfo::of(depth, [traced, 0, 0, shadow]))
        .collect();
    report.time.device = report.passes.iter().map(|p| p.seconds).sum();
    report.time.render = report.time.device;
    report
}

fn predicted(from: &Report, plan: &Plan, samples: u64, batches: u64) -> Prediction {
    let model = Model::of_report(from).expect("a model");
    model.predict(&Work { plan, pixels: 1000, samples, batches }).expect("a prediction")
}

/// `tests/scenes/cornell_glass.toml`, 300x200 pixels, 5 samples, depth 3: medians of 9 runs on lavapipe, 2 cores.
const GLASS: &[Row] = &[
    ("generate", 0, 10_000.0),
    ("intersect", 1, 36_100.0),
    ("shade", 1, 18_800.0),
    ("scan", 1, 305.0),
    ("spawn", 1, 12_200.0),
    ("shadow", 1, 35_900.0),
    ("gather", 1, 4_430.0),
    ("intersect", 2, 15_400.0),
    ("shade", 2, 8_120.0),
    ("scan", 2, 2_160.0),
    ("spawn", 2, 4_900.0),
    ("shadow", 2, 14_600.0),
    ("gather", 2, 2_300.0),
    ("intersect", 3, 7_190.0),
    ("shade", 3, 3_140.0),
    ("shadow", 3, 9_770.0),
    ("gather", 3, 1_490.0),
    ("resolve", 0, 3_150.0),
];
const GLASS_RAYS: &[(u64, u64)] = &[(300_000, 278_599), (151_032, 144_119), (72_842, 58_684)];

/// A sphereflake of 7,381 spheres under 3 lights, 512x512 pixels, 1 sample, depth 4, in the same way.
const FLAKE: &[Row] = &[
    ("generate", 0, 10_700.0),
    ("intersect", 1, 55_300.0),
    ("shade", 1, 15_200.0),
    ("scan", 1, 127.0),
    ("spawn", 1, 7_330.0),
    ("shadow", 1, 149_000.0),
    ("intersect", 2, 35_800.0),
    ("shade", 2, 4_610.0),
    ("scan", 2, 109.0),
    ("spawn", 2, 2_990.0),
    ("shadow", 2, 67_900.0),
    ("intersect", 3, 22_400.0),
    ("shade", 3, 2_420.0),
    ("scan", 3, 93.2),
    ("spawn", 3, 1_920.0),
    ("shadow", 3, 43_000.0),
    ("intersect", 4, 14_500.0),
    ("shade", 4, 1_320.0),
    ("shadow", 4, 27_500.0),
    ("resolve", 0, 3_680.0),
];
const FLAKE_RAYS: &[(u64, u64)] =
    &[(262_144, 708_953), (85_532, 118_815), (44_915, 61_488), (27_569, 37_400)];

fn within_a_fifth(what: &str, predicted: f64, measured: f64) {
    let ratio = predicted / measured;
    // What is asked of a prediction.
    assert!((0.8..1.2).contains(&ratio), "{what}: predicted {predicted}, measured {measured}");
}

/// Recorded with the rows above: 10 samples took 0.3445 s of device time in the room with glass, 2 samples 0.9474 s
/// in the flake.
#[test]
fn twice_the_samples() {
    let glass = report(GLASS, 3, GLASS_RAYS);
    let p = predicted(&glass, &plan("cornell_glass.toml", 3), 600_000, 5);
    within_a_fifth("glass, twice the samples", p.device, 0.3445);
    assert_eq!((p.by_depth[2].traced, p.by_depth[2].shadow), (145_684, 117_368));
    assert!(p.low < 0.3445 && 0.3445 < p.high && !p.by_depth.iter().any(|d| d.extrapolated), "{p:?}");
    let flake = report(FLAKE, 2, FLAKE_RAYS);
    let p = predicted(&flake, &plan("cornell.toml", 4), 524_288, 4);
    within_a_fifth("flake, twice the samples", p.device, 0.9474);
    assert!(p.low < 0.9474 && 0.9474 < p.high, "{p:?}");
}

/// One more depth took 0.1985 s in the room with glass and 0.5425 s in the flake.
#[test]
fn one_more_depth() {
    let glass = report(GLASS, 3, GLASS_RAYS);
    let p = predicted(&glass, &plan("cornell_glass.toml", 4), 300_000, 3);
    within_a_fifth("glass, one more depth", p.device, 0.1985);
    assert!(p.low < 0.1985 && 0.1985 < p.high, "{p:?}");
    let flake = report(FLAKE, 2, FLAKE_RAYS);
    let p = predicted(&flake, &plan("cornell.toml", 5), 262_144, 2);
    within_a_fifth("flake, one more depth", p.device, 0.5425);
    // 27,569 / 44,915 of them go on; 17,405 did.
    assert!(p.by_depth[4].extrapolated && p.by_depth[4].traced == 16_922, "{:?}", p.by_depth[4]);
    assert!(p.low < 0.5425 && 0.5425 < p.high, "{p:?}");
}

/// What the two tests above would not pass with: no starts of passes, samples or decay that mean nothing.
#[test]
fn the_same_again_is_the_same() {
    let flake = report(FLAKE, 2, FLAKE_RAYS);
    let p = predicted(&flake, &plan("cornell.toml", 4), 262_144, 2);
    assert!((p.device / flake.time.device - 1.0).abs() < 1e-12, "{p:?}");
    let short = predicted(&flake, &plan("cornell.toml", 3), 262_144, 2);
    assert!(short.device < 0.92 * p.device, "the last depth costs nothing: {short:?}");
}

/// Made rows: 1 us a start, 2 ns a ray, where 90 % of the rays end at each depth; then they are all gone.
#[test]
fn starts_and_rays_are_told_apart() {
    let kernels = ["intersect", "shade", "scan", "spawn", "shadow"];
    let rays = [100_000, 10_000, 1_000];
    let rows = |launches: f64, scale: f64, deepest: u32| -> Vec<Row> {
        let per_depth = (1..=deepest).flat_map(|d| kernels.map(|k| (k, d)));
        let mut rows: Vec<Row> = per_depth
            .filter(|(k, d)| *d < deepest || !["scan", "spawn"].contains(k))
            .map(|(k, d)| {
                (k, d, launches + scale * 2e-3 * f64::from(*rays.get(d as usize - 1).unwrap_or(&0)))
            })
            .collect();
        rows.extend([("generate", 0, launches + scale * 200.0), ("resolve", 0, launches + scale * 200.0)]);
        rows
    };
    let counts: Vec<(u64, u64)> = rays.iter().map(|r| (*r as u64, *r as u64)).collect();
    let from = report(&rows(4.0, 1.0, 5), 4, &counts);
    // Three times the samples in nine times the batches.
    let p = predicted(&from, &plan("cornell.toml", 5), 300_000, 36);
    let truth: f64 = rows(36.0, 3.0, 5).iter().map(|r| r.2 * 1e-6).sum();
    // `generate` and `resolve` have no empty dispatch to tell their starts by: 32 us each are missing of theirs.
    assert!((p.device - truth).abs() < 70e-6 && (p.device - truth).abs() > 1e-6, "{} {truth}", p.device);
    assert_eq!(p.by_depth[4].traced, 0);
    // Told the starts, nothing is missing.
    let starts = passes::all().map(|pass| (pass.kernel, 1e-6)).collect();
    let model = Model::new(&from, &starts).unwrap();
    let p = model
        .predict(&Work { plan: &plan("cornell.toml", 5), pixels: 1, samples: 300_000, batches: 36 })
        .unwrap();
    assert!((p.device - truth).abs() < 1e-12, "{} {truth}", p.device);
}

#[test]
fn what_cannot_be_known_is_said() {
    assert!(Model::of_report(&Report::default()).is_err());
    let shallow = report(&GLASS[..2], 3, &GLASS_RAYS[..1]);
    let model = Model::of_report(&shallow).unwrap();
    let deep = plan("cornell_glass.toml", 2);
    let error = model.predict(&Work { plan: &deep, pixels: 1, samples: 1, batches: 1 }).unwrap_err();
    assert!(error.to_string().contains("deeper"), "{error}");
    // Where light ends at depth 1, that is all there is to know.
    let ends = plan("many_lights.toml", 9);
    assert!(model.predict(&Work { plan: &ends, pixels: 1, samples: 1, batches: 1 }).is_ok());
}

/// Rows of split kernels say nothing of one for all stages.
#[test]
fn other_kernels_are_refused() {
    let model = Model::of_report(&report(GLASS, 3, GLASS_RAYS)).unwrap();
    let (split, fused) =
        (plan("cornell_glass.toml", 3), planned("cornell_glass.toml", 3, ForcedFeatures::default()));
    assert!(fused.specialisation.fused == 1 && split.specialisation.fused == 0);
    let work = |plan| Work { plan, pixels: 1, samples: 1, batches: 1 };
    let error = model.predict(&work(&fused)).unwrap_err().to_string();
    assert!(error.contains("`intersect`"), "{error}");
    assert!(model.predict(&work(&split)).is_ok());
    let of_fused = Model::of_report(&report(&[("fused_depth", 1, 1000.0)], 1, GLASS_RAYS)).unwrap();
    assert!(of_fused.predict(&work(&split)).is_err() && of_fused.predict(&work(&fused)).is_ok());
    // What other versions called kernels is refused as well, in place of a prediction without them.
    let error = Model::of_report(&report(&[("trace", 1, 1000.0)], 1, GLASS_RAYS)).unwrap_err().to_string();
    assert!(error.contains("`trace`"), "{error}");
}

/// A wide spread widens the range; no spread leaves the pace.
#[test]
fn the_range_is_the_spreads() {
    let flake = report(FLAKE, 2, FLAKE_RAYS);
    let kernels = plan("cornell.toml", 4);
    let work = Work { plan: &kernels, pixels: 1, samples: 262_144, batches: 2 };
    let range = |spread: f64| {
        let model = Model::new(&flake, &BTreeMap::new()).unwrap().with(spread, "a test".into());
        let p = model.predict(&work).unwrap();
        (p.low / p.render, p.high / p.render)
    };
    let near = |(a, b): (f64, f64), (c, d): (f64, f64)| (a - c).abs() < 1e-9 && (b - d).abs() < 1e-9;
    assert!(near(range(0.0), (0.9, 1.1)) && near(range(0.2), (0.6, 1.4)));
}

use super::*;
use crate::plan::{Limits, pack_for};
use crate::report::{DepthInfo, RayInfo};
use crate::scene::Scene;
use crate::settings::Settings;
use std::path::Path;

fn plan() -> Plan {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell.toml");
    let scene = Scene::load(&path).expect("a scene");
    let settings = Settings::of(&scene);
    Plan::new(&pack_for(&scene, &settings, &Limits::LAVAPIPE), &settings, &Limits::LAVAPIPE).expect("a plan")
}

/// A run of two depths that took `render` seconds.
fn run(render: f64) -> Report {
    let pass = |name: &str, depth, items, share: f64| PassInfo {
        name: name.into(),
        depth,
        launches: 2,
        seconds: share * render,
        items,
    };
    let mut report = Report {
        passes: vec![
            pass("intersect", 1, 1000, 0.5),
            pass("spawn", 1, 1000, 0.25),
            pass("intersect", 2, 400, 0.125),
            pass("intersect", 3, 0, 0.0625),
            pass("resolve", 0, 500, 0.0625),
        ],
        rays: RayInfo {
            primary: 1000,
            reflection: 400,
            by_depth: vec![DepthInfo::of(1, [1000, 0, 0, 0]), DepthInfo::of(2, [400, 400, 0, 0])],
            ..RayInfo::default()
        },
        ..Report::default()
    };
    (report.plan.tiles, report.plan.batches) = (1, 2);
    (report.time.render, report.time.device) = (render, render);
    report
}

fn profile(times: &[f64]) -> Profile {
    let runs: Vec<Report> = times.iter().map(|t| run(*t)).collect();
    let warm_up = TimeInfo { first_dispatch: 7.0, ..TimeInfo::default() };
    Profile::new(&runs, &warm_up, &plan(), Precision::Robust).expect("a profile")
}

#[test]
fn medians_are_told_and_one_late_run_changes_nothing() {
    let p = profile(&[4.0, 1.0, 3.0, 2.0, 100.0]);
    assert_eq!((p.profile.render.lower, p.profile.render.median, p.profile.render.upper), (2.0, 3.0, 4.0));
    assert_eq!((p.report.time.render, p.report.time.first_dispatch), (3.0, 7.0));
    assert_eq!((p.profile.passes[0].seconds.median, p.profile.passes[0].seconds.range()), (1.5, 1.0));
    assert_eq!(p.profile.passes[0].share, 0.5);
    assert!((p.profile.passes.iter().map(|r| r.share).sum::<f64>() - 1.0).abs() < 1e-12);
    assert_eq!(p.profile.rays_per_second, 1400.0 / 3.0);
    assert!(Profile::new(&[], &TimeInfo::default(), &plan(), Precision::Robust).is_none());
}

#[test]
fn bytes_follow_the_items_and_their_children() {
    use crate::kernel::abi::single::{Film, Hit, Ray, Surface};
    let p = profile(&[1.0]);
    let (ray, hit, surface) = (size_of::<Ray>(), size_of::<Hit>(), size_of::<Surface>());
    let bytes = |i: usize| p.profile.passes[i].bytes;
    assert_eq!(bytes(0), Some(1000 * (ray + hit) as u64));
    assert_eq!(bytes(1), Some((1000 * (ray + surface) + 400 * ray) as u64));
    assert_eq!(p.profile.passes[0].bytes_per_second, Some(1000.0 * (ray + hit) as f64 / 0.5));
    assert_eq!(bytes(3), None, "no rays, no bytes");
    // Two batches update each pixel's sum twice, and read each sample once.
    assert_eq!(bytes(4), Some((500 * 2 * 2 * size_of::<Film>() + 1000 * 12) as u64));
}

#[test]
fn the_json_is_a_report_with_quartiles() {
    let p = profile(&[2.0, 1.0, 3.0]);
    let text = serde_json::to_string(&p).unwrap();
    let report: Report = serde_json::from_str(&text).unwrap();
    assert_eq!((report.time.render, report.passes.len()), (2.0, 5));
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(json["profile"]["passes"][0]["seconds"]["median"], 1.0);
    assert_eq!(json["profile"]["repeats"], 3);
    assert_eq!(json["passes"][0]["name"], json["profile"]["passes"][0]["name"]);
}

#[test]
fn the_table_tells_all() {
    let text = text(&profile(&[2.0, 1.0, 3.0]));
    for word in ["intersect", "spawn", "no rays", "50.0 %", "1,000", "60", "3 runs", "first dispatch 7.00 s"]
    {
        assert!(text.contains(word), "{word} is missing:\n{text}");
    }
}

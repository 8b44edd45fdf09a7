use super::*;
use crate::report::{DepthInfo, LocalFrameInfo, RayInfo};

fn sample() -> Report {
    let mut report = Report::default();
    report.device.name = "llvmpipe (LLVM 15.0.6, 256 bits)".into();
    report.device.kind = "cpu".into();
    report.device.driver = "llvmpipe Mesa 22.3.6".into();
    report.device.api = "1.3.230".into();
    report.scene.file = "scenes/cornell.toml".into();
    (report.scene.triangles, report.scene.spheres, report.scene.lights) = (24, 2, 1);
    report.scene.local_frame = LocalFrameInfo { center: [0.0, 5.0, 0.5], scale_log2: -3 };
    let settings = &mut report.settings;
    (settings.width, settings.height, settings.samples, settings.depth) = (600, 500, 20, 4);
    (settings.sampler, settings.precision, settings.origin) =
        ("random".into(), "robust".into(), "bound".into());
    report.plan.features = vec!["triangles".into(), "spheres".into(), "mirror".into()];
    (report.plan.bytes, report.plan.tiles, report.plan.batches) = (123 << 19, 1, 2);
    let mut row = |name: &str, depth, launches, seconds, items| {
        report.passes.push(PassInfo { name: name.into(), depth, launches, seconds, items });
    };
    row("generate", 0, 2, 0.012, 6_000_000);
    for depth in 1..=4 {
        let live = 6_000_000 >> (2 * (depth - 1));
        row("intersect", depth, 2, live as f64 * 1e-7, live);
        row("shade", depth, 2, live as f64 * 2e-8, live);
        row("shadow", depth, 2, live as f64 * 5e-8, live * 9 / 10);
    }
    row("resolve", 0, 2, 0.0, 300_000);
    report.rays.by_depth = (1..=4)
        .map(|depth| {
            let traced = 6_000_000 >> (2 * (depth - 1));
            DepthInfo::of(depth, [traced, if depth > 1 { traced } else { 0 }, 0, traced * 9 / 10])
        })
        .collect();
    (report.rays.primary, report.rays.reflection, report.rays.shadow) = (6_000_000, 1_968_750, 7_171_875);
    report.time.wall = 3.3;
    report.time.first_dispatch = 0.81;
    report.time.build = 0.0034;
    report.time.scene = 0.00012;
    report.time.device = 1.36;
    report.time.render = 1.42;
    report.image.file = "cornell.png".into();
    report
}

#[test]
fn columns_line_up() {
    let text = passes(&sample());
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 1 + 14 + 1);
    // Right-aligned numbers end in the same place as their heading.
    for (heading, column) in [("dispatches", 2), ("seconds", 3)] {
        let end = lines[0].find(heading).unwrap() + heading.len();
        for line in &lines[1..] {
            assert_ne!(line.as_bytes()[end - 1], b' ', "column {column}: {line}");
            assert_eq!(line.as_bytes()[end], b' ', "column {column}: {line}");
        }
    }
    assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
}

#[test]
fn the_report_fits_a_screen_and_is_complete() {
    let text = report(&sample());
    assert!(text.lines().count() <= 40, "{}", text.lines().count());
    assert!(text.lines().all(|line| line.len() <= 120), "{text}");
    for part in ["llvmpipe (LLVM 15.0.6, 256 bits)", "24 triangles", "(0, 5, 0.5)", "61.5 MiB", "810 ms"] {
        assert!(text.contains(part), "{part} is not in\n{text}");
    }
}

#[test]
fn each_kind_of_ray_has_a_column_and_each_depth_a_row() {
    let rays_of = RayInfo::of(&[[1000, 0, 0, 900], [1500, 800, 700, 1234], [0, 0, 0, 0], [7, 7, 0, 0]]);
    let report = Report { rays: rays_of, ..Report::default() };
    let text = rays(&report);
    let lines: Vec<Vec<&str>> = text.lines().map(|line| line.split_whitespace().collect()).collect();
    assert_eq!(lines[1], ["1", "1,000", "0", "0", "900", "1,900"]);
    assert_eq!(lines[2], ["2", "0", "800", "700", "1,234", "2,734"]);
    assert_eq!(lines[3], ["all", "1,000", "800", "700", "2,134", "4,634"]);
    assert_eq!(lines.len(), 4);
}

#[test]
fn depths_without_rays_are_one_row() {
    let mut report = sample();
    for depth in 5..=200 {
        for name in ["intersect", "shade"] {
            report.passes.push(PassInfo { name: name.into(), depth, launches: 2, seconds: 1e-6, items: 0 });
        }
    }
    let text = passes(&report);
    assert_eq!(text.lines().count(), 1 + 14 + 2, "{text}");
    let row = text.lines().rev().nth(1).unwrap();
    assert!(row.starts_with("no rays") && row.contains("5-200") && row.contains("784"), "{row}");
}

#[test]
fn seconds_have_the_digits_that_count() {
    for (scale, want) in [(1e-6, "0.000001367"), (1.0, " 1.367 "), (1e6, " 1366688 ")] {
        let mut report = sample();
        report.passes.iter_mut().for_each(|p| p.seconds *= scale);
        let text = passes(&report);
        assert!(text.lines().last().unwrap().contains(want), "{want} is not in\n{text}");
    }
}

#[test]
fn an_empty_report_prints_without_odd_numbers() {
    let text = report(&Report::default());
    assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
}

#[test]
fn only_what_happened_is_warned_of() {
    let mut report = sample();
    assert!(warnings(&report).is_empty());
    report.counters.nan_rays = 2;
    report.counters.degenerate_triangles = 1;
    let [first, second] = &warnings(&report)[..] else { panic!("{:?}", warnings(&report)) };
    assert!(first.contains("1 triangle ") && second.contains("2 rays "), "{first} {second}");
}

#[test]
fn a_time_without_a_statement_says_so() {
    let mut report = sample();
    assert_eq!(error(&report), Vec::<String>::new());
    (report.asked.time, report.asked.met) = (Some(0.5), Some(true));
    assert_eq!(error(&report), ["error unknown: there was no time to learn it", "asked for 500 ms: kept"]);
    // What was not kept is told as the reason of the exit code.
    report.asked.met = Some(false);
    assert_eq!(error(&report), Vec::<String>::new());
}

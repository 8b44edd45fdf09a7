use super::*;
use crate::report::{DepthInfo, LocalFrameInfo};

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
            DepthInfo { depth, traced, shadow: traced * 9 / 10 }
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
fn numbers_are_short_and_readable() {
    let grouped_all = [0, 999, 1000, 12_345_678].map(grouped);
    assert_eq!(grouped_all, ["0", "999", "1,000", "12,345,678"]);
    assert_eq!([0.0, 999.0, 1234.0, 12.34e6, 5e9].map(short), ["0", "999", "1.23 k", "12.3 M", "5.00 G"]);
    assert_eq!(
        [0.0, 1.5, 0.25, 42e-6, 123.4].map(seconds),
        ["0.00 s", "1.50 s", "250 ms", "42.0 us", "123 s"]
    );
    assert_eq!((plural(1, "light"), plural(0, "light")), ("1 light".into(), "0 lights".into()));
}

#[test]
fn columns_line_up() {
    let text = passes(&sample());
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 1 + 14 + 1);
    // Right-aligned numbers end in the same place as their heading.
    for (heading, column) in [("launches", 2), ("seconds", 3)] {
        let end = lines[0].find(heading).unwrap() + heading.len();
        for line in &lines[1..] {
            assert_ne!(line.as_bytes()[end - 1], b' ', "column {column}: {line}");
            assert_eq!(line.as_bytes()[end], b' ', "column {column}: {line}");
        }
    }
    assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
}

#[test]
fn the_story_fits_a_screen_and_is_complete() {
    let text = report(&sample());
    assert!(text.lines().count() <= 40, "{}", text.lines().count());
    assert!(text.lines().all(|line| line.len() <= 120), "{text}");
    for part in [
        "llvmpipe (LLVM 15.0.6, 256 bits) (cpu)",
        "24 triangles, 2 spheres, 1 light; local = (world - (0, 5, 0.5)) * 2^-3",
        "61.5 MiB, 1 tile, 2 batches",
        "first dispatch 810 ms",
        "M rays/s of device time",
    ] {
        assert!(text.contains(part), "{part} is not in\n{text}");
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
    assert_eq!(
        warnings(&report),
        ["warning: 1 triangle without area dropped", "warning: 2 rays with a NaN or infinity"]
    );
}

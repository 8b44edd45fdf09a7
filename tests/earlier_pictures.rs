//! Pictures of earlier scenes stay what they were: bit for bit on the device and driver that they were
//! recorded on, and what the oracle sees on any.

// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

mod common;

use common::{render, renderer, small};
use std::path::Path;
use whitted::compare::metrics::compare;
use whitted::image::linear_sha256;
use whitted::reference::oracle::Oracle;
use whitted::scene::Scene;
use whitted::settings::Settings;

/// Scenes in `tests/scenes`, and the SHA-256 of the linear image at the scene's own settings.
const RECORDED: [(&str, &str); 2] = [
    ("cornell", "5eb35ed474d70c2213b030c35497f8d924eb850278ebd08f813feacbf5d6496e"),
    ("cornell_glass", "179bb97f60fba56c1f9a4336bd3508363d5c42d6f0091531f30de709671ba164"),
];
/// Where they were recorded.
const DEVICE: &str = "llvmpipe (LLVM 15.0.6, 256 bits)";
const DRIVER: &str = "llvmpipe Mesa 22.3.6 (LLVM 15.0.6)";
/// Mean absolute error in linear light: single pixels on an edge may show another object, and all others are
/// off by rounding.
const TOLERANCE: f64 = 1e-4;

fn load(name: &str) -> Scene {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes");
    Scene::load(folder.join(name).with_extension("toml")).unwrap()
}

#[test]
fn earlier_pictures_are_the_same() {
    let mut renderer = renderer();
    for (name, recorded) in RECORDED {
        let scene = load(name);
        let settings = small(&scene, 120, 4, 0);
        let found = render(&mut renderer, &scene, &settings);
        let truth = Oracle::new(&scene).render(&settings).linear;
        let off = compare(&found.linear, &truth).unwrap().mean_abs;
        assert!(off < TOLERANCE, "{name}: {off}");
        // A light that is a hundredth brighter would be noticed.
        let brighter = found.linear.iter().map(|c| c.map(|c| c * 1.01)).collect::<Vec<_>>();
        assert!(compare(&brighter, &truth).unwrap().mean_abs > TOLERANCE, "{name}");

        let device = &found.report.device;
        if (device.name.as_str(), device.driver.as_str()) == (DEVICE, DRIVER) {
            let whole = render(&mut renderer, &scene, &Settings::of(&scene));
            assert_eq!(linear_sha256(&whole.linear), recorded, "{name}");
        }
    }
}

//! The local frame: scenes of any scale at any position.

use super::case::{Case, Figure, Harness};
use crate::compare::metrics::{edge_length, mismatch_bound};
use crate::reference::oracle::Oracle;
use crate::render::RenderError;
use crate::scene::procedural::shapes::{moved, room};
use glam::DVec3;

/// Cases of this file.
pub const CASES: &[Case] = &[
    Case {
        name: "scale",
        does: "the room scaled by powers of two from 2^-60 to 2^60, light intensities with the square",
        stands_for: "absolute epsilons: POV-Ray's limits of 1e-10 and 1e7, a far plane at 1000, shadow acne at small scales",
        bound: "exact: scaling by a power of two does not round (numerics.md, Local frame)",
        run: scale,
    },
    Case {
        name: "offset",
        does: "the room moved by (10^k, -10^k/2, 10^k), k = 0..9",
        stands_for: "scenes in map or CAD coordinates whose edges break up far from the origin",
        bound: "M + 3 sqrt M + 3 pixels, M = 2 * edge length * 2^-52 10^k / footprint (numerics.md, Bounds in tests)",
        run: offset,
    },
];

fn scale(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let scene = room();
    let reference = h.picture(&scene)?.linear;
    let mut different = 0;
    let steps = [-60, -31, -7, -1, 1, 12, 37, 60];
    for k in steps {
        let scaled = h.picture(&moved(&scene, 2f64.powi(k), DVec3::ZERO))?.linear;
        different += scaled.iter().zip(&reference).filter(|(a, b)| a != b).count();
    }
    Ok(Figure::count(different, reference.len() * steps.len(), "pixels differ"))
}

fn offset(h: &mut Harness<'_>) -> Result<Figure, RenderError> {
    let scene = room();
    let reference = h.picture(&scene)?.linear;
    let settings = h.settings(&scene);
    let edges =
        edge_length(&Oracle::new(&scene).render(&settings).first_hit, settings.width as usize).unwrap_or(0);
    // One pixel at the far wall, metres.
    let footprint = 2.0 * 19.0 * (scene.camera.fov / 2.0).tan() / f64::from(settings.height);
    let mut worst = Figure::new(0.0, 1.0, "pixels changed by more than one code");
    for k in 0..=9 {
        let far = 10f64.powi(k);
        let image = h.picture(&moved(&scene, 1.0, DVec3::new(far, -far / 2.0, far)))?.linear;
        // NaN counts as different.
        let close = |a: f32, b: f32| (a - b).abs() <= 1.0 / 255.0;
        let off = |(a, b): (&[f32; 3], &[f32; 3])| !(0..3).all(|c| close(a[c], b[c]));
        let changed = image.iter().zip(&reference).filter(|p| off(*p)).count();
        // Each coordinate has an error of 2^-53 of its size; two of them meet at an edge.
        let bound = mismatch_bound(2f64.powi(-52) * far / footprint, edges, 1);
        worst = worst.worse(Figure::new(
            changed as f64,
            bound,
            format!("pixels changed by more than one code at 10^{k}"),
        ));
    }
    Ok(worst)
}

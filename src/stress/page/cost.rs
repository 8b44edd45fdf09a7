//! What each protection costs in device time: renders in turn, each divided by `robust` in its round.

use super::markdown::{number, table};
use super::{PageError, running};
use crate::defect::Defect;
use crate::generate::{displaced_sphere, frequency, sphereflake};
use crate::measure::stats::quartiles;
use crate::render::{Quiet, Renderer};
use crate::scene::Scene;
use crate::settings::{Precision, Settings};
use crate::stress::shapes::{empty, light, matte, mesh, mirror, polygon, room, sphere};
use crate::table::Align::{Left, Right};
use glam::DVec3;

/// Rounds after the warm-up, each with every variant once.
const ROUNDS: usize = 7;
/// Pixels on a side.
const SIDE: u32 = 192;

/// A way to render.
#[derive(Debug, Clone, Copy)]
struct Variant {
    name: &'static str,
    precision: Precision,
    planted: Option<Defect>,
}

const fn without(name: &'static str, defect: Defect) -> Variant {
    Variant { name, precision: Precision::Robust, planted: Some(defect) }
}

/// `robust` first: it is what the others are divided by.
const VARIANTS: [Variant; 11] = [
    Variant { name: "`robust`, all protections", precision: Precision::Robust, planted: None },
    Variant {
        name: "`fast`: no exact edges, hits not confined to boxes",
        precision: Precision::Fast,
        planted: None,
    },
    Variant { name: "`f64` throughout", precision: Precision::Double, planted: None },
    without("hits not confined to their boxes", Defect::Unconfined),
    without("Moeller and Trumbore's triangle test", Defect::MoellerTrumbore),
    without("the schoolbook quadratic for spheres", Defect::NaiveQuadratic),
    without("huge spheres in plain f32", Defect::NoWide),
    without("box tests without allowance", Defect::NarrowSlab),
    without("boxes without padding", Defect::TightBoxes),
    without("vectors normalised without scaling", Defect::BlindNormalise),
    without("samples added without compensation", Defect::NaiveSum),
];

/// Device seconds, by variant, then round.
type Times = Vec<Vec<f64>>;

/// The section's figures.
pub(super) struct Cost {
    scenes: Vec<(&'static str, Times)>,
    variants: Vec<Variant>,
}

fn flake() -> Scene {
    let radius = 1e6;
    let mut s = empty(vec![mirror(0.5, 0.1), matte([1.0, 0.75, 0.33], 0.1)]);
    s.spheres = sphereflake(2).into_iter().map(|(c, r)| sphere(c.to_array(), r, 0)).collect();
    s.spheres.push(sphere([0.0, 0.0, -0.5 - radius], radius, 1));
    s.lights = vec![light([4.0, 3.0, 2.0], 10.0), light([1.0, -4.0, 4.0], 10.0)];
    s.camera.look_from = DVec3::new(2.1, 1.3, 1.7);
    s.camera.up = DVec3::Z;
    s.render.depth = 4;
    s
}

fn rock() -> Scene {
    let mut s = empty(vec![mirror(0.3, 0.1), matte([0.8; 3], 0.1)]);
    let solid = displaced_sphere(frequency(5000), 0.5, 7);
    let faces: Vec<[u32; 3]> = solid.faces.iter().map(|f| f.vertices).collect();
    s.meshes = vec![mesh(solid.vertices, &faces, 0)];
    s.polygons =
        vec![polygon(&[[-4.0, -1.5, 4.0], [4.0, -1.5, 4.0], [4.0, -1.5, -4.0], [-4.0, -1.5, -4.0]], 1)];
    s.lights = vec![light([2.0, 4.0, 3.0], 20.0)];
    s.camera.look_from = DVec3::new(0.0, 1.0, 4.0);
    s.render.depth = 4;
    s
}

pub(super) fn measure(renderer: &mut Renderer) -> Result<Cost, PageError> {
    let double = renderer.device().has_double();
    let variants: Vec<Variant> =
        VARIANTS.into_iter().filter(|v| double || v.precision != Precision::Double).collect();
    let mut scenes = Vec::new();
    for (name, scene) in [("room", room()), ("flake", flake()), ("mesh", rock())] {
        let mut times: Times = vec![Vec::new(); variants.len()];
        for round in 0..=ROUNDS {
            for (variant, times) in variants.iter().zip(&mut times) {
                running()?;
                let settings = Settings {
                    width: SIDE,
                    height: SIDE,
                    samples: 2,
                    precision: variant.precision,
                    planted: variant.planted,
                    ..Settings::of(&scene)
                };
                let report = renderer.render(&scene, &settings, &mut Quiet)?.report;
                if round > 0 {
                    times.push(report.time.device);
                }
            }
        }
        scenes.push((name, times));
    }
    Ok(Cost { scenes, variants })
}

/// Each round's time over that of the same round's `base`.
fn ratios(times: &[f64], base: &[f64]) -> Vec<f64> {
    times.iter().zip(base).map(|(t, b)| t / b).collect()
}

/// Median and quartiles: `1.25 (1.20-1.31)`.
fn cell(ratios: &[f64]) -> String {
    quartiles(ratios)
        .map_or("-".into(), |q| format!("{} ({}-{})", number(q.median), number(q.lower), number(q.upper)))
}

impl Cost {
    pub(super) fn text(&self, kind: &str) -> String {
        let rows: Vec<[String; 4]> = self
            .variants
            .iter()
            .enumerate()
            .map(|(i, variant)| {
                let of = |scene: usize| {
                    let times: &Times = &self.scenes[scene].1;
                    if i == 0 { spread(&times[0]) } else { cell(&ratios(&times[i], &times[0])) }
                };
                [variant.name.to_owned(), of(0), of(1), of(2)]
            })
            .collect();
        let table = table(
            &[
                ("device time over `robust`", Left),
                ("room", Right),
                ("flake on a planet", Right),
                ("mesh", Right),
            ],
            &rows,
        );
        let caution = if kind == "cpu" {
            "**This device is a CPU driver: the ratios are its own and say nothing of a GPU**, where f64 alone costs many \
             times\nf32.\n\n"
        } else {
            ""
        };
        format!(
            "{caution}Device time (timestamps around every pass) of one render over that of `robust` in the same round; \
             median and, in brackets, the\ninterquartile range of {ROUNDS} rounds in which every variant runs once, after \
             a round of warm-up. Below 1 the protection costs time.\nThe first row has no ratio: it shows the spread of \
             `robust` itself, each run over its median. A difference inside the brackets is\nnone. The room is that of \
             above; the flake has 91 mirrors above a sphere of radius 10^6 m, the mesh 5,120 triangles. The room and\nthe \
             mesh have no huge sphere, so there *huge spheres in plain f32* is the same work again, and shows the noise.\n\n{table}"
        )
    }
}

/// A variant over its own median.
fn spread(times: &[f64]) -> String {
    quartiles(times).map_or("-".into(), |q| cell(&times.iter().map(|t| t / q.median).collect::<Vec<_>>()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_round_cancels_out_of_the_ratio() {
        let base = [1.0, 1.0, 10.0, 1.0, 1.0];
        let times = [2.0, 2.0, 20.0, 2.0, 2.0];
        assert_eq!(cell(&ratios(&times, &base)), "2 (2-2)");
        assert_eq!(spread(&base), "1 (1-1)");
    }

    #[test]
    fn the_first_variant_is_what_the_rest_are_divided_by() {
        assert_eq!((VARIANTS[0].precision, VARIANTS[0].planted), (Precision::Robust, None));
        let mut planted: Vec<_> = VARIANTS.iter().filter_map(|v| v.planted).collect();
        planted.dedup();
        assert_eq!(planted.len(), 8);
    }

    #[test]
    fn the_scenes_hold_what_the_page_says() {
        assert_eq!((flake().spheres.len(), rock().meshes[0].faces.len()), (92, 5120));
    }
}

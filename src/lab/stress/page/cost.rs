//! What each protection costs in device time: renders in turn, each divided by the run of `robust` just
//! before it.

use super::{PageError, Stop, running};
use crate::lab::markdown::table;
use crate::render::Renderer;
use crate::report::table::Align::{Left, Right};
use crate::scene::Scene;
use crate::scene::procedural::shapes::{empty, light, matte, mesh, mirror, polygon, room, sphere};
use crate::scene::procedural::{displaced_sphere, frequency, sphereflake};
use crate::settings::defect::Defect;
use crate::settings::{Precision, Settings};
use crate::stats::quartiles;
use glam::DVec3;

/// Rounds after the warm-up, each with every variant once.
const ROUNDS: usize = 11;
/// Pixels on a side.
const SIDE: u32 = 160;

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

/// What the others are divided by.
const ROBUST: Variant =
    Variant { name: "`robust` again: the noise", precision: Precision::Robust, planted: None };

/// The noise first: it is what the others are held against.
const VARIANTS: [Variant; 11] = [
    ROBUST,
    Variant {
        name: "`fast`: no exact edges, no confinement, huge spheres in f32",
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

/// Device time over that of `robust` just before, by variant, then round.
type Ratios = Vec<Vec<f64>>;

/// The section's figures.
pub(super) struct Cost {
    scenes: Vec<Ratios>,
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

pub(super) fn measure(renderer: &mut Renderer, stop: Stop<'_>) -> Result<Cost, PageError> {
    let double = renderer.device().has_double();
    let variants: Vec<Variant> =
        VARIANTS.into_iter().filter(|v| double || v.precision != Precision::Double).collect();
    let mut scenes = Vec::new();
    for scene in [room(), flake(), rock()] {
        let mut seconds = |variant: &Variant| {
            running(stop)?;
            let settings = Settings {
                width: SIDE,
                height: SIDE,
                samples: 2,
                precision: variant.precision,
                planted: variant.planted,
                ..Settings::of(&scene)
            };
            Ok::<_, PageError>(renderer.render(&scene, &settings)?.report.time.device)
        };
        let mut ratios: Ratios = vec![Vec::new(); variants.len()];
        for variant in &variants {
            seconds(variant)?;
        }
        for _ in 0..ROUNDS {
            for (variant, ratios) in variants.iter().zip(&mut ratios) {
                let base = seconds(&ROBUST)?;
                ratios.push(seconds(variant)? / base);
            }
        }
        scenes.push(ratios);
    }
    Ok(Cost { scenes, variants })
}

/// Median and quartiles, bold where the middle half stands out of the noise: `**1.25** (1.20-1.31)`.
/// The noise may fall either way, so it is as wide above 1 as below.
fn cell(ratios: &[f64], noise: &[f64]) -> String {
    let (Some(q), Some(n)) = (quartiles(ratios), quartiles(noise)) else { return "-".into() };
    let reach = n.upper.max(1.0 / n.lower);
    let apart = q.lower > reach || q.upper < 1.0 / reach;
    let mark = if apart { "**" } else { "" };
    format!("{mark}{}{mark} ({}-{})", ratio(q.median), ratio(q.lower), ratio(q.upper))
}

fn ratio(x: f64) -> String {
    format!("{x:.2}")
}

impl Cost {
    pub(super) fn text(&self, kind: &str) -> String {
        let cells = self.variants.iter().enumerate().map(|(i, variant)| {
            let of = |scene: usize| self.scenes.get(scene).map_or("-".into(), |s| cell(&s[i], &s[0]));
            [variant.name.to_owned(), of(0), of(1), of(2)]
        });
        let rows: Vec<[String; 4]> = cells.collect();
        let columns =
            [("over `robust`", Left), ("room", Right), ("flake on a planet", Right), ("mesh", Right)];
        let caution = if kind == "cpu" {
            "**This device is a CPU driver: the ratios are its own and say nothing of a GPU**, on most of which f64 costs \
             many times f32.\n\n"
        } else {
            ""
        };
        format!(
            "{caution}Device time (timestamps around every pass) of a render over that of `robust` just before it; median \
             and, in brackets, lower and upper\nquartile of {ROUNDS} rounds in which every variant runs once, after a \
             warm-up. Below 1 the protection costs time. **Bold** where the middle\nhalf of the rounds stands out of \
             the noise, which is the first row, the same work again, taken as wide above 1 as below; a figure\nthat is \
             not bold is not told from it. The room is that of above without the sheet, the flake has 91 mirrors above a sphere of radius \
             10^6 m, the\nmesh 5,120 triangles. Without a protection an image may be wrong; only its time is shown here.\n\n{}",
            table(&columns, &rows)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_stands_out_of_the_noise_is_bold() {
        let noise = [0.9, 1.0, 1.1, 0.95, 1.05];
        assert_eq!(cell(&[1.0, 1.1, 1.2], &noise), "1.10 (1.05-1.15)");
        assert_eq!(cell(&[1.3, 1.4, 1.5], &noise), "**1.40** (1.35-1.45)");
        assert_eq!(cell(&[0.3, 0.4, 0.5], &noise), "**0.40** (0.35-0.45)");
        // Noise that happened to fall to one side is noise on the other side too.
        assert_eq!(cell(&[1.05, 1.05, 1.05], &[0.8, 0.8, 0.8]), "1.05 (1.05-1.05)");
        // One late round does not make a protection dear.
        assert_eq!(cell(&[1.0, 1.0, 1.0, 1.0, 9.0], &noise), "1.00 (1.00-1.00)");
    }

    #[test]
    fn the_first_variant_is_the_noise() {
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

//! What protections cost in device time: renders in turn, each divided by the run of the first
//! variant just before it. The page compares the precisions; `benches/protections.rs` leaves out
//! single protections by planted mistakes.

use super::{PageError, Stop, running};
use crate::lab::markdown::table;
use crate::render::Renderer;
use crate::report::table::Align::{Left, Right};
use crate::scene::Scene;
use crate::scene::procedural::shapes::{empty, light, matte, mesh, mirror, polygon, room, sphere};
use crate::scene::procedural::{displaced_sphere, frequency, sphereflake};
use crate::settings::{Precision, Settings};
use crate::stats::quartiles;
use glam::DVec3;

/// Rounds after the warm-up, each with every variant once.
const ROUNDS: usize = 11;
/// Pixels on a side.
const SIDE: u32 = 160;

/// A way to render.
#[derive(Debug, Clone, Copy)]
pub struct Variant {
    /// First cell of its row.
    pub name: &'static str,
    /// Arithmetic of the kernels.
    pub precision: Precision,
    /// Called before each of its renders.
    pub prepare: fn(&mut Renderer),
}

const fn plain(name: &'static str, precision: Precision) -> Variant {
    Variant { name, precision, prepare: |_| () }
}

/// The variants of the page.
pub(super) const PRECISIONS: [Variant; 3] = [
    plain("`robust` again (noise)", Precision::Robust),
    plain("`fast`: no exact edge tests, hits not confined to boxes, huge spheres in f32", Precision::Fast),
    plain("`f64`", Precision::Double),
];

/// Device time over that of the first variant just before, by variant, then round.
type Ratios = Vec<Vec<f64>>;

/// The section's figures.
pub struct Cost {
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

/// Measures `variants` on three scenes. The first is what the others are divided by, and, measured
/// against itself, the noise. Double precision is left out where the device has none.
///
/// # Errors
/// If the device fails, or `stop` says so.
pub fn measure(renderer: &mut Renderer, variants: &[Variant], stop: Stop<'_>) -> Result<Cost, PageError> {
    let double = renderer.device().has_double();
    let variants: Vec<Variant> =
        variants.iter().copied().filter(|v| double || v.precision != Precision::Double).collect();
    let mut scenes = Vec::new();
    for scene in [room(), flake(), rock()] {
        let mut seconds = |variant: &Variant| {
            running(stop)?;
            (variant.prepare)(renderer);
            let settings = Settings {
                width: SIDE,
                height: SIDE,
                samples: 2,
                precision: variant.precision,
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
                let base = seconds(&variants[0])?;
                ratios.push(seconds(variant)? / base);
            }
        }
        scenes.push(ratios);
    }
    Ok(Cost { scenes, variants })
}

/// Median and quartiles, bold where the middle half stands out of the noise: `**1.25**
/// (1.20-1.31)`. The noise may fall either way, so it is as wide above 1 as below.
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
    /// As Markdown; `kind` of the device as in `DeviceInfo`.
    pub fn text(&self, kind: &str) -> String {
        let cells = self.variants.iter().enumerate().map(|(i, variant)| {
            let of = |scene: usize| self.scenes.get(scene).map_or("-".into(), |s| cell(&s[i], &s[0]));
            [variant.name.to_owned(), of(0), of(1), of(2)]
        });
        let rows: Vec<[String; 4]> = cells.collect();
        let columns = [
            ("device time / `robust`", Left),
            ("room", Right),
            ("flake on a planet", Right),
            ("mesh", Right),
        ];
        let caution = if kind == "cpu" {
            "**This device is a CPU driver: the ratios say nothing about a GPU**, on most of which f64 costs many times \
             f32.\n\n"
        } else {
            ""
        };
        format!(
            "{caution}Device time (timestamps around every pass) of a render divided by that of a `robust` render just before \
             it: median and quartiles of\n{ROUNDS} rounds, each with every variant once, after a warm-up. **Bold** marks \
             ratios whose interquartile range lies outside the noise,\nwhich is the first row (`robust` against itself), \
             taken symmetrically about 1. The room is the one above without the sheet; the flake has\n91 mirrors above a \
             sphere of radius 10^6 m; the mesh has 5,120 triangles. A faster variant may render a wrong image; only time is \
             compared\nhere.\n\n{}",
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
        assert_eq!(PRECISIONS[0].precision, Precision::Robust);
        let name = PRECISIONS[0].name;
        assert!(PRECISIONS[1..].iter().all(|v| v.precision != Precision::Robust), "{name}");
    }

    #[test]
    fn the_scenes_hold_what_the_page_says() {
        assert_eq!((flake().spheres.len(), rock().meshes[0].faces.len()), (92, 5120));
    }
}

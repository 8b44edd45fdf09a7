//! Error against a fixed epsilon: the room with secondary rays moved along themselves by 1e-9 to 1
//! m, compared with the ray offset derived from the rounding of the hit point.

use super::{PageError, Stop, running};
use crate::compare::metrics::{Metrics, Rgb, compare};
use crate::image::code8;
use crate::lab::markdown::{number, percent, table};
use crate::lab::plot::{Axis, Chart, Legend, Look, Scale, Series};
use crate::lab::probe::ProbeRay;
use crate::lab::stress::case::Random;
use crate::prepare::local_frame::LocalFrame;
use crate::reference::oracle::Oracle;
use crate::render::Renderer;
use crate::report::table::Align::{Left, Right};
use crate::scene::Scene;
use crate::scene::procedural::shapes::{polygon, room};
use crate::settings::sampler::Sampler;
use crate::settings::{Origin, Precision, Settings};
use crate::stats::median;
use glam::DVec3;

/// Pixels on a side.
const SIDE: u32 = 200;
/// Samples per pixel, the oracle's own.
const SAMPLES: u32 = 4;
/// The report's choice, metres.
const REPORTS: f64 = 0.1;
/// 8-bit codes that rounding alone does not change: it may flip one.
const CODES: u8 = 2;

/// One setting, judged.
#[derive(Debug, Clone)]
pub(super) struct Point {
    pub origin: Origin,
    /// All light.
    pub full: Metrics,
    /// Pixels with one channel too dark by [`CODES`], where only shadow rays leave surfaces.
    pub dark: u64,
    /// The same, too light.
    pub light: u64,
}

/// The section's figures.
pub(super) struct Epsilon {
    pub points: Vec<Point>,
    /// Median length of the derived offset, metres.
    pub offset: f64,
    /// Side of the room, metres.
    pub room: f64,
    pixels: u64,
}

/// The room, and a sheet that leans: one edge lies on the floor, the other 1.2 m above it, toward
/// the eye. Its shadow has contact, which solid things lose to no epsilon smaller than themselves.
fn scene() -> Scene {
    let mut s = room();
    s.polygons.push(polygon(&[[0.2, -5.0, 2.0], [2.2, -5.0, 2.0], [2.2, -3.8, 4.0], [0.2, -3.8, 4.0]], 2));
    s
}

/// 1e-9 to 1, two a decade.
fn epsilons() -> impl Iterator<Item = f64> {
    // Written and read back, so that 0.1 is 0.1.
    (-9..=0).flat_map(|e| [format!("1e{e}"), format!("3.16e{e}")]).filter_map(|t| t.parse().ok()).take(19)
}

/// Pixels too dark and too light in any channel, by at least [`CODES`].
fn dark_and_light<A: Rgb, B: Rgb>(image: &[A], truth: &[B]) -> (u64, u64) {
    let codes = |p: [f64; 3]| p.map(|x| code8(x as f32));
    let (mut dark, mut light) = (0, 0);
    for (a, b) in image.iter().zip(truth) {
        let (a, b) = (codes(a.rgb()), codes(b.rgb()));
        dark += u64::from((0..3).any(|c| b[c].saturating_sub(a[c]) >= CODES));
        light += u64::from((0..3).any(|c| a[c].saturating_sub(b[c]) >= CODES));
    }
    (dark, light)
}

pub(super) fn measure(
    renderer: &mut Renderer,
    precision: Precision,
    stop: Stop<'_>,
) -> Result<Epsilon, PageError> {
    let scene = scene();
    // Independent samples, like those of the cases on the same page.
    let sampler = Sampler::Random;
    let own = Settings::of(&scene);
    let base = Settings { width: SIDE, height: SIDE, samples: SAMPLES, sampler, precision, ..own };
    let oracle = Oracle::new(&scene);
    let direct = Settings { depth: 1, ..base.clone() };
    let (truth, truth_direct) = (oracle.render(&base).linear, oracle.render(&direct).linear);
    let mut points = Vec::new();
    for origin in epsilons().map(Origin::Fixed).chain([Origin::Bound]) {
        running(stop)?;
        let mut draw = |settings: &Settings| {
            renderer.render(&scene, &Settings { origin, ..settings.clone() }).map(|r| r.linear)
        };
        let full = compare(&draw(&base)?, &truth).map_err(|e| PageError::Figure(e.to_string()))?;
        let (dark, light) = dark_and_light(&draw(&direct)?, &truth_direct);
        points.push(Point { origin, full, dark, light });
    }
    let frame = LocalFrame::of_whole(&scene);
    let mut random = Random::new(0x0ff5e7);
    let eye = frame.point(scene.camera.look_from);
    let rays: Vec<ProbeRay> = (0..4096)
        .map(|_| {
            let target =
                DVec3::new(random.range(-5.0, 5.0), random.range(-5.0, 5.0), random.range(-5.0, 5.0));
            ProbeRay::new(eye, (frame.point(target) - eye).normalize())
        })
        .collect();
    let hits = renderer.probe(&scene, &base, &rays)?.hits;
    let lengths: Vec<f64> = hits.into_iter().flatten().map(|h| h.offset.length()).collect();
    Ok(Epsilon {
        points,
        offset: median(&lengths).unwrap_or(0.0) * 2f64.powi(-frame.scale_log2),
        room: 10.0,
        pixels: u64::from(SIDE * SIDE),
    })
}

impl Epsilon {
    fn bound(&self) -> Option<&Point> {
        self.points.iter().find(|p| p.origin == Origin::Bound)
    }

    fn fixed(&self) -> impl Iterator<Item = (f64, &Point)> {
        self.points.iter().filter_map(|p| match p.origin {
            Origin::Fixed(x) => Some((x, p)),
            Origin::Bound => None,
        })
    }

    pub(super) fn text(&self) -> String {
        let rows: Vec<[String; 7]> = self
            .points
            .iter()
            .map(|p| {
                let name = match p.origin {
                    Origin::Bound => "**error bound**".into(),
                    Origin::Fixed(x) if x == REPORTS => format!("**{}**, the report's value", scientific(x)),
                    Origin::Fixed(x) => scientific(x),
                };
                let m = &p.full;
                [
                    name,
                    number(m.rmse),
                    number(m.max_abs),
                    m.code_max.to_string(),
                    percent(m.code_differing_pixels, self.pixels),
                    percent(p.dark, self.pixels),
                    percent(p.light, self.pixels),
                ]
            })
            .collect();
        let table = table(
            &[
                ("ray origin, metres along the ray", Left),
                ("RMSE", Right),
                ("largest error", Right),
                ("8-bit codes", Right),
                ("pixels changed", Right),
                ("too dark, direct light", Right),
                ("too light, direct light", Right),
            ],
            &rows,
        );
        format!("{}\n{table}\n{}", self.method(), self.reading())
    }

    fn method(&self) -> String {
        format!(
            "A room of {} m with a mirror wall, a glass sphere, a mirror sphere, a box, and a sheet that touches the floor \
             with one edge:\n{SIDE}x{SIDE} pixels, {SAMPLES} samples per pixel, depth 4. The f64 oracle renders the same \
             sample positions, so the images differ only in the\norigins of secondary and shadow rays, and in \
             rounding. Errors are in linear light clamped to [0, 1]; a pixel has *changed* if one of its\n8-bit codes \
             has. The last two columns show the same room at depth 1, where only shadow rays leave a surface: a pixel \
             that is too\ndark by {CODES} codes or more has a shadow ray that was wrongly blocked, one that is too light \
             has a shadow ray that missed its blocker.\n",
            number(self.room)
        )
    }

    /// Conclusions that follow from the figures.
    fn reading(&self) -> String {
        let Some(bound) = self.bound() else { return String::new() };
        let share = |count: u64| percent(count, self.pixels);
        let Some((best, least)) = self.fixed().min_by(|a, b| a.1.full.rmse.total_cmp(&b.1.full.rmse)) else {
            return String::new();
        };
        let mut text = String::new();
        if let Some((x, worst)) = self.fixed().filter(|f| f.0 <= best).max_by_key(|f| f.1.dark) {
            text += &format!(
                "- **Left branch: shadow acne.** If epsilon is smaller than the rounding error of the hit point, a ray \
                 starts on the wrong side of its own\n  surface and hits it: lit points are in shadow, and a mirror \
                 reflects itself. Up to {} of the pixels are too dark in direct light (at {} m),\n  {} too light.\n",
                share(worst.dark),
                scientific(x),
                share(worst.light),
            );
        }
        if let Some((x, worst)) = self.fixed().filter(|f| f.0 >= best).max_by_key(|f| f.1.light) {
            text += &format!(
                "- **Right branch: light leaks.** A ray starts beyond an object that it should hit. Where the sheet is closer to \
                 the floor than epsilon,\n  shadow rays start behind it, and its shadow is detached: up to {} of the pixels \
                 are too light in direct light (at {} m), {} too dark.\n  In mirrors and glass, rays start at a displaced \
                 point or on the wrong side of the sphere.\n",
                share(worst.light),
                scientific(x),
                share(worst.dark),
            );
        }
        text += &format!(
            "- **The best epsilon** is {} m, with an RMSE of {} and {} of the pixels changed. It is different for every \
             scene, scale and\n  precision. The error bound needs no choice: RMSE {}, {} of the pixels changed; its median \
             length here is {} m.\n",
            scientific(best),
            number(least.full.rmse),
            share(least.full.code_differing_pixels),
            number(bound.full.rmse),
            share(bound.full.code_differing_pixels),
            number(self.offset),
        );
        if let Some((_, p)) = self.fixed().find(|f| f.0 == REPORTS) {
            let branch = if best < REPORTS { "right" } else { "left" };
            text += &format!(
                "- **The report's value, 0.1,** lies on the {branch} branch: RMSE {}, {} times that of the error bound; {} of \
                 the pixels changed,\n  {} too light in direct light.\n",
                number(p.full.rmse),
                number(p.full.rmse / bound.full.rmse),
                share(p.full.code_differing_pixels),
                share(p.light),
            );
        }
        text
    }

    pub(super) fn charts(&self) -> Vec<Chart> {
        let Some(bound) = self.bound() else { return Vec::new() };
        let x = || Axis {
            label: "fixed epsilon, metres along the ray",
            range: [1e-9, 1.0],
            scale: Scale::Decades,
        };
        let line = |name: &str, color, value: &dyn Fn(&Point) -> f64| Series {
            name: name.into(),
            color,
            points: self.fixed().map(|(x, p)| (x, value(p))).collect(),
            look: Look::Marked,
        };
        let level = |name: &str, color, y: f64| Series {
            name: name.into(),
            color,
            points: vec![(1e-9, y), (1.0, y)],
            look: Look::Plain,
        };
        let whole = self.pixels as f64 / 100.0;
        let mark = Some((REPORTS, "the report's 0.1"));
        vec![
            Chart {
                title: "Error of the image",
                x: x(),
                y: Axis { label: "linear light", range: [1e-9, 1.0], scale: Scale::Decades },
                series: vec![
                    line("RMSE", 0, &|p| p.full.rmse),
                    line("maximum", 1, &|p| p.full.max_abs),
                    level("RMSE with the error bound", 0, bound.full.rmse),
                    level("maximum with the error bound", 1, bound.full.max_abs),
                ],
                mark,
                legend: Legend::LowerLeft,
            },
            Chart {
                title: "Pixels wrong in direct light",
                x: x(),
                y: Axis { label: "% of pixels", range: [1e-3, 100.0], scale: Scale::Decades },
                series: vec![
                    line("too dark: acne", 3, &|p| p.dark as f64 / whole),
                    line("too light: leaks", 2, &|p| p.light as f64 / whole),
                ],
                mark,
                legend: Legend::LowerLeft,
            },
        ]
    }
}

fn scientific(x: f64) -> String {
    if x >= 0.1 { format!("{x}") } else { format!("{x:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn epsilons_are_two_a_decade_and_the_reports_is_one_of_them() {
        let all: Vec<f64> = epsilons().collect();
        assert_eq!((all.len(), all[0], all[18]), (19, 1e-9, 1.0));
        assert!(all.contains(&REPORTS) && all.windows(2).all(|w| w[0] < w[1]));
    }

    #[test]
    fn one_code_is_rounding_and_two_are_not() {
        let of_code = |k: u8| {
            let x = (0..=10_000).map(|i| i as f32 / 10_000.0).find(|x| code8(*x) == k).unwrap();
            [x, 0.5, 0.5]
        };
        let truth = [of_code(100), of_code(100), of_code(100), of_code(255), of_code(0)];
        let image = [of_code(99), of_code(98), of_code(102), of_code(255), of_code(0)];
        assert_eq!(dark_and_light(&image, &truth), (1, 1));
        // White and black have no codes beyond them, and are no errors for that.
        assert_eq!(dark_and_light(&truth, &truth), (0, 0));
    }
}

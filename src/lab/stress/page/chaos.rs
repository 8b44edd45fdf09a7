//! f32 against f64 along chains of reflections: from sphere to sphere an error grows by the
//! curvature.

use super::{PageError, Stop, running};
use crate::lab::markdown::{number, percent, table};
use crate::lab::plot::{Axis, Chart, Legend, Look, Scale, Series};
use crate::lab::probe::ProbeRay;
use crate::lab::stress::case::Random;
use crate::prepare::local_frame::LocalFrame;
use crate::render::Renderer;
use crate::report::table::Align::Right;
use crate::scene::Scene;
use crate::scene::procedural::shapes::{empty, mirror, polygon, sphere};
use crate::scene::procedural::sphereflake;
use crate::settings::{Precision, Settings};
use crate::stats::{geometric_mean, median};
use glam::DVec3;

/// Chains followed.
const CHAINS: usize = 1 << 16;
/// Rays in each.
const DEPTH: usize = 8;
/// Half the side of the box of mirrors around the flake, metres. A short binary fraction, as all
/// else is: both precisions see the same scene and the same first rays.
const WALL: f64 = 1.125;
/// Triangles of the walls, numbered before the spheres.
const WALL_TRIANGLES: u32 = 12;

/// A hit of a chain.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Step {
    /// Walls are one surface each, then the spheres.
    surface: u32,
    position: DVec3,
    /// Unit, of the ray that arrives.
    direction: DVec3,
    normal: DVec3,
}

/// The chains of one precision; `None` after an escape.
type Chains = Vec<[Option<Step>; DEPTH]>;

/// Figures of one depth.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Row {
    /// Chains that have met another surface by this depth, under `fast` and `robust`.
    pub differ: [u64; 2],
    /// Median distance between the `robust` chain and the f64 one, across the ray, over the chains
    /// that agree up to here; local units.
    pub distance: f64,
    /// Its growth since the depth above, per chain, averaged as a factor.
    pub grown: Option<f64>,
    /// 1 + 2 d / (R cos), averaged alike over the same chains.
    pub curvature: Option<f64>,
    /// The same with the spread that the error arrives with: see [`Beam`].
    pub beam: Option<f64>,
}

/// The section's figures.
pub(super) struct Chaos {
    pub rows: Vec<Row>,
}

fn scene() -> Scene {
    let mut s = empty(vec![mirror(1.0, 0.0)]);
    let (l, h) = (-WALL, WALL);
    let walls = [
        [[l, l, l], [h, l, l], [h, h, l], [l, h, l]],
        [[l, l, h], [l, h, h], [h, h, h], [h, l, h]],
        [[l, l, l], [l, l, h], [h, l, h], [h, l, l]],
        [[l, h, l], [h, h, l], [h, h, h], [l, h, h]],
        [[l, l, l], [l, h, l], [l, h, h], [l, l, h]],
        [[h, l, l], [h, l, h], [h, h, h], [h, h, l]],
    ];
    s.polygons = walls.iter().map(|w| polygon(w, 0)).collect();
    let rounded = |x: f64| f64::from(x as f32);
    s.spheres =
        sphereflake(2).into_iter().map(|(c, r)| sphere(c.to_array().map(rounded), rounded(r), 0)).collect();
    s
}

fn surface(id: u32) -> u32 {
    if id < WALL_TRIANGLES { id / 2 } else { id - WALL_TRIANGLES / 2 }
}

/// First rays: from a corner of the box toward random points of the flake's ball.
fn first_rays(frame: &LocalFrame) -> Vec<ProbeRay> {
    let mut random = Random::new(0xc4a05);
    let rounded = |v: DVec3| v.as_vec3().as_dvec3();
    let origin = rounded(frame.point(DVec3::new(1.0, 0.75, 0.875)));
    (0..CHAINS)
        .map(|_| {
            let target = frame.point(random.direction() * (0.9 * random.unit().cbrt()));
            ProbeRay::new(origin, rounded((target - origin).normalize()))
        })
        .collect()
}

fn follow(
    renderer: &mut Renderer,
    scene: &Scene,
    precision: Precision,
    stop: Stop<'_>,
) -> Result<Chains, PageError> {
    let settings = Settings { precision, ..Settings::of(scene) };
    let mut chains: Chains = vec![[None; DEPTH]; CHAINS];
    let mut rays = first_rays(&LocalFrame::of_whole(scene));
    let mut owners: Vec<usize> = (0..CHAINS).collect();
    for depth in 0..DEPTH {
        running(stop)?;
        let probed = renderer.probe(scene, &settings, &rays)?;
        for ((ray, owner), hit) in rays.iter().zip(&owners).zip(&probed.hits) {
            chains[*owner][depth] = hit.map(|h| Step {
                surface: surface(h.id),
                position: h.position,
                direction: ray.direction.normalize_or_zero(),
                normal: h.normal,
            });
        }
        owners = probed.children.iter().map(|c| owners[c.parent]).collect();
        rays = probed
            .children
            .iter()
            .map(|c| ProbeRay { origin: c.origin, direction: c.direction, skip: c.skip, media: None })
            .collect();
    }
    Ok(chains)
}

/// True if both met the same surfaces down to `depth` (from 0).
fn agree(a: &[Option<Step>; DEPTH], b: &[Option<Step>; DEPTH], depth: usize) -> bool {
    (0..=depth).all(|d| matches!((a[d], b[d]), (Some(a), Some(b)) if a.surface == b.surface))
}

/// Distance between two hits across the ray.
fn apart(a: &Step, truth: &Step) -> f64 {
    let d = a.position - truth.position;
    (d - truth.direction * d.dot(truth.direction)).length()
}

/// Two paths side by side: how far apart, and how fast they part. A bounce off a sphere turns a
/// distance w into 2 w / (R cos) of angle in the plane of incidence (Coddington's equation for a
/// mirror).
#[derive(Debug, Clone, Copy)]
struct Beam {
    width: f64,
    angle: f64,
}

impl Beam {
    /// After the bounce at `from` and the way to `to`.
    fn onward(self, from: &Step, to: &Step, radius: f64) -> Beam {
        let cos = from.direction.dot(from.normal).abs();
        let angle = self.angle + 2.0 * self.width / (radius * cos);
        Beam { width: self.width + from.position.distance(to.position) * angle, angle }
    }
}

/// `radius` of a surface, local units; infinite for a wall.
fn rows(truth: &Chains, fast: &Chains, robust: &Chains, radius: &dyn Fn(u32) -> f64) -> Vec<Row> {
    let mut beams = vec![Beam { width: 1.0, angle: 0.0 }; truth.len()];
    (0..DEPTH)
        .map(|depth| {
            let differ = [fast, robust]
                .map(|c| truth.iter().zip(c).filter(|(t, c)| !agree(c, t, depth)).count() as u64);
            let (mut distances, mut grown, mut curvature, mut spread) = (vec![], vec![], vec![], vec![]);
            for ((t, r), beam) in truth.iter().zip(robust).zip(&mut beams) {
                let (true, Some(here), Some(there)) = (agree(r, t, depth), t[depth], r[depth]) else {
                    continue;
                };
                let distance = apart(&there, &here);
                distances.push(distance);
                let above = depth.checked_sub(1).and_then(|d| Some((t[d]?, r[d]?)));
                let Some((from, from_robust)) = above else { continue };
                let radius = radius(from.surface);
                let next = beam.onward(&from, &here, radius);
                let before = apart(&from_robust, &from);
                if before > 0.0 && distance > 0.0 {
                    grown.push(distance / before);
                    curvature.push(Beam { width: 1.0, angle: 0.0 }.onward(&from, &here, radius).width);
                    spread.push(next.width / beam.width);
                }
                *beam = next;
            }
            Row {
                differ,
                distance: median(&distances).unwrap_or(f64::NAN),
                grown: geometric_mean(&grown),
                curvature: geometric_mean(&curvature),
                beam: geometric_mean(&spread),
            }
        })
        .collect()
}

pub(super) fn measure(renderer: &mut Renderer, stop: Stop<'_>) -> Result<Chaos, PageError> {
    let scene = scene();
    let scale = 2f64.powi(LocalFrame::of_whole(&scene).scale_log2);
    let radius = |surface: u32| {
        let ball = surface.checked_sub(WALL_TRIANGLES / 2).and_then(|i| scene.spheres.get(i as usize));
        ball.map_or(f64::INFINITY, |s| s.radius * scale)
    };
    let mut chains = |precision| follow(renderer, &scene, precision, stop);
    let (truth, fast, robust) =
        (chains(Precision::Double)?, chains(Precision::Fast)?, chains(Precision::Robust)?);
    Ok(Chaos { rows: rows(&truth, &fast, &robust, &radius) })
}

impl Chaos {
    pub(super) fn text(&self) -> String {
        let mut above: Option<&Row> = None;
        let factor = |x: Option<f64>| x.map_or("-".into(), number);
        let cells: Vec<[String; 8]> = self
            .rows
            .iter()
            .enumerate()
            .map(|(i, row)| {
                let spread =
                    above.filter(|a| a.differ[1] > 0).map(|a| row.differ[1] as f64 / a.differ[1] as f64);
                above = Some(row);
                [
                    (i + 1).to_string(),
                    percent(row.differ[0], CHAINS as u64),
                    percent(row.differ[1], CHAINS as u64),
                    factor(spread),
                    number(row.distance),
                    factor(row.grown),
                    factor(row.curvature),
                    factor(row.beam),
                ]
            })
            .collect();
        let table = table(
            &[
                ("depth", Right),
                ("paths that differ: `fast`", Right),
                ("paths that differ: `robust`", Right),
                ("growth, `robust`", Right),
                ("median distance, `robust`", Right),
                ("growth of the distance", Right),
                ("predicted: curvature", Right),
                ("predicted: with divergence", Right),
            ],
            &cells,
        );
        format!(
            "A sphereflake of 91 mirrors in a closed box of mirrors. {CHAINS} chains of reflections are traced by the \
             kernels at each precision, from\nthe same first rays through the same scene (both exact in f32). A path \
             *differs* from the depth at which it hits another surface than the\nf64 path (the same kernels in f64). The \
             distance is measured between the `robust` hit and the f64 hit, perpendicular to the ray, in units\nof the \
             local frame (the scene's radius is between 1/2 and 1), over the paths that still agree. Its growth is the \
             geometric mean over paths.\n\n\
             Two predictions are averaged over the same paths. *Curvature* is 1 + 2d/(R cos a) for a reflection at angle \
             a off a sphere of radius R with\ndistance d to the next hit, and 1 for a wall. *With divergence* also counts \
             that diverging paths keep diverging: a distance w adds an angle\nof 2w/(R cos a), which stays from reflection \
             to reflection. Neither includes the new rounding at each reflection.\n\n{table}\n{}",
            self.reading()
        )
    }

    fn reading(&self) -> String {
        // From the third hit on what has grown outweighs what each bounce rounds anew.
        let late = |value: &dyn Fn(&Row) -> Option<f64>| {
            geometric_mean(&self.rows.iter().skip(2).filter_map(value).collect::<Vec<_>>())
        };
        let (grown, curvature, beam) = (late(&|r| r.grown), late(&|r| r.curvature), late(&|r| r.beam));
        let (Some(grown), Some(curvature), Some(beam)) = (grown, curvature, beam) else {
            return String::new();
        };
        let (first, last) = (self.rows.first(), self.rows.last());
        let share = |row: Option<&Row>| row.map_or("-".into(), |r| percent(r.differ[1], CHAINS as u64));
        let within = |r: &&Row| r.grown.zip(r.curvature).is_some_and(|(g, c)| g <= 2.0 * c);
        let judged = self.rows.iter().filter(|r| r.grown.is_some()).count();
        format!(
            "Reflections between convex mirrors are chaotic: no fixed precision keeps a path. From depth 3 on, each \
             reflection multiplies the distance\nby {} on average; curvature alone predicts {}, with divergence {}. The \
             measured growth is at most twice that of curvature alone at {} of {judged}\ndepths. The share of `robust` paths \
             that differ grows from {} at the first hit to {} at depth {DEPTH}. The rechecks of `robust` prevent\nlight \
             leaks; they cannot slow this growth. Pictures of such scenes can only be compared statistically, not pixel by \
             pixel.\n",
            number(grown),
            number(curvature),
            number(beam),
            self.rows.iter().filter(within).count(),
            share(first),
            share(last),
        )
    }

    pub(super) fn charts(&self) -> Vec<Chart> {
        let x = || Axis { label: "depth", range: [1.0, DEPTH as f64], scale: Scale::Linear };
        let depths = |value: &dyn Fn(&Row) -> f64| {
            self.rows.iter().enumerate().map(|(i, r)| (i as f64 + 1.0, value(r))).collect::<Vec<_>>()
        };
        let line = |name: &str, color, points, look| Series { name: name.into(), color, points, look };
        let share = |k: usize| depths(&move |r: &Row| 100.0 * r.differ[k] as f64 / CHAINS as f64);
        // From depth 2 on: before, an error is one rounding.
        let predicted = |factor: &dyn Fn(&Row) -> Option<f64>| {
            let mut at = self.rows.get(1).map_or(f64::NAN, |r| r.distance);
            let later = self.rows.iter().enumerate().skip(1).map(|(i, r)| {
                at *= if i > 1 { factor(r).unwrap_or(f64::NAN) } else { 1.0 };
                (i as f64 + 1.0, at)
            });
            later.collect::<Vec<_>>()
        };
        vec![
            Chart {
                title: "Paths that differ from f64",
                x: x(),
                y: Axis { label: "% of paths", range: [1e-3, 100.0], scale: Scale::Decades },
                series: vec![
                    line("fast", 1, share(0), Look::Thick),
                    line("robust", 0, share(1), Look::Marked),
                ],
                mark: None,
                legend: Legend::UpperLeft,
            },
            Chart {
                title: "Distance of robust from f64",
                x: x(),
                y: Axis { label: "local units", range: [1e-8, 1e-2], scale: Scale::Decades },
                series: vec![
                    line("median, paths that agree", 0, depths(&|r| r.distance), Look::Marked),
                    line("from depth 2, curvature", 3, predicted(&|r| r.curvature), Look::Plain),
                    line("from depth 2, with divergence", 2, predicted(&|r| r.beam), Look::Plain),
                ],
                mark: None,
                legend: Legend::UpperLeft,
            },
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(surface: u32, x: f64) -> Option<Step> {
        let position = DVec3::new(x, 0.0, 0.0);
        Some(Step { surface, position, direction: DVec3::Z, normal: -DVec3::Z })
    }

    #[test]
    fn the_scene_is_exact_in_single_precision_and_closed() {
        let s = scene();
        assert_eq!((s.spheres.len(), s.polygons.len()), (91, 6));
        let frame = LocalFrame::of_whole(&s);
        for ball in &s.spheres {
            let c = frame.point(ball.center);
            assert_eq!(c, c.as_vec3().as_dvec3());
            assert!(ball.center.abs().max_element() + ball.radius < WALL);
        }
        let [ray, ..] = first_rays(&frame)[..] else { panic!("no rays") };
        assert_eq!(ray.origin, ray.origin.as_vec3().as_dvec3());
    }

    #[test]
    fn both_halves_of_a_wall_are_one_surface() {
        let all: Vec<u32> = (0..15).map(surface).collect();
        assert_eq!(all, [0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 7, 8]);
    }

    #[test]
    fn a_path_that_came_back_still_differs() {
        let truth = [step(1, 0.0); DEPTH];
        let mut other = truth;
        other[2] = step(9, 0.0);
        assert!(agree(&other, &truth, 1) && !agree(&other, &truth, 2) && !agree(&other, &truth, 5));
        other[2] = None;
        assert!(!agree(&other, &truth, 2));
    }

    #[test]
    fn growth_is_per_path_and_the_prediction_is_the_notes() {
        let mut truth = [step(6, 0.0); DEPTH];
        let mut robust = [step(6, 1e-7); DEPTH];
        truth[1] = step(7, 3.0);
        robust[1] = step(7, 3.0 + 7e-7);
        let rows = rows(&vec![truth], &vec![truth], &vec![robust], &|_| 1.0);
        assert_eq!((rows[0].grown, rows[0].differ), (None, [0, 0]));
        // d = 3, R = 1, cos = 1.
        assert!((rows[1].curvature.unwrap() - 7.0).abs() < 1e-12);
        assert!((rows[1].beam.unwrap() - 7.0).abs() < 1e-12);
        assert!((rows[1].grown.unwrap() - 7.0).abs() < 1e-6);
    }

    #[test]
    fn a_flat_mirror_keeps_the_spread_and_adds_none() {
        let (from, to) = (step(0, 0.0).unwrap(), step(0, 2.0).unwrap());
        let parallel = Beam { width: 1.0, angle: 0.0 }.onward(&from, &to, f64::INFINITY);
        let parting = Beam { width: 1.0, angle: 0.5 }.onward(&from, &to, f64::INFINITY);
        assert_eq!((parallel.width, parting.width, parting.angle), (1.0, 2.0, 0.5));
    }

    #[test]
    fn distance_is_across_the_ray() {
        let (mut a, b) = (step(0, 3e-7).unwrap(), step(0, 0.0).unwrap());
        a.position.z = 5.0;
        assert!((apart(&a, &b) - 3e-7).abs() < 1e-15);
    }
}

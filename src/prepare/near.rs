//! Scenes of two scales: a room with a moon, things of centimetres on a ground of kilometres. What the eye sees
//! first takes its digits from the frame's origin, so the frame lies there, and not in the middle of everything
//! (numerics.md, Two scales).

use super::cut::{Place, extent};
use super::local_frame::{LocalFrame, times_power_of_two};
use super::view::View;
use crate::scene::{Face, Polygon, Scene};
use crate::settings::Settings;
use crate::units::figure;
use glam::DVec3;
use rayon::prelude::*;
use std::ops::RangeInclusive;

/// A scene has two scales where half the height of the view, at the depth at which the first of its shapes is in
/// view, is less than this share of the scene's radius. At 1000 rows, u of the radius is then 2^-9 of a pixel.
const TWO_SCALES: f64 = 1.0 / 64.0;
/// Radius of the frame, in halves of that height.
const EXTENT: f64 = 16.0;
/// Images this much wider than high are looked through for the nearest shape, whatever the camera's are.
const ASPECT: f64 = 2.0;
/// Share of a pixel that rounding may take in f32.
const PIXEL_SHARE: f64 = 1.0 / 1024.0;
/// The eye may touch a surface. Its distance is then taken to be this share of that to the point looked at.
const TOUCHING: f64 = 1.0 / 1_048_576.0;

/// What the eye sees first, in a scene of two scales. World coordinates, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Near {
    /// Where rays begin, in the middle of the view: the origin of the local frame.
    pub center: DVec3,
    /// Depth of `center` before the eye.
    advance: f64,
    /// Depth at which the first shape is in view.
    pub depth: f64,
    /// Radius of the frame.
    pub extent: f64,
    /// Radius of the whole scene.
    pub whole: f64,
    /// Tangent of half the field of view, vertically.
    half_height: f64,
}

impl Near {
    /// `None` for a scene of one scale. `whole` is the frame around everything.
    pub(super) fn of(scene: &Scene, whole: &LocalFrame) -> Option<Near> {
        let camera = &scene.camera;
        let radius = times_power_of_two(1.0, -whole.scale_log2);
        let half_height = (camera.fov / 2.0).tan();
        let aspect = f64::from(camera.width) / f64::from(camera.height);
        let depth =
            View::new(camera, aspect.max(ASPECT)).nearest(scene, radius * TWO_SCALES / half_height)?;
        let looked = camera.look_at.distance(camera.look_from).min(radius);
        let seen_from = depth.max(TOUCHING * looked);
        let extent = EXTENT * half_height * seen_from;
        // On a surface the eye stays where it is: its plane holds it exactly.
        let advance = if depth < seen_from { 0.0 } else { clear(depth, extent) };
        let [.., forward] = camera.axes();
        let center = camera.look_from + advance * forward;
        Some(Near { center, advance, depth: seen_from, extent, whole: radius, half_height })
    }

    /// Depth before the eye that rays of an image of `aspect` may begin at.
    pub(super) fn advance_for(&self, scene: &Scene, aspect: f64) -> f64 {
        let own = f64::from(scene.camera.width) / f64::from(scene.camera.height);
        if aspect <= own.max(ASPECT) {
            return self.advance;
        }
        let depth = View::new(&scene.camera, aspect).nearest(scene, self.depth);
        depth.map_or(self.advance, |depth| clear(depth, self.extent).min(self.advance))
    }

    /// True if f32 moves no edge by more than `PIXEL_SHARE` of a pixel. `shape` as of [`Near::largest`].
    pub(crate) fn single_is_enough(&self, shape: f64, settings: &Settings) -> bool {
        self.moved(shape, settings) <= PIXEL_SHARE
    }

    /// Where large flat shapes are cut. Under a long lens, whose view is narrow where it meets them, more finely than
    /// the depth asks for.
    pub(super) fn place(&self) -> Place {
        Place { center: self.center, depth: self.depth.min(self.extent) }
    }

    /// Why f32 is not enough.
    pub(crate) fn words(&self, shape: f64, settings: &Settings) -> String {
        format!(
            "the scene has two scales: the view is {} m high where it meets the first shape, {} m from the eye, and the \
             scene has a radius of {} m; rounding in f32 moves edges by {} of a pixel, more than the {} allowed",
            figure(2.0 * self.half_height * self.depth),
            figure(self.depth),
            figure(self.whole),
            figure(self.moved(shape, settings)),
            figure(PIXEL_SHARE)
        )
    }

    /// How far rounding in f32 moves an edge, in pixels.
    fn moved(&self, shape: f64, settings: &Settings) -> f64 {
        let pixel = 2.0 * self.half_height / f64::from(settings.height);
        2f64.powi(-24) * shape / pixel
    }

    /// Local radii that single numbers serve.
    pub(super) fn single_radii(&self) -> RangeInclusive<f64> {
        *super::SINGLE_RADII.start()..=LARGEST_SINGLE
    }

    /// Largest (s + e) / (depth + s) of a triangle of extent e at distance s from `center`: what rounding moves it by,
    /// in u of the distance that it is seen from.
    pub(super) fn largest(&self, scene: &Scene) -> f64 {
        let place = self.place();
        let share = |corners: &[DVec3; 3]| {
            let distance = place.distance(corners);
            (distance + extent(corners)) / (self.depth + distance)
        };
        let fan = |p: &Polygon| {
            let v = &p.vertices;
            (1..v.len() - 1).map(|i| share(&[v[0], v[i], v[i + 1]])).fold(0.0, f64::max)
        };
        let polygons = scene.polygons.par_iter().map(fan).reduce(|| 0.0, f64::max);
        let meshes = scene.meshes.iter().map(|mesh| {
            let of = |f: &Face| share(&f.vertices.map(|v| mesh.vertices[v as usize]));
            mesh.faces.par_iter().map(of).reduce(|| 0.0, f64::max)
        });
        meshes.fold(polygons, f64::max)
    }
}

/// Largest local radius of a sphere that is no extended one, in a frame around what the eye sees first.
const LARGEST_SINGLE: f64 = 0.25;

/// Kept clear of the geometry by more than rounding of the start and of the depth: u times the frame and u relative,
/// each with a factor of 8 in hand.
fn clear(depth: f64, extent: f64) -> f64 {
    (depth - (depth + extent) * 2f64.powi(-21)).max(0.0)
}

//! A case: what it does, which failure of real renderers it reproduces, and its result compared
//! with a bound.

use super::tracer::{Picture, Tracer};
use crate::lab::probe::{ProbeRay, Probed};
use crate::prepare::SINGLE_RADII;
use crate::prepare::local_frame::LocalFrame;
use crate::render::RenderError;
use crate::scene::Scene;
use crate::settings::sampler::{Sampler, pcg4d};
use crate::settings::{Origin, Precision, Settings};
use crate::units::{figure, grouped};
use glam::DVec3;
use serde::Serialize;
use std::fmt;

/// The result of a case and its greatest allowed value. Displayed as `0 of 90,000 rays missed`, as
/// `61 % of the allowed error (worst of 6,005 rays)`, or as value, unit and bound.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figure {
    /// The result; NaN fails.
    #[serde(rename = "figure")]
    pub value: f64,
    /// Greatest allowed value.
    pub bound: f64,
    /// Unit of both, such as `of 90,000 rays missed`.
    pub unit: String,
}

/// Unit of results that are divided by their bound.
const SHARE: &str = "of the allowed error";

impl Figure {
    /// A result with its bound.
    pub fn new(value: f64, bound: f64, unit: impl Into<String>) -> Figure {
        Figure { value, bound, unit: unit.into() }
    }

    /// A count out of `all` that must be zero; `what` follows the two numbers.
    pub fn count(count: usize, all: usize, what: &str) -> Figure {
        Figure::none(count, format!("of {} {what}", grouped(all as u64)))
    }

    /// An error / the allowed error, which must be at most 1; `which` says of what.
    pub fn share(value: f64, which: &str) -> Figure {
        Figure::new(value, 1.0, format!("{SHARE} ({which})"))
    }

    /// A count that must be zero.
    pub fn none(count: usize, unit: impl Into<String>) -> Figure {
        Figure::new(count as f64, 0.0, unit)
    }

    /// True if the result is within its bound.
    pub fn passes(&self) -> bool {
        self.value <= self.bound
    }

    /// The one closer to its bound, or further beyond it.
    pub fn worse(self, other: Figure) -> Figure {
        let strain = |f: &Figure| {
            if f.passes() { if f.bound > 0.0 { f.value / f.bound } else { 0.0 } } else { f64::INFINITY }
        };
        if strain(&other) > strain(&self) { other } else { self }
    }
}

impl fmt::Display for Figure {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Figure { value, bound, unit } = self;
        let percent = 100.0 * value;
        if !value.is_finite() {
            write!(out, "failed: {unit}")
        } else if unit.starts_with(SHARE) && (10.0..1e6).contains(&percent) {
            write!(out, "{percent:.0} % {unit}")
        } else if unit.starts_with(SHARE) {
            write!(out, "{} % {unit}", figure(percent))
        } else if *bound == 0.0 {
            write!(out, "{} {unit}", figure(*value))
        } else {
            write!(out, "{} {unit} (at most {})", figure(*value), figure(*bound))
        }
    }
}

/// One case.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    /// Name for `--only`: lower case with dashes.
    pub name: &'static str,
    /// What it does, in one line.
    pub does: &'static str,
    /// The failure of real renderers that it reproduces.
    pub stands_for: &'static str,
    /// Derivation of the bound.
    pub bound: &'static str,
    /// Runs it.
    pub run: fn(&mut Harness<'_>) -> Result<Figure, RenderError>,
}

/// Renders scenes and traces rays for a running case.
pub struct Harness<'t> {
    tracer: &'t mut dyn Tracer,
    /// Arithmetic of the kernels.
    pub precision: Precision,
    /// Where secondary and shadow rays start.
    pub origin: Origin,
}

impl<'t> Harness<'t> {
    /// Runs cases on `tracer`.
    pub fn new(tracer: &'t mut dyn Tracer, precision: Precision) -> Harness<'t> {
        // Cases prove something of one arithmetic, and not of the choice between two.
        let precision = if precision == Precision::Auto { Precision::Robust } else { precision };
        Harness { tracer, precision, origin: Origin::Bound }
    }

    /// Unit roundoff of the kernels' numbers.
    pub fn u(&self) -> f64 {
        if self.precision == Precision::Double { 2f64.powi(-53) } else { 2f64.powi(-24) }
    }

    /// Least radius of a sphere in the local frame for which the terms of its equation have the errors that the bounds
    /// allow: f32 holds its square, and where denormals are flushed also the errors of products
    /// (numerics.md, Not promised: 2^-79).
    pub fn least_radius(&self) -> f64 {
        let flushed = self.precision != Precision::Double && self.tracer.flushes_denormals();
        if flushed { 2f64.powi(-39) } else { 2f64.powi(-60) }
    }

    /// The scene's own settings in the case's precision. Samples are independent: the bounds of
    /// statistical cases are those of a binomial.
    pub fn settings(&self, scene: &Scene) -> Settings {
        Settings {
            precision: self.precision,
            origin: self.origin,
            sampler: Sampler::Random,
            ..Settings::of(scene)
        }
    }

    /// Renders the scene under its own settings.
    pub fn picture(&mut self, scene: &Scene) -> Result<Picture, RenderError> {
        let settings = self.settings(scene);
        self.tracer.picture(scene, &settings)
    }

    /// Renders the scene under `settings` (made from [`Harness::settings`]).
    pub fn picture_with(&mut self, scene: &Scene, settings: &Settings) -> Result<Picture, RenderError> {
        self.tracer.picture(scene, settings)
    }

    /// Traces rays given in local coordinates.
    pub fn probe(&mut self, scene: &Scene, rays: &[ProbeRay]) -> Result<Probed, RenderError> {
        let settings = self.settings(scene);
        self.tracer.probe(scene, &settings, rays)
    }

    /// Traces rays by brute force and through the hierarchy.
    pub fn probe_both(&mut self, scene: &Scene, rays: &[ProbeRay]) -> Result<[Probed; 2], RenderError> {
        let settings = self.settings(scene);
        let mut run = |brute| {
            self.tracer.force_brute_force(Some(brute));
            let probed = self.tracer.probe(scene, &settings, rays);
            self.tracer.force_brute_force(None);
            probed
        };
        Ok([run(true)?, run(false)?])
    }

    /// As [`Harness::probe`], through the hierarchy, walks taking at most `steps` steps a dispatch.
    pub fn probe_in_parts(
        &mut self,
        scene: &Scene,
        rays: &[ProbeRay],
        steps: u32,
    ) -> Result<Probed, RenderError> {
        let mut settings = self.settings(scene);
        settings.schedule.walk_steps = Some(steps);
        self.tracer.force_brute_force(Some(false));
        let probed = self.tracer.probe(scene, &settings, rays);
        self.tracer.force_brute_force(None);
        probed
    }

    /// As [`Harness::picture`], through the hierarchy, walks taking at most `steps` steps a dispatch.
    pub fn picture_in_parts(&mut self, scene: &Scene, steps: u32) -> Result<Picture, RenderError> {
        let mut settings = self.settings(scene);
        settings.schedule.walk_steps = Some(steps);
        self.tracer.force_brute_force(Some(false));
        let picture = self.tracer.picture(scene, &settings);
        self.tracer.force_brute_force(None);
        picture
    }

    /// Renders the scene under its own settings by brute force and through the hierarchy.
    pub fn picture_both(&mut self, scene: &Scene) -> Result<[Picture; 2], RenderError> {
        let settings = self.settings(scene);
        let mut run = |brute| {
            self.tracer.force_brute_force(Some(brute));
            let picture = self.tracer.picture(scene, &settings);
            self.tracer.force_brute_force(None);
            picture
        };
        Ok([run(true)?, run(false)?])
    }

    /// The local frame that the kernels see the scene in.
    pub fn local_frame(&self, scene: &Scene) -> LocalFrame {
        self.tracer.local_frame(scene)
    }

    /// A world point as the kernels hold it: local, rounded to their precision.
    pub fn local(&self, scene: &Scene, world: DVec3) -> DVec3 {
        self.round(self.local_frame(scene).point(world))
    }

    /// A sphere as the kernels hold it (centre, radius, whether in two numbers for one), in local
    /// coordinates.
    pub fn local_sphere(&self, scene: &Scene, sphere: usize) -> (DVec3, f64, bool) {
        let (frame, s) = (self.local_frame(scene), scene.spheres[sphere]);
        let (center, radius) = (frame.point(s.center), frame.length(s.radius));
        if !SINGLE_RADII.contains(&radius) {
            return (center, radius, true);
        }
        (self.round(center), self.round(DVec3::splat(radius)).x, false)
    }

    /// Rounded to the kernels' precision.
    pub fn round(&self, v: DVec3) -> DVec3 {
        if self.precision == Precision::Double { v } else { v.as_vec3().as_dvec3() }
    }
}

/// Numbers that are the same on every run.
pub struct Random {
    stream: u32,
    at: u32,
}

impl Random {
    /// A stream of its own.
    pub fn new(stream: u32) -> Random {
        Random { stream, at: 0 }
    }

    /// In [0, 1), 32 bits.
    pub fn unit(&mut self) -> f64 {
        self.at = self.at.wrapping_add(1);
        f64::from(pcg4d([self.at, self.stream, 0x5eed, 0])[0]) / 4_294_967_296.0
    }

    /// In [low, high).
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Even on the unit sphere (Marsaglia, Ann. Math. Stat. 43(2), 1972).
    pub fn direction(&mut self) -> DVec3 {
        loop {
            let (x, y) = (self.range(-1.0, 1.0), self.range(-1.0, 1.0));
            let s = x * x + y * y;
            if s < 1.0 {
                let f = 2.0 * (1.0 - s).sqrt();
                return DVec3::new(x * f, y * f, 1.0 - 2.0 * s);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_read_as_sentences() {
        let cases = [
            (Figure::count(0, 90_000, "rays missed"), "0 of 90,000 rays missed", true),
            (Figure::count(3, 90_000, "rays missed"), "3 of 90,000 rays missed", false),
            (Figure::share(0.6112, "index 1.5"), "61 % of the allowed error (index 1.5)", true),
            (Figure::share(0.0034, "index 1.5"), "0.34 % of the allowed error (index 1.5)", true),
            (Figure::share(2.0, "index 1.5"), "200 % of the allowed error (index 1.5)", false),
            (Figure::new(1.2e-7, 2.384e-7, "of t"), "1.2e-7 of t (at most 2.38e-7)", true),
            (Figure::new(f64::INFINITY, 1.0, "rays lost"), "failed: rays lost", false),
            (Figure::new(f64::NAN, 0.0, "no pixel"), "failed: no pixel", false),
        ];
        for (figure, text, passes) in cases {
            assert_eq!((figure.to_string().as_str(), figure.passes()), (text, passes));
        }
        let [near, past] = [Figure::share(0.9, "a"), Figure::new(2.0, 1.5, "b")];
        assert_eq!(
            (near.clone().worse(past.clone()), Figure::share(0.5, "c").worse(near.clone())),
            (past, near)
        );
    }
}

//! A case: what it does, which real failure it stands for, and the bound it must keep.

use super::tracer::{Picture, Tracer};
use crate::lab::probe::{ProbeRay, Probed};
use crate::prepare::WIDE_RADII;
use crate::prepare::local_frame::LocalFrame;
use crate::render::RenderError;
use crate::scene::Scene;
use crate::settings::defect::Defect;
use crate::settings::sampler::{Sampler, pcg4d};
use crate::settings::{Origin, Precision, Settings};
use glam::DVec3;

/// The figure that a case reached, and the most it may be.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// What came out; NaN fails.
    pub value: f64,
    /// What may come out.
    pub bound: f64,
    /// What both count: "misses of 300,000 rays".
    pub unit: String,
}

impl Figure {
    /// A figure with its bound.
    pub fn new(value: f64, bound: f64, unit: impl Into<String>) -> Figure {
        Figure { value, bound, unit: unit.into() }
    }

    /// A count that must be zero.
    pub fn none(count: usize, unit: impl Into<String>) -> Figure {
        Figure::new(count as f64, 0.0, unit)
    }

    /// True if the bound is kept.
    pub fn passes(&self) -> bool {
        self.value <= self.bound
    }

    /// The one nearer to (or further past) its bound.
    pub fn worse(self, other: Figure) -> Figure {
        let strain = |f: &Figure| {
            if f.passes() { if f.bound > 0.0 { f.value / f.bound } else { 0.0 } } else { f64::INFINITY }
        };
        if strain(&other) > strain(&self) { other } else { self }
    }
}

/// One extreme.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    /// For `--only`: lower case, dashes.
    pub name: &'static str,
    /// What is done, in a line.
    pub does: &'static str,
    /// The failure of a real renderer that this stands for.
    pub stands_for: &'static str,
    /// Where the bound comes from.
    pub bound: &'static str,
    /// Mistakes that must make it fail.
    pub guards: &'static [Defect],
    /// Runs it.
    pub run: fn(&mut Harness<'_>) -> Result<Figure, RenderError>,
}

/// What a running case sees.
pub struct Harness<'t> {
    tracer: &'t mut dyn Tracer,
    /// Arithmetic of the kernels.
    pub precision: Precision,
    planted: Option<Defect>,
}

impl<'t> Harness<'t> {
    /// Runs cases on `tracer`; `planted` puts a mistake back.
    pub fn new(tracer: &'t mut dyn Tracer, precision: Precision, planted: Option<Defect>) -> Harness<'t> {
        Harness { tracer, precision, planted }
    }

    /// Unit roundoff of the kernels' numbers.
    pub fn u(&self) -> f64 {
        if self.precision == Precision::Double { 2f64.powi(-53) } else { 2f64.powi(-24) }
    }

    /// The scene's own settings in the case's precision. Samples are independent: the bounds of statistical
    /// cases are those of a binomial.
    pub fn settings(&self, scene: &Scene) -> Settings {
        let origin = match self.planted {
            Some(Defect::FixedOrigin) => Origin::Fixed(0.1),
            _ => Origin::Bound,
        };
        Settings {
            precision: self.precision,
            planted: self.planted,
            origin,
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

    /// The frame that the kernels see the scene in.
    pub fn frame(&self, scene: &Scene) -> LocalFrame {
        if self.planted == Some(Defect::WorldFrame) {
            return LocalFrame::world(&LocalFrame::of(scene));
        }
        LocalFrame::of(scene)
    }

    /// A world point as the kernels hold it: local, rounded to their precision.
    pub fn local(&self, scene: &Scene, world: DVec3) -> DVec3 {
        self.round(self.frame(scene).point(world))
    }

    /// A sphere as the kernels hold it (centre, radius, whether in two numbers for one), in local
    /// coordinates.
    pub fn local_sphere(&self, scene: &Scene, sphere: usize) -> (DVec3, f64, bool) {
        let (frame, s) = (self.frame(scene), scene.spheres[sphere]);
        let (center, radius) = (frame.point(s.center), frame.length(s.radius));
        if !WIDE_RADII.contains(&radius) {
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

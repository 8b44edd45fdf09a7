//! Tracers for cases: a Vulkan device, or the CPU twins of its kernels.

use crate::kernel::abi;
use crate::lab::probe::{ProbeRay, Probed, probe_twins};
use crate::plan::{Limits, PlannedScene};
use crate::prepare::Recipe;
use crate::prepare::local_frame::LocalFrame;
use crate::reference::twin;
use crate::render::{RenderError, Renderer};
use crate::report::{Counters, RayInfo};
use crate::scene::Scene;
use crate::settings::Settings;

/// An image with its counters.
#[derive(Debug, Clone)]
pub struct Picture {
    /// Rows from the top, linear RGB.
    pub linear: Vec<[f32; 3]>,
    /// Counts of numerical faults.
    pub counters: Counters,
    /// Rays traced.
    pub rays: RayInfo,
}

/// Renders scenes and traces rays.
pub trait Tracer {
    /// Renders `scene`.
    fn picture(&mut self, scene: &Scene, settings: &Settings) -> Result<Picture, RenderError>;
    /// Traces `rays` against `scene` and spawns their children.
    fn probe(&mut self, scene: &Scene, settings: &Settings, rays: &[ProbeRay])
    -> Result<Probed, RenderError>;
    /// Forces brute force (`true`) or the hierarchy (`false`); `None` chooses by the number of
    /// primitives.
    fn force_brute_force(&mut self, brute_force: Option<bool>);
    /// True if numbers of f32 below the least normal one are zero.
    fn flushes_denormals(&self) -> bool {
        false
    }
    /// The local frame of `scene` in the kernels, as probed: around everything.
    fn local_frame(&self, scene: &Scene) -> LocalFrame {
        LocalFrame::of_whole(scene)
    }
}

impl Tracer for Renderer {
    fn picture(&mut self, scene: &Scene, settings: &Settings) -> Result<Picture, RenderError> {
        let r = self.render(scene, settings)?;
        Ok(Picture { linear: r.linear, counters: r.report.counters, rays: r.report.rays })
    }

    fn probe(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        rays: &[ProbeRay],
    ) -> Result<Probed, RenderError> {
        Renderer::probe(self, scene, settings, rays)
    }

    fn force_brute_force(&mut self, brute_force: Option<bool>) {
        Renderer::force_brute_force(self, brute_force);
    }

    fn flushes_denormals(&self) -> bool {
        self.arithmetic().single.flushes_denormals
    }

    fn local_frame(&self, scene: &Scene) -> LocalFrame {
        Renderer::local_frame(self, scene)
    }
}

/// The CPU twins of the kernels.
#[derive(Debug, Default)]
pub struct Twins {
    brute_force: Option<bool>,
}

impl Tracer for Twins {
    fn picture(&mut self, scene: &Scene, settings: &Settings) -> Result<Picture, RenderError> {
        let planned =
            PlannedScene::for_twins(Recipe::of(scene), scene, settings, &Limits::LAVAPIPE, self.brute_force);
        let packed = &planned.packed;
        let (linear, counts) = twin::render(packed, scene, settings, planned.plan()?)
            .ok_or(RenderError::TooManyRays { pixel: None, capacity: planned.plan()?.capacity })?;
        let count = |i: u32| counts.counters[i as usize];
        let counters = Counters {
            degenerate_triangles: packed.degenerate_triangles,
            nan_rays: count(abi::COUNTER_NAN_RAYS),
            clamped_lights: count(abi::COUNTER_CLAMPED_LIGHTS),
            stack_overflow: count(abi::COUNTER_STACK_OVERFLOW),
            loop_cap: count(abi::COUNTER_LOOP_CAP),
            media_overflow: count(abi::COUNTER_MEDIA_OVERFLOW) + packed.eye_media_dropped,
        };
        Ok(Picture { linear, counters, rays: RayInfo::of(&counts.depths) })
    }

    fn probe(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        rays: &[ProbeRay],
    ) -> Result<Probed, RenderError> {
        probe_twins(scene, settings, rays, self.brute_force, &Limits::LAVAPIPE)
    }

    fn force_brute_force(&mut self, brute_force: Option<bool>) {
        self.brute_force = brute_force;
    }
}

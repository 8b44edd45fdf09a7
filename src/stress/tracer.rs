//! What a case runs on: a Vulkan device, or the CPU twins of its kernels.

use crate::probe::{ProbeRay, Probed};
use crate::render::{Quiet, RenderError, Renderer};
use crate::report::{Counters, RayInfo};
use crate::scene::Scene;
use crate::settings::Settings;

/// An image and what was counted.
#[derive(Debug, Clone)]
pub struct Picture {
    /// Rows from the top, linear RGB.
    pub linear: Vec<[f32; 3]>,
    /// What ought to be zero.
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
    /// Tests every primitive (`true`), walks the hierarchy (`false`), or chooses by the scene's size.
    fn force_brute_force(&mut self, brute_force: Option<bool>);
}

impl Tracer for Renderer {
    fn picture(&mut self, scene: &Scene, settings: &Settings) -> Result<Picture, RenderError> {
        let r = self.render(scene, settings, &mut Quiet)?;
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
}

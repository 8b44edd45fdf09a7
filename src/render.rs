//! Settings and a scene in, an image and a report out.

use crate::report::Report;
use crate::scene::Scene;
use crate::settings::Settings;

/// An image with the story of its making.
#[derive(Debug, Clone)]
pub struct Rendered {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Rows from the top, linear RGB, unclamped. Pixels that were not reached are black.
    pub linear: Vec<[f32; 3]>,
    /// Share of the work that was done; 1 unless interrupted.
    pub done: f64,
    /// Everything that was counted and timed (the file names in it are the caller's to fill).
    pub report: Report,
}

/// Told of the progress between submits; may end the render.
pub trait Observer {
    /// `done` of `total` units of work (samples) are finished.
    fn progress(&mut self, done: u64, total: u64);
    /// True once the render should stop after the submit in flight.
    fn cancelled(&self) -> bool;
}

/// An observer that only lets things run.
pub struct Quiet;

impl Observer for Quiet {
    fn progress(&mut self, _done: u64, _total: u64) {}
    fn cancelled(&self) -> bool {
        false
    }
}

/// Why there is no image.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// No Vulkan, no device, or not the one asked for.
    #[error("{0}")]
    NoDevice(String),
    /// The device stopped answering.
    #[error("{0}")]
    DeviceLost(String),
    /// The scene or the settings cannot be rendered on this device; says what would fit.
    #[error("{0}")]
    DoesNotFit(String),
    /// Any other failed call.
    #[error("{0}")]
    Failed(String),
}

/// A device, ready to render.
pub struct Renderer {}

impl Renderer {
    /// Renders `scene`.
    pub fn render(
        &mut self,
        _scene: &Scene,
        _settings: &Settings,
        _observer: &mut dyn Observer,
    ) -> Result<Rendered, RenderError> {
        Err(RenderError::Failed("under construction".into()))
    }
}

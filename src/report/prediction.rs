//! Predicted time of a render, before it starts.

use serde::Serialize;

/// The time of a render, foretold. Seconds.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Prediction {
    /// What it rests on.
    pub basis: String,
    /// Device time of all passes.
    pub device: f64,
    /// From the first submit to the last pixel on the host.
    pub render: f64,
    /// `render` is hardly less than this.
    pub low: f64,
    /// Nor more than this.
    pub high: f64,
    /// Rays of all kinds.
    pub rays: u64,
    /// Depth by depth.
    pub by_depth: Vec<DepthForecast>,
    /// Reading the scene, building and preparing kernels, as they took just now; None where nothing ran.
    pub start: Option<f64>,
}

/// A depth of the forecast.
#[derive(Debug, Clone, Default, Serialize)]
pub struct DepthForecast {
    /// From 1.
    pub depth: u32,
    /// Primary, reflection and refraction rays.
    pub traced: u64,
    /// Shadow rays.
    pub shadow: u64,
    /// Device seconds.
    pub seconds: f64,
    /// Rays of this depth were not timed, but follow from those before.
    pub extrapolated: bool,
}

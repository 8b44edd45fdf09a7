//! Predicted time of a render, before it starts.

use serde::Serialize;

/// The predicted time of a render, seconds.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Prediction {
    /// The timed work that it extrapolates from, in words.
    pub basis: String,
    /// Device time of all passes.
    pub device: f64,
    /// From the first submit to the last pixel on the host.
    pub render: f64,
    /// Lower end of the prediction interval of `render`, seconds.
    pub low: f64,
    /// Upper end of the prediction interval of `render`, seconds.
    pub high: f64,
    /// Rays of all kinds.
    pub rays: u64,
    /// One row per depth.
    pub by_depth: Vec<DepthForecast>,
    /// Seconds to read the scene, build buffers and create pipelines, as just measured; None
    /// without a trial.
    pub start: Option<f64>,
}

/// One depth of the prediction.
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
    /// True if no ray of this depth was timed: extrapolated from the depths before.
    pub extrapolated: bool,
}

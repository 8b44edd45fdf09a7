//! Images with an error bound: with given settings (`--budget`), to a given error (`--error`), or
//! in a given time (`--time`).
//!
//! ```text
//! truncation_choice ─ depth and cutoff, from a survey of a few pixels
//! rounding ─ precision, from the same samples in f64
//! allocate ─ samples where they reduce the error most ─▶ image and error bound
//! ```

mod bounded_image;
mod fixed;
mod monotone_progress;
mod resume_state;
mod rounding;
mod traced;
mod truncation_choice;
mod until_error;
mod until_time;

pub use bounded_image::{Known, Layer};
pub use resume_state::Bounded;
pub use until_time::LATE;

use super::radiance_bound::{RadianceLimit, radiance_limit};
use crate::render::{Mismatch, Observer, RenderError, Renderer, ResumeState};
use crate::scene::Scene;
use crate::settings::Settings;
use monotone_progress::Forward;
use std::time::Instant;

/// Target of a render.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// The given settings; the error is only measured.
    Settings,
    /// At most this RMSE.
    Error(f64),
    /// The least error within this time.
    Time {
        /// Seconds of wall time, files included.
        seconds: f64,
        /// Start of the time.
        from: Instant,
        /// Number of layers to write afterwards, which takes part of the time.
        layers: u32,
    },
}

/// A request: target, confidence, and which settings may be chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Request {
    /// Target.
    pub target: Target,
    /// Confidence of the error bound, in (0, 1).
    pub confidence: f64,
    /// True to keep the depth of the settings, false to choose it.
    pub keep_depth: bool,
    /// True to keep the precision of the settings, false to choose it.
    pub keep_precision: bool,
}

/// Replicates of adaptive sampling. Few, since larger sets of samples are spread more evenly; at
/// least three, so that the variance of a pixel's sum of squares can be estimated.
pub const REPLICATES: u32 = 4;
/// Most samples of a pixel: the length of the sampler's sequence.
const MOST_SAMPLES: u32 = 1 << 16;
/// Greatest depth chosen.
pub const DEEPEST: u32 = 64;

/// State shared by all targets.
struct Task<'a> {
    renderer: &'a mut Renderer,
    scene: &'a Scene,
    settings: Settings,
    request: Request,
    limit: RadianceLimit,
    observer: Forward<'a>,
}

/// Renders `scene` for `request`. If cancelled, returns the image so far.
///
/// # Errors
/// As [`Renderer::render`].
pub fn render(
    renderer: &mut Renderer,
    scene: &Scene,
    settings: &Settings,
    request: &Request,
    observer: &mut dyn Observer,
) -> Result<Known, RenderError> {
    resume(renderer, scene, settings, request, None, observer)
}

/// Continues an earlier, interrupted render; image and error are the same, bit for bit, as without
/// the interruption. A render with a time target cannot be continued.
///
/// # Errors
/// As [`render()`]; also if `earlier` belongs to another request, scene, device or program.
pub fn resume(
    renderer: &mut Renderer,
    scene: &Scene,
    settings: &Settings,
    request: &Request,
    earlier: Option<ResumeState<Bounded>>,
    observer: &mut dyn Observer,
) -> Result<Known, RenderError> {
    let limit = radiance_limit(scene);
    let observer = Forward::new(observer);
    let task = Task { renderer, scene, settings: settings.clone(), request: *request, limit, observer };
    match request.target {
        Target::Settings => task.fixed(earlier),
        Target::Error(target) => task.until_error(target, earlier),
        Target::Time { .. } if earlier.is_some() => {
            Err(Mismatch("a render with --time goes on from no other".into()).into())
        }
        Target::Time { seconds, from, layers } => task.until_time(seconds, from, layers),
    }
}

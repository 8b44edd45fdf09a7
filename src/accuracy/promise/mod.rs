//! Images with a known error: at settings as they are (`--budget`), to an error (`--error`), or in a time
//! (`--time`).
//!
//! ```text
//! truncation_choice ─ depth and weight cut, from a survey of a few pixels
//! rounding ─ precision, from the same samples in f64
//! allocate ─ samples where they help most ─▶ image, and its budget
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

/// What is wanted of an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// The settings as they are, and what error they leave.
    Settings,
    /// This RMSE at most.
    Error(f64),
    /// The least error in this time.
    Time {
        /// Seconds of wall time, with everything.
        seconds: f64,
        /// When it began.
        from: Instant,
        /// How many layers are painted of it then: that takes time, too.
        layers: u32,
    },
}

/// What is asked for, and what is left open.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Request {
    /// What is wanted.
    pub target: Target,
    /// With what confidence, in (0, 1).
    pub confidence: f64,
    /// The depth of the settings is kept; else it is chosen.
    pub keep_depth: bool,
    /// The precision of the settings is kept; else it is chosen.
    pub keep_precision: bool,
}

/// Independent sets that adaptive samples are dealt to. Few, since an evenly spread set gains from being
/// large; but from three on the spread of a sum of squares over a pixel's replicates can be told.
pub const REPLICATES: u32 = 4;
/// Most samples of a pixel: as many as the sampler's points are spread evenly over.
const MOST_SAMPLES: u32 = 1 << 16;
/// Greatest depth that is chosen.
pub const DEEPEST: u32 = 64;

/// What every way to an image needs.
struct Task<'a> {
    renderer: &'a mut Renderer,
    scene: &'a Scene,
    settings: Settings,
    request: Request,
    limit: RadianceLimit,
    observer: Forward<'a>,
}

/// Renders `scene` as `request` says. A cancelled render gives what there is.
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

/// Renders what an earlier, interrupted one left; image and error are the same, bit for bit, as if it had not
/// been interrupted. A time is never gone on with.
///
/// # Errors
/// As [`render()`]; also if `earlier` is of another request, scene, device or program.
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

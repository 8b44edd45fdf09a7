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

pub use bounded_image::{BoundedImage, Layer};
pub use resume_state::UnfinishedBounded;
pub(crate) use resume_state::is_kept;
pub use until_time::LATE;

use super::radiance_bound::{RadianceLimit, radiance_limit};
use crate::render::{Observer, Quiet, RenderError, Renderer};
use crate::scene::Scene;
use crate::settings::Settings;
use monotone_progress::Forward;
use std::time::{Duration, Instant};

/// What is wanted of an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// The settings as they are, and a bound on the error that they leave.
    Settings,
    /// An RMSE of at most this, in linear light clamped to [0, 1].
    Error(f64),
    /// The least error in this time.
    Time {
        /// Seconds of wall time, writing the image included.
        seconds: f64,
        /// When the time begins.
        from: Instant,
        /// Layers that the caller paints afterwards: time is set aside for them.
        layers: u32,
    },
}

/// What is asked of a bounded image, and what is left open.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Request {
    /// What is wanted.
    pub target: Target,
    /// Confidence of the bound, in (0, 1).
    pub confidence: f64,
    /// True: the depth of the settings is kept. False: it is chosen, unless the target is the settings themselves.
    pub keep_depth: bool,
    /// True: the precision of the settings is kept. False: it is chosen.
    pub keep_precision: bool,
}

impl Request {
    /// An RMSE of at most `error` with 95 % confidence; depth, precision and samples are chosen.
    pub fn error(error: f64) -> Request {
        Request::new(Target::Error(error))
    }

    /// The least error in `time` from now on, with 95 % confidence; depth, precision and samples are chosen.
    pub fn time(time: Duration) -> Request {
        Request::new(Target::Time { seconds: time.as_secs_f64(), from: Instant::now(), layers: 0 })
    }

    /// The settings as they are, and a bound on the error that they leave, with 95 % confidence.
    pub fn settings() -> Request {
        Request::new(Target::Settings)
    }

    fn new(target: Target) -> Request {
        Request { target, confidence: 0.95, keep_depth: false, keep_precision: false }
    }
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

impl Renderer {
    /// Renders `scene` to what `request` asks, and bounds the image's error.
    ///
    /// # Errors
    /// As [`Renderer::render`]; also [`RenderError::OneSample`] if the settings are to be kept and have one sample a
    /// pixel. A target that cannot be reached is no error: the report says so in `asked`.
    pub fn render_bounded(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        request: &Request,
    ) -> Result<BoundedImage, RenderError> {
        self.render_bounded_with(scene, settings, request, &mut Quiet)
    }

    /// As [`Renderer::render_bounded`], under an observer. A cancelled render gives what there is.
    ///
    /// # Errors
    /// As [`Renderer::render_bounded`].
    pub fn render_bounded_with(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        request: &Request,
        observer: &mut dyn Observer,
    ) -> Result<BoundedImage, RenderError> {
        self.finish_bounded(scene, settings, request, None, observer)
    }

    /// Renders what an earlier, interrupted render left; image and error are the same, bit for bit, as if it had not
    /// been interrupted. A render for a time cannot be resumed.
    ///
    /// # Errors
    /// As [`Renderer::render_bounded`]; also [`RenderError::Mismatch`] if `earlier` is of another request, scene,
    /// device or program.
    pub fn resume_bounded(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        request: &Request,
        earlier: UnfinishedBounded,
        observer: &mut dyn Observer,
    ) -> Result<BoundedImage, RenderError> {
        earlier.check(request)?;
        self.finish_bounded(scene, settings, request, Some(earlier), observer)
    }

    fn finish_bounded(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        request: &Request,
        earlier: Option<UnfinishedBounded>,
        observer: &mut dyn Observer,
    ) -> Result<BoundedImage, RenderError> {
        let limit = radiance_limit(scene);
        let observer = Forward::new(observer);
        let mut settings = settings.clone();
        if request.target == Target::Settings && settings.replicates < 2 {
            settings.replicates = replicates(settings.samples, REPLICATES);
            if settings.replicates < 2 {
                return Err(RenderError::OneSample);
            }
        }
        let task = Task { renderer: self, scene, settings, request: *request, limit, observer };
        let mut image = match request.target {
            Target::Settings => task.fixed(earlier),
            Target::Error(target) => task.until_error(target, earlier),
            Target::Time { seconds, from, layers } => task.until_time(seconds, from, layers),
        }?;
        if let Some(unfinished) = &mut image.unfinished {
            unfinished.begun.time = image.report.time.clone();
        }
        Ok(image)
    }
}

/// Replicates for `samples` samples of a pixel: the largest number up to `most` that divides them; of a prime, all.
pub(crate) fn replicates(samples: u32, most: u32) -> u32 {
    (2..=most.min(samples)).rev().find(|r| samples.is_multiple_of(*r)).unwrap_or(samples)
}

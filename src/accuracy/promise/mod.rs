//! Images with an error bound: with given settings (`--budget`), to a given error (`--error`), or
//! in a given time (`--time`).
//!
//! ```text
//! truncation_choice ─ depth and cutoff, from a survey of a few pixels
//! longer_paths ─ what rays beyond them would add, from drawn pixels
//! rounding ─ precision, from the same samples in f64
//! allocate ─ samples where they reduce the error most ─▶ image and error bound
//! ```

mod bounded_image;
mod fixed;
mod longer_paths;
mod monotone_progress;
mod plain_in_time;
mod resume_state;
mod rounding;
mod settled;
mod traced;
mod truncation_choice;
mod until_error;
mod until_time;
mod watched;

pub use bounded_image::{BoundedImage, Layer};
pub use resume_state::Bounded;
pub use settled::Settled;
pub use until_time::LATE;

use super::bright;
use super::radiance_bound::{RadianceLimit, radiance_limit};
use super::unseen::Caps;
use crate::image::Format;
use crate::render::{Observer, Quiet, RenderError, Renderer, ResumeState, Survey};
use crate::report::TimeInfo;
use crate::scene::Scene;
use crate::settings::{Settings, SettingsError};
use monotone_progress::MonotoneProgress;
use std::time::{Duration, Instant};

/// Target of a render.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// The given settings; the error is only bounded.
    Settings,
    /// An RMSE of at most this, in linear light clamped to [0, 1].
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

/// What is asked of a bounded image: target, confidence, and which settings may be chosen.
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
    /// Format of the file to be written, whose error is then part of the image's; `None` for the image itself.
    pub file: Option<Format>,
    /// True to keep the bits of `file`, false to take 16 where 8 lose too much.
    pub keep_bits: bool,
}

impl Request {
    /// An RMSE of at most `error` with 95 % confidence; depth, precision and samples are chosen.
    pub fn error(error: f64) -> Request {
        Request::to(Target::Error(error))
    }

    /// The least error in `time` from now on, with 95 % confidence; depth, precision and samples are chosen.
    pub fn time(time: Duration) -> Request {
        Request::to(Target::Time { seconds: time.as_secs_f64(), from: Instant::now(), layers: 0 })
    }

    /// The settings as they are, and a bound on the error that they leave, with 95 % confidence.
    pub fn settings() -> Request {
        Request::to(Target::Settings)
    }

    /// `target` with 95 % confidence, everything chosen, whatever the file.
    pub fn to(target: Target) -> Request {
        Request {
            target,
            confidence: 0.95,
            keep_depth: false,
            keep_precision: false,
            file: None,
            keep_bits: true,
        }
    }

    /// Checks that confidence, error and time are in their ranges.
    fn check(&self) -> Result<(), SettingsError> {
        let positive = |x: f64| x > 0.0 && x.is_finite();
        match self.target {
            _ if !(self.confidence > 0.0 && self.confidence < 1.0) => {
                Err(SettingsError::Confidence(self.confidence))
            }
            Target::Error(error) if !positive(error) => Err(SettingsError::Error(error)),
            Target::Time { seconds, .. } if !positive(seconds) => Err(SettingsError::Time(seconds)),
            _ => Ok(()),
        }
    }
}

/// Samples of a pixel that is looked at before cuts and precision are chosen, and of every pixel in `--time`.
pub const LOOK_SAMPLES: u32 = 4;
/// Most samples of a pixel: the length of the sampler's sequence.
const MOST_SAMPLES: u32 = 1 << 16;
/// Greatest depth chosen: that of the scene format.
pub const DEEPEST: u32 = crate::scene::MAX_DEPTH;

/// State shared by all targets.
struct Task<'a> {
    renderer: &'a mut Renderer,
    scene: &'a Scene,
    settings: Settings,
    request: Request,
    limit: RadianceLimit,
    caps: Caps,
    observer: MonotoneProgress<'a>,
    took: Took,
}

/// What the device was made ready for, and when the render began; what is prepared later moves its start.
#[derive(Debug, Clone, Copy)]
struct Took {
    /// Packing and planning.
    built: Duration,
    /// Opening the device, kernels and buffers.
    prepared: Duration,
    /// When the first ray was submitted, and as much later as other kernels took to prepare since.
    start: Instant,
}

impl Took {
    fn nothing() -> Took {
        Took { built: Duration::ZERO, prepared: Duration::ZERO, start: Instant::now() }
    }

    /// The times up to now.
    fn so_far(&self) -> TimeInfo {
        let (build, first_dispatch) = (self.built.as_secs_f64(), self.prepared.as_secs_f64());
        let render = self.start.elapsed().as_secs_f64();
        let wall = build + first_dispatch + render;
        TimeInfo { wall, build, first_dispatch, render, ..TimeInfo::default() }
    }
}

impl Task<'_> {
    /// A survey of the scene under `settings`; the time to prepare it is not the render's.
    fn survey(&mut self, settings: &Settings) -> Result<Survey, RenderError> {
        let begin = Instant::now();
        let survey = Survey::new(self.renderer, self.scene, settings)?;
        self.took.built += survey.built();
        self.took.prepared += survey.prepared();
        self.took.start += begin.elapsed();
        Ok(survey)
    }
}

impl Renderer {
    /// Renders `scene` to what `request` asks, and bounds the image's error.
    ///
    /// # Errors
    /// As [`Renderer::render`]; also [`RenderError::Settings`] if the request is outside its ranges, or the settings
    /// are to be kept and have one sample a pixel. A target that cannot be reached is no error: the report says so in
    /// `asked`.
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
    /// been interrupted. A render for a time goes on for what is left of it, with all samples that it has.
    ///
    /// # Errors
    /// As [`Renderer::render_bounded`]; also [`RenderError::Mismatch`] if `earlier` is of another request, scene,
    /// device or program.
    pub fn resume_bounded(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        request: &Request,
        earlier: ResumeState<Bounded>,
        observer: &mut dyn Observer,
    ) -> Result<BoundedImage, RenderError> {
        self.finish_bounded(scene, settings, request, Some(earlier), observer)
    }

    fn finish_bounded(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        request: &Request,
        earlier: Option<ResumeState<Bounded>>,
        observer: &mut dyn Observer,
    ) -> Result<BoundedImage, RenderError> {
        let limit = radiance_limit(scene);
        let observer = MonotoneProgress::new(observer);
        let settings = settings.clone();
        settings.check()?;
        request.check()?;
        if request.target == Target::Settings {
            let (samples, replicates) = (settings.samples, settings.replicates.max(1));
            if samples < 2 || !samples.is_multiple_of(replicates) {
                return Err(SettingsError::Replicates(replicates, samples).into());
            }
        }
        let caps = bright::caps(scene, &settings, &limit);
        let took = Took::nothing();
        let task = Task { renderer: self, scene, settings, request: *request, limit, caps, observer, took };
        let mut image = match request.target {
            Target::Settings => task.fixed(earlier),
            Target::Error(target) => task.until_error(target, earlier),
            Target::Time { seconds, from, layers } => task.until_time(seconds, from, layers, earlier),
        }?;
        if let Some(unfinished) = &mut image.unfinished {
            unfinished.time = image.report.time.clone();
        }
        Ok(image)
    }
}

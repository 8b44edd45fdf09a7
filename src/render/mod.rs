//! Settings and a scene in, an image and a report out.

mod batches;
mod checkpoints;
mod compiled;
mod convergence;
mod draw;
mod error;
mod film;
mod identity;
mod merge;
mod parts;
mod pixel_tests;
mod precision;
mod prepared;
mod resume_state;
pub mod samples;
pub mod self_test;
mod submit_log;
mod surface_layers;
mod survey;
mod tally;
mod trial;
mod upload;
mod variants;

pub(crate) use batches::mean;
pub use checkpoints::{Checkpoints, Write};
pub(crate) use compiled::compiled;
pub use convergence::Convergence;
pub use error::RenderError;
pub use film::Sums;
pub use identity::{Identity, Mismatch};
pub use merge::{Merge, MergeError};
pub(crate) use prepared::Built;
pub use prepared::Prepared;
pub use resume_state::{Kind, Payload, ResumeState, State};
pub use surface_layers::{SurfaceLayer, Surfaces};
pub use survey::Survey;
pub use trial::{Run, Trial};

use crate::image::{self, SaveError, View};
#[cfg(feature = "defects")]
use crate::kernel::defects::Defect;
use crate::kernel::table::KernelSet;
use crate::plan::explain::explain;
use crate::plan::host_memory::{self, HostWork};
use crate::plan::{Plan, PlannedScene, Purpose};
use crate::prepare::Recipe;
use crate::prepare::local_frame::LocalFrame;
use crate::report::Report;
use crate::report::explain::ExplainedPlan;
use crate::scene::Scene;
use crate::settings::{DeviceChoice, Precision, Settings};
use crate::vk::{Device, Pipelines};
pub(crate) use batches::Batches;
use precision::Chosen;
use self_test::SelfTest;
use std::path::Path;
use std::rc::Rc;
use std::time::{Duration, Instant};
use variants::Variants;

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
    /// Everything that was counted and timed, the earlier part of a resumed render included. The image has no file
    /// name yet.
    pub report: Report,
    /// What [`Renderer::resume`] needs to go on, and [`Renderer::more`] to add samples; absent if there is no sample.
    pub state: Option<ResumeState<Sums>>,
}

impl Rendered {
    /// Writes the image as a PNG of 8 bits, an OpenEXR or a Radiance HDR file by the extension of `path`, whole or not
    /// at all. Program, scene, settings and device become its metadata. A PNG is clamped to [0, 1] and sRGB-encoded.
    ///
    /// # Errors
    /// If the extension is none of `.png`, `.exr`, `.hdr`, or the file cannot be written.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), SaveError> {
        let view = View { width: self.width, height: self.height, linear: &self.linear };
        image::save(path.as_ref(), view, &self.report, self.done)
    }

    /// Why the image is known to be wrong; `None` if nothing is: rays that were lost or not finite, or pixels beyond what
    /// single precision holds.
    pub fn fault(&self) -> Option<String> {
        self.report.counters.lost().or_else(|| not_finite(&self.linear))
    }
}

/// Why an image with pixels that are no finite numbers is wrong.
pub(crate) fn not_finite(linear: &[[f32; 3]]) -> Option<String> {
    let count = linear.iter().filter(|pixel| pixel.iter().any(|channel| !channel.is_finite())).count();
    (count > 0).then(|| format!("{} not finite: their error is unknown", are(count)))
}

/// "1 pixel is", "7 pixels are".
fn are(count: usize) -> String {
    let pixels = crate::units::plural(count as u64, "pixel");
    format!("{pixels} {}", if count == 1 { "is" } else { "are" })
}

/// Sees the progress of a render between submits, and may end it.
pub trait Observer {
    /// `done` of `total` units of work (samples) are finished.
    fn progress(&mut self, done: u64, total: u64);
    /// True once the render should stop after the submit in flight.
    fn cancelled(&self) -> bool;
    /// True to be given the image on its way, by [`Observer::image`]. A render with fixed settings then traces the whole
    /// image with 1, 2, 4, ... samples a pixel, up to the same bits as otherwise.
    fn watches(&self) -> bool {
        false
    }
    /// The image so far, after each round of samples, where [`Observer::watches`] is true; the last is the whole image.
    fn image(&mut self, _so_far: &ImageSoFar<'_>) {}
    /// True to be given the state of the render soon, by [`Observer::keep`].
    fn wants_state(&self) -> bool {
        false
    }
    /// The state of the render so far, from which it can go on if it ends now.
    fn keep(&mut self, _state: &dyn State) {}
}

/// An image on its way.
#[derive(Debug, Clone, Copy)]
pub struct ImageSoFar<'a> {
    /// Rows from the top, linear RGB, unclamped.
    pub linear: &'a [[f32; 3]],
    /// Samples per pixel, the mean over the image.
    pub samples: f64,
    /// Rays of all kinds so far.
    pub rays: u64,
    /// Seconds since the first submit.
    pub seconds: f64,
}

/// An observer that only lets things run.
pub struct Quiet;

impl Observer for Quiet {
    fn progress(&mut self, _done: u64, _total: u64) {}
    fn cancelled(&self) -> bool {
        false
    }
}

/// A device, ready to render.
pub struct Renderer {
    device: Rc<Device>,
    variants: Variants,
    arithmetic: SelfTest,
    opened: Duration,
    kernels: KernelSet,
    recipe: fn(&Scene) -> Recipe,
    brute_force: Option<bool>,
    poison: bool,
}

impl Renderer {
    /// Opens a device and tests its arithmetic, or takes the result of an earlier test from the cache folder.
    ///
    /// # Errors
    /// [`RenderError::NoDevice`] without a Vulkan 1.2 device like the one chosen; [`RenderError::Vulkan`],
    /// [`RenderError::OutOfMemory`] or [`RenderError::DeviceLost`] if the device fails its first work.
    pub fn new(choice: &DeviceChoice) -> Result<Renderer, RenderError> {
        Renderer::open(choice, false)
    }

    /// As [`Renderer::new`], under the Khronos validation layer, whose messages are kept for
    /// [`Renderer::validation_messages`].
    ///
    /// # Errors
    /// As [`Renderer::new`]; also [`RenderError::NoDevice`] if the layer is not installed.
    pub fn with_validation(choice: &DeviceChoice) -> Result<Renderer, RenderError> {
        Renderer::open(choice, true)
    }

    pub(crate) fn open(choice: &DeviceChoice, validate: bool) -> Result<Renderer, RenderError> {
        let start = Instant::now();
        let device = Rc::new(Device::new(choice, validate)?);
        let arithmetic = self_test::known(&device)?;
        Ok(Renderer {
            device,
            arithmetic,
            variants: Variants::default(),
            opened: start.elapsed(),
            kernels: KernelSet::SHIPPED,
            recipe: Recipe::of,
            brute_force: None,
            poison: false,
        })
    }

    /// What the device's arithmetic is worth.
    #[doc(hidden)]
    pub fn arithmetic(&self) -> &SelfTest {
        &self.arithmetic
    }

    /// The settings in force for `scene`, their precision settled, and what the user should know of it.
    pub(crate) fn settled(&self, scene: &Scene, asked: &Settings) -> (Settings, Vec<String>) {
        self.trusted(asked, &self.recipe(scene))
    }

    /// The settings that this device can keep for a scene packed by `recipe`, its precision settled, and what the user
    /// should know of it.
    pub(crate) fn trusted(&self, asked: &Settings, recipe: &Recipe) -> (Settings, Vec<String>) {
        let (single, double) = (self.arithmetic.single.faults(), self.arithmetic.double);
        let sound = double.is_some_and(|double| double.faults().is_empty());
        let chosen = Chosen { single: &single, sound_double: sound && self.device.has_double() };
        let near = recipe.local_frame.near.as_ref();
        let near = near.filter(|near| !near.single_is_enough(recipe.shape, asked));
        chosen.precision(asked, near.map(|near| (near, recipe.shape)))
    }

    /// Warnings and errors of the validation layer so far.
    pub fn validation_messages(&self) -> Vec<String> {
        self.device.validation_messages()
    }

    /// The device.
    #[doc(hidden)]
    pub fn device(&self) -> &Rc<Device> {
        &self.device
    }

    /// Tests every primitive (`true`) or walks the hierarchy (`false`), whatever the scene's size.
    #[doc(hidden)]
    pub fn force_brute_force(&mut self, brute_force: Option<bool>) {
        self.brute_force = brute_force;
    }

    pub(crate) fn forced_brute_force(&self) -> Option<bool> {
        self.brute_force
    }

    /// How `scene` becomes arrays.
    pub(crate) fn recipe(&self, scene: &Scene) -> Recipe {
        (self.recipe)(scene)
    }

    /// The local frame of `scene` for rays that start anywhere.
    pub(crate) fn local_frame(&self, scene: &Scene) -> LocalFrame {
        self.recipe(scene).for_any_ray(scene).local_frame
    }

    /// From now on renders with a mistake; with [`Defect::Nothing`] by the set of kernels that has all
    /// of them, none switched on.
    #[cfg(feature = "defects")]
    #[doc(hidden)]
    pub fn plant(&mut self, defect: Defect) {
        self.kernels = KernelSet::planted(defect);
        self.recipe = Recipe::planted(defect);
    }

    /// From now on renders without the barrier after `kernel`, for a test of the validation.
    #[cfg(feature = "defects")]
    #[doc(hidden)]
    pub fn omit_barrier_after(&mut self, kernel: crate::kernel::table::Kernel) {
        self.kernels = KernelSet::without_barrier_after(kernel);
        self.variants.clear();
    }

    /// Fills every buffer that the kernels write with NaN before each submit: a read of what was never
    /// written then shows in the image.
    #[doc(hidden)]
    pub fn poison_buffers(&mut self, poison: bool) {
        self.poison = poison;
    }

    /// Renders `scene`. Kernels stay compiled for the next render.
    ///
    /// # Errors
    /// [`RenderError::Settings`] if a setting is outside its range; [`RenderError::NoDouble`] if the settings ask for
    /// f64 and the device has none; [`RenderError::DoesNotFit`], [`RenderError::TooManyRays`] or [`RenderError::OutOfMemory`] if scene and
    /// settings need more than the device has; [`RenderError::DeviceLost`] or [`RenderError::Vulkan`] if it fails.
    pub fn render(&mut self, scene: &Scene, settings: &Settings) -> Result<Rendered, RenderError> {
        self.render_with(scene, settings, &mut Quiet)
    }

    /// Renders `scene` under an observer, which sees the progress and may cancel: [`Rendered::done`] is then below 1,
    /// and [`Rendered::state`] holds what [`Renderer::resume`] continues from.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn render_with(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        observer: &mut dyn Observer,
    ) -> Result<Rendered, RenderError> {
        self.prepare(scene, settings)?.render_with(observer)
    }

    /// Continues an earlier, interrupted render; the image is the same, bit for bit, as without the
    /// interruption. Rays and times are those of both parts together.
    ///
    /// # Errors
    /// As [`Renderer::render`]; also [`RenderError::Mismatch`] if `earlier` is of another scene, device, program, or
    /// of other settings that change the image.
    pub fn resume(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        earlier: ResumeState<Sums>,
        observer: &mut dyn Observer,
    ) -> Result<Rendered, RenderError> {
        self.prepare(scene, settings)?.resume(earlier, observer)
    }

    /// Adds samples to a finished picture of fewer, [`Rendered::state`]; the image is the same, bit for bit, as that of
    /// one render of all samples. Rays and times are those of both together.
    ///
    /// # Errors
    /// As [`Renderer::resume`]; also if `earlier` has more samples a pixel, or only one.
    pub fn more(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        earlier: ResumeState<Sums>,
        observer: &mut dyn Observer,
    ) -> Result<Rendered, RenderError> {
        self.prepare(scene, settings)?.more(earlier, observer)
    }

    /// Makes `scene` ready under `settings`, for one or several renders of the same image.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn prepare(&mut self, scene: &Scene, settings: &Settings) -> Result<Prepared, RenderError> {
        settings.check()?;
        let built = self.build(scene, settings, Purpose::Image)?;
        self.prepare_built(scene, built)
    }

    /// Packs and plans `scene` for this device. The plan may refuse; [`Renderer::prepare_built`] then fails.
    pub(crate) fn build(
        &self,
        scene: &Scene,
        settings: &Settings,
        purpose: Purpose,
    ) -> Result<Built, RenderError> {
        let start = Instant::now();
        let recipe = self.recipe(scene);
        let (settings, warnings) = self.trusted(settings, &recipe);
        self.check_precision(&settings)?;
        if purpose == Purpose::Survey {
            host_memory::check(settings.region(), HostWork::Image, 0, crate::host::memory::free())?;
        }
        let limits = self.device.limits();
        let planned = PlannedScene::with(recipe, scene, &settings, &limits, purpose, self.brute_force);
        Ok(Built::new(planned, warnings, start))
    }

    /// Explains what [`Renderer::build`] planned, refused or not; `file` is the scene's path as given.
    pub(crate) fn explain(&self, built: &Built, file: &str) -> ExplainedPlan {
        let PlannedScene { packed, settings, limits, .. } = &built.planned;
        explain(file, &self.device.info(), packed, settings, limits, built.planned.plan().ok())
    }

    /// Compiles kernels and fills buffers for what [`Renderer::build`] planned.
    pub(crate) fn prepare_built(&mut self, scene: &Scene, built: Built) -> Result<Prepared, RenderError> {
        let region = built.planned.settings.region();
        host_memory::check(region, HostWork::Image, 0, crate::host::memory::free())?;
        Prepared::new(self, scene, built)
    }

    pub(crate) fn check_precision(&self, settings: &Settings) -> Result<(), RenderError> {
        if settings.precision == Precision::Double && !self.device.has_double() {
            return Err(RenderError::NoDouble { device: self.device.info().name });
        }
        Ok(())
    }

    pub(crate) fn pipelines(
        &mut self,
        plan: &Plan,
        precision: Precision,
    ) -> Result<(Rc<Pipelines>, bool), RenderError> {
        let double = precision == Precision::Double;
        let (kernels, s) = (plan.kernels(), &plan.specialisation);
        let key = (double, kernels.clone(), self.kernels.values(s));
        if let Some(found) = self.variants.get(&key) {
            return Ok((found, false));
        }
        let built = Rc::new(Pipelines::new(&self.device, self.kernels, kernels.into_iter(), s, double)?);
        self.variants.keep(key, Rc::clone(&built));
        Ok((built, true))
    }
}

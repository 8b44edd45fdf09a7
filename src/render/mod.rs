//! Settings and a scene in, an image and a report out.

mod batches;
mod error;
mod resume_state;
pub mod samples;
pub mod self_test;
mod submit_log;
mod survey;
mod tally;
mod trial;
mod upload;

pub(crate) use batches::mean;
pub use error::RenderError;
pub use resume_state::{Begun, Mismatch, Unfinished};
pub use survey::Survey;
pub use trial::{Run, Share};

use crate::image::{self, SaveError, View, linear_sha256};
use crate::kernel::table::Kernel;
use crate::plan::{self, Plan};
use crate::prepare::coincident_solids;
use crate::prepare::{Packed, pack_forms};
use crate::report::timeline::{FrameTrace, Phase};
use crate::report::{Report, TimeInfo};
use crate::scene::Scene;
use crate::settings::{DeviceChoice, Precision, Settings};
use crate::vk::{Device, Pipelines};
use batches::Drawn;
pub(crate) use batches::Frame;
use resume_state::Identity;
use self_test::SelfTest;
use std::collections::BTreeMap;
use std::path::Path;
use std::rc::Rc;
use std::time::{Duration, Instant};

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
    /// What [`Renderer::resume`] needs to go on, if the render was interrupted after its first tile.
    pub unfinished: Option<Unfinished>,
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
}

/// Sees the progress of a render between submits, and may end it.
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

/// What kernels are compiled for: double precision or not, which they are, specialisation constants by id.
type Variant = (bool, Vec<Kernel>, Vec<(u32, u32)>);

/// A device, ready to render.
pub struct Renderer {
    device: Rc<Device>,
    /// Kernel variants built so far, by precision and specialisation.
    variants: BTreeMap<Variant, Rc<Pipelines>>,
    arithmetic: SelfTest,
    opened: Duration,
    brute_force: Option<bool>,
    omitted_barrier: Option<Kernel>,
    poison: bool,
    keep_submits: bool,
    trace: FrameTrace,
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
            variants: BTreeMap::new(),
            opened: start.elapsed(),
            brute_force: None,
            omitted_barrier: None,
            poison: false,
            keep_submits: false,
            trace: FrameTrace::default(),
        })
    }

    /// What the device's arithmetic is worth.
    pub fn arithmetic(&self) -> &SelfTest {
        &self.arithmetic
    }

    /// The settings that this device can keep, and why they differ from those asked for.
    pub(crate) fn trusted(&self, asked: &Settings) -> (Settings, Vec<String>) {
        let faults = self.arithmetic.single.faults();
        if asked.precision != Precision::Robust || faults.is_empty() {
            return (asked.clone(), Vec::new());
        }
        let why = faults.join("; ");
        match self.arithmetic.double {
            Some(double) if double.faults().is_empty() => (
                Settings { precision: Precision::Double, ..asked.clone() },
                vec![format!("rendered in f64, as this device's f32 cannot be trusted: {why}")],
            ),
            _ => (
                asked.clone(),
                vec![format!("bounds may not hold, as this device's f32 cannot be trusted: {why}")],
            ),
        }
    }

    /// Warnings and errors of the validation layer so far.
    pub fn validation_messages(&self) -> Vec<String> {
        self.device.validation_messages()
    }

    /// The device.
    pub fn device(&self) -> &Rc<Device> {
        &self.device
    }

    /// Tests every primitive (`true`) or walks the hierarchy (`false`), whatever the scene's size.
    pub fn force_brute_force(&mut self, brute_force: Option<bool>) {
        self.brute_force = brute_force;
    }

    /// The scene as this device's kernels need it, for an image or (`survey`) for listed pixels.
    pub(crate) fn pack(&self, scene: &Scene, settings: &Settings, survey: bool) -> Packed {
        let limits = self.device.limits();
        let max = plan::brute_force_max(self.brute_force, settings, &limits, survey);
        pack_forms(scene, settings, max, limits.forms(settings))
    }

    pub(crate) fn forced_brute_force(&self) -> Option<bool> {
        self.brute_force
    }

    /// Plants a missing barrier, for a test of the validation.
    pub fn omit_barrier_after(&mut self, kernel: Option<Kernel>) {
        self.omitted_barrier = kernel;
    }

    /// Fills every buffer that the kernels write with NaN before each submit: a read of what was never
    /// written then shows in the image.
    pub fn poison_buffers(&mut self, poison: bool) {
        self.poison = poison;
    }

    /// Keeps the submits of each render for [`Renderer::take_trace`], and puts only one batch in each, so
    /// that the items of every dispatch are known.
    pub fn keep_submits(&mut self, keep: bool) {
        self.keep_submits = keep;
    }

    /// When the phases of the last render began and ended, and its submits if they were kept.
    pub fn take_trace(&mut self) -> FrameTrace {
        std::mem::take(&mut self.trace)
    }

    /// Renders `scene`. Pipelines are kept for the next render with the same kernels.
    ///
    /// # Errors
    /// [`RenderError::NoDouble`] if the settings ask for f64 and the device has none;
    /// [`RenderError::DoesNotFit`], [`RenderError::TooManyRays`] or [`RenderError::OutOfMemory`] if scene and
    /// settings need more than the device has; [`RenderError::DeviceLost`] or [`RenderError::Vulkan`] if it fails.
    pub fn render(&mut self, scene: &Scene, settings: &Settings) -> Result<Rendered, RenderError> {
        self.render_with(scene, settings, &mut Quiet)
    }

    /// Renders `scene` under an observer, which sees the progress and may cancel: [`Rendered::done`] is then below 1,
    /// and [`Rendered::unfinished`] may hold what [`Renderer::resume`] continues from.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn render_with(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        observer: &mut dyn Observer,
    ) -> Result<Rendered, RenderError> {
        self.finish(scene, settings, None, observer)
    }

    /// Renders what an earlier, interrupted render left; the image is the same, bit for bit, as if it
    /// had not been interrupted. Rays and times are those of both parts together.
    ///
    /// # Errors
    /// As [`Renderer::render`]; also [`RenderError::Mismatch`] if `earlier` is of another scene, device, program, or
    /// of other settings that change the image.
    pub fn resume(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        earlier: Unfinished,
        observer: &mut dyn Observer,
    ) -> Result<Rendered, RenderError> {
        self.finish(scene, settings, Some(earlier), observer)
    }

    fn finish(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        earlier: Option<Unfinished>,
        observer: &mut dyn Observer,
    ) -> Result<Rendered, RenderError> {
        let began = Instant::now();
        let opened = std::mem::take(&mut self.opened);
        let start = began;
        let (settings, warnings) = self.trusted(settings);
        let settings = &settings;
        self.check_precision(settings)?;
        let packed = self.pack(scene, settings, false);
        let plan = Plan::new(&packed, settings, &self.device.limits())?;
        let device = self.device.info();
        let identity = || Identity::new(&device, &packed, scene, settings);
        let (mut drawn, before) = match earlier {
            None => (Drawn::new(settings), TimeInfo::default()),
            Some(earlier) => earlier.into_drawn(&identity())?,
        };
        let built = start.elapsed();
        let mut trace = FrameTrace::default();
        trace.phases.push(Phase::since("build", start));

        let start = Instant::now();
        let (pipelines, fresh) = self.pipelines(&plan, settings.precision)?;
        let mut frame = Frame::new(&self.device, pipelines, &packed, scene, settings, &plan)?;
        frame.recorder.omit_barrier_after(self.omitted_barrier);
        frame.poison = self.poison;
        if fresh {
            frame.warm_up()?;
        }
        frame.trace = self.keep_submits.then(Vec::new);
        trace.phases.push(Phase::since(if fresh { "first dispatch" } else { "upload" }, start));
        let first_dispatch = start.elapsed() + opened;

        let start = Instant::now();
        let (done, cut) = frame.render(&mut drawn, observer)?;
        let render = start.elapsed();
        trace.phases.push(Phase::since("render", start));
        trace.submits = frame.trace.take().unwrap_or_default();
        self.trace = trace;
        let mut tally = drawn.tally.clone();
        tally.add(&cut);
        let mut report = tally.report(settings, &packed, &plan);
        report.time = TimeInfo {
            wall: before.wall + (scene.read_time.0 + opened + began.elapsed()).as_secs_f64(),
            scene: before.scene + scene.read_time.0.as_secs_f64(),
            build: before.build + built.as_secs_f64(),
            first_dispatch: before.first_dispatch + first_dispatch.as_secs_f64(),
            device: report.passes.iter().map(|p| p.seconds).sum(),
            render: before.render + render.as_secs_f64(),
        };
        let [x0, y0, x1, y1] = settings.region();
        let (width, height) = (x1 - x0, y1 - y0);
        let unfinished = (done < 1.0 && !drawn.finished.is_empty())
            .then(|| Unfinished::new(identity(), report.time.clone(), &drawn));
        report.device = device;
        report.scene.file = scene.file.display().to_string();
        report.image.linear_sha256 = linear_sha256(&drawn.linear);
        report.warnings = warnings;
        report.warnings.extend(coincident_solids::warnings(scene));
        Ok(Rendered { width, height, linear: drawn.linear, done, report, unfinished })
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
        let key = (double, kernels.clone(), s.values());
        if let Some(found) = self.variants.get(&key) {
            return Ok((Rc::clone(found), false));
        }
        let built = Rc::new(Pipelines::new(&self.device, kernels.into_iter(), s, double)?);
        self.variants.insert(key, Rc::clone(&built));
        Ok((built, true))
    }
}

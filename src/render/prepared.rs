//! A scene made ready on a device: packed, planned, its kernels compiled, its buffers filled. Made once, by
//! [`Renderer::prepare`]; rendering, resuming and trials start from it and may do so several times.

use super::batches::Batches;
use super::film::Drawn;
use super::identity::Identity;
use super::tally::{self, Tally};
use super::{Observer, Quiet, RenderError, Rendered, Renderer, ResumeState, Sums};
use crate::image::linear_sha256;
use crate::kernel::abi::double::Camera;
use crate::plan::explain::explain;
use crate::plan::{Plan, PlannedScene};
use crate::prepare::{Packed, coincident_solids};
use crate::report::explain::ExplainedPlan;
use crate::report::timeline::{Phase, RenderTimeline};
use crate::report::{DeviceInfo, Report, TimeInfo};
use crate::scene::Scene;
use crate::settings::Settings;
use std::time::{Duration, Instant};

/// Arrays, plan, kernels and buffers of a scene under fixed settings.
pub struct Prepared {
    pub(crate) batches: Batches,
    pub(super) planned: PlannedScene,
    pub(super) camera: Camera,
    pub(super) device: DeviceInfo,
    /// What the user should know of the image to come.
    pub(super) warnings: Vec<String>,
    /// The scene's file, as given.
    pub(super) file: String,
    /// The scene's notes, a line each.
    notes: Vec<String>,
    /// Time that went into reading the scene.
    pub(super) read: Duration,
    /// Time that went into packing and planning.
    pub(super) built: Duration,
    /// Time that went into opening the device, kernels and buffers.
    pub(super) prepared: Duration,
    /// Phases not yet taken ([`Prepared::take_timeline`]).
    trace: RenderTimeline,
}

/// A scene packed and planned for a device, and what that took.
pub(crate) struct Built {
    pub(crate) planned: PlannedScene,
    warnings: Vec<String>,
    start: Instant,
    seconds: Duration,
}

impl Built {
    /// What the user should know of the image to come.
    pub(crate) fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// `planned`, begun at `start`.
    pub(super) fn new(planned: PlannedScene, warnings: Vec<String>, start: Instant) -> Built {
        Built { planned, warnings, start, seconds: start.elapsed() }
    }
}

impl Prepared {
    pub(super) fn new(renderer: &mut Renderer, scene: &Scene, built: Built) -> Result<Prepared, RenderError> {
        let Built { planned, mut warnings, start, seconds } = built;
        let mut trace = RenderTimeline::default();
        trace.phases.push(Phase { end: start + seconds, ..Phase::since("build", start) });
        let start = Instant::now();
        let plan = planned.plan()?;
        let settings = &planned.settings;
        let (pipelines, fresh) = renderer.pipelines(plan, settings.precision)?;
        let camera = planned.packed.camera(scene, settings);
        let mut batches = Batches::new(&renderer.device, pipelines, &planned.packed, camera, settings, plan)?;
        batches.poisoned = renderer.poison;
        if fresh {
            batches.warm_up()?;
        }
        trace.phases.push(Phase::since(if fresh { "first dispatch" } else { "upload" }, start));
        warnings.extend(renderer.device.notes().iter().cloned());
        warnings.extend(coincident_solids::warnings(scene));
        Ok(Prepared {
            batches,
            planned,
            camera,
            device: renderer.device.info(),
            warnings,
            file: scene.file.display().to_string(),
            notes: scene.notes.lines(),
            read: scene.read_time.0,
            built: seconds,
            prepared: start.elapsed() + std::mem::take(&mut renderer.opened),
            trace,
        })
    }

    /// The plan.
    #[doc(hidden)]
    pub fn plan(&self) -> &Plan {
        &self.batches.plan
    }

    /// The scene's arrays.
    #[doc(hidden)]
    pub fn packed(&self) -> &Packed {
        &self.planned.packed
    }

    /// The settings in force: those asked for, or what the device can keep of them.
    pub fn settings(&self) -> &Settings {
        &self.planned.settings
    }

    /// What the user should know of the image to come.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Seconds from scene to filled buffers.
    pub fn seconds(&self) -> f64 {
        (self.built + self.prepared).as_secs_f64()
    }

    /// Bytes that the buffers took on the device and the host.
    #[doc(hidden)]
    pub fn bytes_taken(&self) -> u64 {
        self.batches.buffers.taken()
    }

    /// The plan explained; `file` is the scene's path as given.
    #[doc(hidden)]
    pub fn explain(&self, file: &str) -> ExplainedPlan {
        let PlannedScene { packed, settings, limits, .. } = &self.planned;
        explain(file, &self.device, packed, settings, limits, Some(self.plan()))
    }

    /// Keeps the submits of the renders to come for [`Prepared::take_timeline`], one batch in each, so that the items
    /// of every dispatch are known.
    #[doc(hidden)]
    pub fn keep_submits(&mut self, keep: bool) {
        self.batches.trace = keep.then(Vec::new);
    }

    /// When phases began and ended since the last call, and the submits if they were kept.
    #[doc(hidden)]
    pub fn take_timeline(&mut self) -> RenderTimeline {
        std::mem::take(&mut self.trace)
    }

    /// Everything that the bits of the image depend on.
    pub(super) fn identity(&self) -> Identity {
        Identity::new(&self.device, self.packed(), self.camera, self.settings(), String::new())
    }

    /// Renders the image. Times of preparation in the report are those of this `Prepared`.
    ///
    /// # Errors
    /// [`RenderError::DeviceLost`] or [`RenderError::Vulkan`] if the device fails; [`RenderError::TooManyRays`] if one
    /// sample needs more room than the plan has.
    pub fn render(&mut self) -> Result<Rendered, RenderError> {
        self.render_with(&mut Quiet)
    }

    /// As [`Prepared::render`], under an observer.
    ///
    /// # Errors
    /// As [`Prepared::render`].
    pub fn render_with(&mut self, observer: &mut dyn Observer) -> Result<Rendered, RenderError> {
        self.finish(None, observer)
    }

    /// Continues an earlier, interrupted render: the same bits as without the interruption. Rays and times are those
    /// of both parts together.
    ///
    /// # Errors
    /// As [`Prepared::render`]; also [`RenderError::Mismatch`] if `earlier` is of another render.
    pub fn resume(
        &mut self,
        earlier: ResumeState<Sums>,
        observer: &mut dyn Observer,
    ) -> Result<Rendered, RenderError> {
        self.finish(Some(earlier), observer)
    }

    /// Adds samples to a finished picture of fewer: the same bits as of one render of all samples. Rays and times are
    /// those of both.
    ///
    /// # Errors
    /// As [`Prepared::resume`]; also [`RenderError::Mismatch`] if `earlier` has more samples, or only one: that one lies
    /// at the pixel's centre, where none of several does.
    pub fn more(
        &mut self,
        mut earlier: ResumeState<Sums>,
        observer: &mut dyn Observer,
    ) -> Result<Rendered, RenderError> {
        let now = self.settings().samples;
        earlier.take_as_first(now)?;
        self.finish(Some(earlier), observer)
    }

    /// Nothing drawn yet.
    fn blank(&self) -> Drawn {
        let mut outline = tally::outline(self.settings(), self.packed(), self.plan());
        outline.device = self.device.clone();
        outline.scene.file = self.file.clone();
        outline.scene.notes = self.notes.clone();
        outline.warnings = self.warnings.clone();
        let (region, share) = (self.settings().region(), self.settings().schedule.share);
        let sets = self.plan().specialisation.film_sums();
        Drawn { sums: Sums::new(region, sets, share, outline), tally: Tally::default() }
    }

    fn finish(
        &mut self,
        earlier: Option<ResumeState<Sums>>,
        observer: &mut dyn Observer,
    ) -> Result<Rendered, RenderError> {
        let identity = self.identity();
        let mut drawn = self.blank();
        let mut time = TimeInfo::default();
        if let Some(earlier) = earlier {
            let (mut sums, tally, before) = earlier.into_parts(&identity)?;
            sums.check(drawn.sums.share)?;
            sums.outline = std::mem::take(&mut drawn.sums.outline);
            drawn = Drawn { sums, tally };
            time = before;
        }
        let preparation = self.read + self.built + self.prepared;
        time.add(&TimeInfo {
            wall: preparation.as_secs_f64(),
            scene: self.read.as_secs_f64(),
            build: self.built.as_secs_f64(),
            first_dispatch: self.prepared.as_secs_f64(),
            ..TimeInfo::default()
        });
        let start = Instant::now();
        self.batches.begin();
        let done = self.batches.draw(&mut drawn, observer, &mut |drawn, observer| {
            let mut state = state_of(std::mem::take(drawn), &identity, &time, start);
            observer.keep(&state);
            *drawn = Drawn { sums: std::mem::take(&mut state.payload), tally: state.tally };
        })?;
        self.trace.phases.push(Phase::since("render", start));
        if let Some(submits) = &mut self.batches.trace {
            self.trace.submits.append(submits);
        }
        let state = state_of(drawn, &identity, &time, start);
        Ok(rendered(state, done))
    }
}

/// The state of a render that began at `start`, after what took `before`.
fn state_of(drawn: Drawn, identity: &Identity, before: &TimeInfo, start: Instant) -> ResumeState<Sums> {
    let Drawn { sums, tally } = drawn;
    let render = start.elapsed().as_secs_f64();
    let mut time = before.clone();
    time.add(&TimeInfo { wall: render, render, ..TimeInfo::default() });
    time.device = tally.passes.values().map(|(_, seconds)| seconds).sum();
    ResumeState::new(identity.clone(), time, tally, sums)
}

/// Image and report of a state of which the share `done` is there.
pub(super) fn rendered(state: ResumeState<Sums>, done: f64) -> Rendered {
    let linear = state.payload.linear();
    let mut report = Report::clone(&state.payload.outline);
    state.tally.fill(&mut report);
    report.time = state.time.clone();
    report.image.linear_sha256 = linear_sha256(&linear);
    let [x0, y0, x1, y1] = report.settings.region();
    Rendered { width: x1 - x0, height: y1 - y0, linear, done, report, state: (done > 0.0).then_some(state) }
}

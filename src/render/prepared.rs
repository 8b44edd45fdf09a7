//! A scene made ready on a device: packed, planned, its kernels compiled, its buffers filled. Made once, by
//! [`Renderer::prepare`]; rendering, resuming and trials start from it and may do so several times.

use super::batches::{Batches, Drawn};
use super::identity::Identity;
use super::{Observer, Quiet, RenderError, Rendered, Renderer, ResumeState, Tiles};
use crate::image::linear_sha256;
use crate::kernel::abi::double::Camera;
use crate::plan::explain::explain;
use crate::plan::{Plan, PlannedScene};
use crate::prepare::{Packed, coincident_solids};
use crate::report::explain::ExplainedPlan;
use crate::report::timeline::{Phase, RenderTimeline};
use crate::report::{DeviceInfo, TimeInfo};
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
        earlier: ResumeState<Tiles>,
        observer: &mut dyn Observer,
    ) -> Result<Rendered, RenderError> {
        self.finish(Some(earlier), observer)
    }

    fn finish(
        &mut self,
        earlier: Option<ResumeState<Tiles>>,
        observer: &mut dyn Observer,
    ) -> Result<Rendered, RenderError> {
        let in_rounds = observer.watches() && earlier.is_none();
        let (mut drawn, before) = match earlier {
            None => (Drawn::new(self.settings()), TimeInfo::default()),
            Some(earlier) => earlier.into_drawn(&self.identity())?,
        };
        let start = Instant::now();
        self.batches.begin();
        let (done, cut) = match in_rounds {
            true => self.batches.render_in_rounds(&mut drawn, observer)?,
            false => self.batches.render(&mut drawn, observer)?,
        };
        let render = start.elapsed();
        self.trace.phases.push(Phase::since("render", start));
        if let Some(submits) = &mut self.batches.trace {
            self.trace.submits.append(submits);
        }
        let mut tally = drawn.tally.clone();
        tally.add(&cut);
        let mut report = tally.report(self.settings(), self.packed(), self.plan());
        let preparation = self.read + self.built + self.prepared;
        report.time = TimeInfo {
            wall: before.wall + (preparation + render).as_secs_f64(),
            scene: before.scene + self.read.as_secs_f64(),
            build: before.build + self.built.as_secs_f64(),
            first_dispatch: before.first_dispatch + self.prepared.as_secs_f64(),
            device: report.passes.iter().map(|p| p.seconds).sum(),
            render: before.render + render.as_secs_f64(),
        };
        let [x0, y0, x1, y1] = self.settings().region();
        let unfinished = (done < 1.0 && !drawn.finished.is_empty()).then(|| {
            let tiles = Tiles::of(&drawn, self.settings().region());
            ResumeState::new(self.identity(), report.time.clone(), drawn.tally.clone(), tiles)
        });
        report.device = self.device.clone();
        report.scene.file = self.file.clone();
        report.scene.notes = self.notes.clone();
        report.image.linear_sha256 = linear_sha256(&drawn.linear);
        report.warnings = self.warnings.clone();
        Ok(Rendered { width: x1 - x0, height: y1 - y0, linear: drawn.linear, done, report, unfinished })
    }
}

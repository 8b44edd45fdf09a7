//! Samples of listed pixels, told apart: the sums of each replicate, and what the paths did. What is
//! rendered to an error, or with one, is traced through here.

use super::frame::{End, Frame, Part, sum};
use super::tally::Tally;
use super::{Observer, RenderError, Renderer};
use crate::abi;
use crate::measure::samples::{Mark, Traced};
use crate::pack::{Packed, pack};
use crate::plan::Plan;
use crate::report::Report;
use crate::scene::Scene;
use crate::settings::{Precision, Settings};
use std::ops::Range;
use std::time::{Duration, Instant};

/// A scene on a device under fixed settings, whose pixels are traced on demand. Memory is taken once.
pub struct Survey {
    frame: Frame,
    packed: Packed,
    settings: Settings,
    /// Depth that memory was planned for.
    deepest: u32,
    /// Why its settings are others than were asked for.
    pub warnings: Vec<String>,
    tally: Tally,
    /// Rays that fit a batch; halved when a queue overflows.
    batch: u32,
    /// Time that went into packing and planning.
    pub built: Duration,
    /// Time that went into kernels and buffers.
    pub prepared: Duration,
}

impl Survey {
    /// Prepares the kernels for `scene`. `settings.samples` and `settings.crop` mean nothing here.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn new(renderer: &mut Renderer, scene: &Scene, settings: &Settings) -> Result<Survey, RenderError> {
        let start = Instant::now();
        // No sample lies at its pixel's centre by rule: one of many is all that a survey knows.
        let settings = Settings { samples: u32::MAX, crop: None, ..settings.clone() };
        let (settings, warnings) = renderer.trusted(&settings);
        renderer.check_precision(&settings)?;
        let packed = pack(scene, &settings, renderer.brute_force);
        let plan = Plan::survey(&packed, &settings, &renderer.device.limits())?;
        let built = start.elapsed();
        let start = Instant::now();
        let (pipelines, fresh) = renderer.pipelines(&plan.specialisation, settings.precision)?;
        let mut frame = Frame::new(&renderer.device, pipelines, &packed, scene, &settings, &plan)?;
        frame.poison = renderer.poison;
        if fresh {
            frame.warm_up()?;
        }
        let batch = plan.tile_pixels.saturating_mul(plan.batch_samples);
        let prepared = start.elapsed() + std::mem::take(&mut renderer.opened);
        let deepest = settings.depth;
        Ok(Survey {
            frame,
            packed,
            settings,
            deepest,
            warnings,
            tally: Tally::default(),
            batch,
            built,
            prepared,
        })
    }

    /// Rays, times and counts so far. Its image, device and warnings are the caller's to fill.
    pub fn report(&self) -> Report {
        self.tally.report(&self.settings, &self.packed, &self.frame.plan)
    }

    /// Replicates of every pixel.
    pub fn replicates(&self) -> usize {
        self.settings.replicates as usize
    }

    /// Arithmetic of its kernels.
    pub fn precision(&self) -> Precision {
        self.settings.precision
    }

    /// The settings in force.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Cuts paths at other places from now on. `depth` is at most that of the settings it began with.
    pub fn cut_at(&mut self, depth: u32, cutoff: f32) {
        self.settings.depth = depth.min(self.deepest);
        self.settings.cutoff = cutoff;
        self.frame.cut_at(self.settings.depth, cutoff);
    }

    /// Seconds of device work so far.
    pub fn device_seconds(&self) -> f64 {
        self.tally.passes.values().map(|(_, seconds)| seconds).sum()
    }

    /// Traces samples `samples` of each of `pixels` (row * width + column). If it is cancelled, only the
    /// first of them are there: as many as there are marks.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn trace(
        &mut self,
        pixels: &[u32],
        samples: Range<u32>,
        observer: &mut dyn Observer,
    ) -> Result<Traced, RenderError> {
        let replicates = self.settings.replicates as usize;
        let mut traced = Traced {
            replicates,
            sums: Vec::with_capacity(pixels.len() * replicates),
            marks: Vec::with_capacity(pixels.len()),
        };
        let each = u64::from(samples.end - samples.start);
        let total = pixels.len() as u64 * each;
        let mut parts: Vec<&[u32]> = pixels.chunks(self.frame.plan.tile_pixels as usize).rev().collect();
        while let Some(list) = parts.pop() {
            let count = list.len() as u32;
            self.frame.list(list)?;
            self.frame.batch_samples = (self.batch / count).clamp(1, abi::LOOP_CAP / 2);
            let part = Part::listed(self.settings.width, count);
            let done = traced.marks.len() as u64 * each;
            match self.frame.samples(&part, samples.clone(), observer, done, total)? {
                End::Done(n, _) if u64::from(n) < each => break,
                End::Done(_, more) => {
                    let (film, marks) = self.frame.film(count)?;
                    traced.sums.extend(film.iter().map(sum));
                    traced.marks.extend(marks.iter().map(mark));
                    self.tally.add(&more);
                }
                End::Overflow if self.frame.batch_samples > 1 => {
                    self.batch = (self.frame.batch_samples / 2).max(1).saturating_mul(count);
                    parts.push(list);
                }
                End::Overflow => {
                    if let [pixel] = list {
                        let width = self.settings.width;
                        return Err(self.frame.pixel_too_deep(pixel % width, pixel / width));
                    }
                    let (first, second) = list.split_at(list.len() / 2);
                    parts.extend([second, first]);
                }
            }
            if observer.cancelled() {
                break;
            }
        }
        Ok(traced)
    }
}

/// A mark as the host reads it.
fn mark(m: &abi::Mark) -> Mark {
    let cut = u64::from(m.cut_high) << 32 | u64::from(m.cut_low);
    Mark {
        hash_least: !m.hash_least_inverted,
        hash_most: m.hash_most,
        rays: m.rays,
        depth: m.depth,
        cut: cut as f64 / f64::from(abi::CUT_ONE),
    }
}

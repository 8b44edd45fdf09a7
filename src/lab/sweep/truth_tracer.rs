//! Tracers of the truth: the device in f64, or the oracle if the device has no f64.

use crate::compare::metrics::SizeMismatch;
use crate::reference::oracle::Oracle;
use crate::render::samples::{Mark, Source, Traced};
use crate::render::{Observer, RenderError, Renderer, Survey};
use crate::scene::Scene;
use crate::settings::Settings;
use rayon::prelude::*;
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Reason that a sweep ended early. Finished points are kept.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// The device failed, or cannot do what a point asks for.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// Interrupted.
    #[error("interrupted")]
    Stopped,
    /// A file cannot be read, written or understood.
    #[error("{}: {error}", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// Why.
        error: io::Error,
    },
    /// A stored picture is not of this sweep's size.
    #[error("a stored picture has the wrong size: {0}; start over with --fresh")]
    Size(#[from] SizeMismatch),
    /// A plot could not be drawn.
    #[error("a plot cannot be drawn: {0}")]
    Plot(String),
}

impl SweepError {
    /// With the file's name.
    pub(super) fn file(path: &Path) -> impl Fn(io::Error) -> SweepError + use<> {
        let path = path.to_owned();
        move |error| SweepError::File { path: path.clone(), error }
    }
}

/// A tracer of samples.
pub(super) enum Tracer {
    Device(Box<Survey>),
    Oracle(Box<Oracle>, Settings),
}

impl Tracer {
    /// `settings` at their own precision on the device, which must have it.
    pub(super) fn device(
        renderer: &mut Renderer,
        scene: &Scene,
        settings: &Settings,
    ) -> Result<Tracer, SweepError> {
        Ok(Tracer::Device(Box::new(Survey::new(renderer, scene, settings)?)))
    }

    /// The oracle, in f64 on the CPU. It does not measure truncation.
    pub(super) fn oracle(scene: &Scene, settings: &Settings) -> Tracer {
        // No sample lies at its pixel's centre by rule, as in surveys.
        let settings = Settings { samples: u32::MAX, crop: None, ..settings.clone() };
        Tracer::Oracle(Box::new(Oracle::new(scene)), settings)
    }
}

/// A tracer with its observer.
pub(super) struct Watched<'a> {
    pub(super) tracer: &'a mut Tracer,
    pub(super) replicates: u32,
    pub(super) observer: &'a mut dyn Observer,
}

/// Passes on cancellation, but no progress.
struct Silent<'a>(&'a dyn Observer);

impl Observer for Silent<'_> {
    fn progress(&mut self, _done: u64, _total: u64) {}
    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }
}

impl Source for Watched<'_> {
    type Error = SweepError;

    fn replicates(&self) -> usize {
        self.replicates as usize
    }

    fn trace(&mut self, pixels: &[u32], samples: Range<u32>) -> Result<Traced, SweepError> {
        match self.tracer {
            Tracer::Device(survey) => {
                let traced = survey.trace(pixels, samples, &mut Silent(self.observer))?;
                let whole = traced.marks.len() == pixels.len();
                if whole && !self.observer.cancelled() { Ok(traced) } else { Err(SweepError::Stopped) }
            }
            Tracer::Oracle(oracle, settings) => {
                let traced = by_oracle(oracle, settings, pixels, samples);
                if self.observer.cancelled() { Err(SweepError::Stopped) } else { Ok(traced) }
            }
        }
    }
}

fn by_oracle(oracle: &Oracle, settings: &Settings, pixels: &[u32], samples: Range<u32>) -> Traced {
    let replicates = settings.replicates as usize;
    let of_pixel = |pixel: &u32| {
        let mut sums = vec![[0.0; 3]; replicates];
        for k in samples.clone() {
            let (x, y) = (pixel % settings.width, pixel / settings.width);
            let light = oracle.sample(x, y, k, settings).radiance;
            let sum = &mut sums[k as usize % replicates];
            *sum = std::array::from_fn(|c| sum[c] + light[c]);
        }
        sums
    };
    let sums: Vec<[f64; 3]> = pixels.par_iter().flat_map_iter(of_pixel).collect();
    Traced { replicates, sums, marks: vec![Mark::default(); pixels.len()] }
}

//! What an image is judged by: the same pixels in f64, sampled until their own standard error is small beside
//! the errors that are judged.

use crate::accuracy::allocate::{Allocation, Goal};
use crate::accuracy::pixel_sums::Gathered;
use crate::accuracy::radiance_bound::RadianceLimit;
use crate::render::{Observer, RenderError, Renderer, Survey};
use crate::scene::Scene;
use crate::settings::{Precision, Settings};
use serde::Serialize;

/// Replicates of the truth: enough that their spread is known well.
const REPLICATES: u32 = 16;
/// Samples that every pixel gets, whatever its neighbours look like.
const LEAST_SAMPLES: u32 = 128;
/// Most samples of a pixel.
const MOST_SAMPLES: u32 = 1 << 14;
/// Depths tried where paths are to be followed to their ends.
const DEPTHS: [u32; 5] = [4, 8, 16, 32, 64];
/// No deeper from so many rays a sample on.
const MOST_RAYS: f64 = 256.0;
/// Share of the standard error sought that the cut of paths may come to.
const HIDDEN_SHARE: f64 = 0.5;
/// Share of the same that one ray may hide, where paths are followed to their ends.
const WEIGHT_SHARE: f64 = 0.1;
/// A standard error that no truth need be below: a hundredth of an 8-bit code.
const LEAST_ERROR: f64 = 4e-5;
/// Seed of every truth, apart from those of the images judged.
pub const SEED: u32 = 0x7275_7468;

/// What is asked of a truth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sought {
    /// Depth of the paths; `None` to follow them to their ends, as far as they matter.
    pub depth: Option<u32>,
    /// RMSE that it may have itself.
    pub standard_error: f64,
    /// Rays that it may take.
    pub most_rays: f64,
}

/// How good a truth is.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TruthInfo {
    /// Depth of its paths.
    pub depth: u32,
    /// Throughput below which its paths end.
    pub cutoff: f32,
    /// Estimate of its own RMSE.
    pub standard_error: f64,
    /// What the rays that it did not trace come to at most, as an RMSE.
    pub hidden: f64,
    /// Samples of a pixel in the mean.
    pub samples: f64,
    /// Arithmetic: f64 unless the device has none.
    pub precision: &'static str,
}

/// Means of pixels, all but exact.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// Linear RGB, unclamped, row by row.
    pub pixels: Vec<[f64; 3]>,
    /// How good it is.
    pub info: TruthInfo,
}

impl Truth {
    /// RMSE of `image` as shown: linear light clamped to [0, 1], all channels.
    pub fn error(&self, image: &Gathered) -> f64 {
        let shown = |x: f64| x.clamp(0.0, 1.0);
        let squares: f64 = (self.pixels.iter().enumerate())
            .map(|(at, truth)| {
                let mean = image.mean(at);
                (0..3).map(|c| (shown(mean[c]) - shown(truth[c])).powi(2)).sum::<f64>()
            })
            .sum();
        (squares / (3 * self.pixels.len().max(1)) as f64).sqrt()
    }
}

/// Finds the truth of the whole image of `settings` (size and, where none is sought, depth); `None` if cancelled.
///
/// # Errors
/// As [`Renderer::render`].
pub fn find(
    renderer: &mut Renderer,
    scene: &Scene,
    settings: &Settings,
    limit: &RadianceLimit,
    sought: &Sought,
    observer: &mut dyn Observer,
) -> Result<Option<Truth>, RenderError> {
    let target = sought.standard_error.max(LEAST_ERROR);
    let double = renderer.device().has_double();
    let deepest = sought.depth.unwrap_or(DEPTHS[DEPTHS.len() - 1]);
    let settings = Settings {
        depth: deepest,
        cutoff: 0.0,
        replicates: REPLICATES,
        seed: SEED,
        crop: None,
        precision: if double { Precision::Double } else { Precision::Robust },
        ..settings.clone()
    };
    let mut survey = Survey::new(renderer, scene, &settings)?;
    if sought.depth.is_none() {
        let brightest = limit.rgb.iter().fold(1.0, |m: f64, c| m.max(*c));
        let cutoff =
            if brightest.is_finite() { WEIGHT_SHARE * target / brightest } else { WEIGHT_SHARE * target };
        follow(&mut survey, limit, cutoff as f32, HIDDEN_SHARE * target, observer)?;
    }
    let Settings { width, height, depth, cutoff, .. } = *survey.settings();
    let goal = Goal { target: Some(target), confidence: 0.5, pilot: LEAST_SAMPLES, most: MOST_SAMPLES };
    let mut allocation = Allocation::new(width, height, REPLICATES as usize, goal);
    while let Some(step) = allocation.next_step(f64::INFINITY) {
        let traced = survey.trace(&step.pixels, step.samples.clone(), observer)?;
        if traced.marks.len() < step.pixels.len() || observer.cancelled() {
            return Ok(None);
        }
        allocation.record(&step, &traced);
        if allocation.rays() as f64 > sought.most_rays {
            break;
        }
    }
    let image = allocation.gathered();
    let noise = image.noise();
    let info = TruthInfo {
        depth,
        cutoff,
        standard_error: (noise.squares / noise.pixels.max(1) as f64).sqrt(),
        hidden: image.truncation(limit).rms,
        samples: allocation.samples() as f64 / image.samples.len().max(1) as f64,
        precision: survey.precision().name(),
    };
    let pixels = (0..image.samples.len()).map(|at| image.mean(at)).collect();
    Ok(Some(Truth { pixels, info }))
}

/// Cuts paths at the first depth that hides no more than `hidden`, or the last that can be afforded.
fn follow(
    survey: &mut Survey,
    limit: &RadianceLimit,
    cutoff: f32,
    hidden: f64,
    observer: &mut dyn Observer,
) -> Result<(), RenderError> {
    let Settings { width, height, .. } = *survey.settings();
    let places: Vec<u32> = (0..width * height).collect();
    let mut last = DEPTHS[0];
    for depth in DEPTHS {
        survey.cut_at(depth, cutoff);
        let traced = match survey.trace(&places, 0..REPLICATES, observer) {
            Ok(traced) => traced,
            // One sample's rays outgrew the queue: the depth before has to do.
            Err(error) if error.does_not_fit() && depth > DEPTHS[0] => break,
            Err(error) => return Err(error),
        };
        last = depth;
        let mut seen = Gathered::new(width, height, REPLICATES as usize);
        seen.add(&places, REPLICATES, &traced);
        let rays: u64 = seen.marks.iter().map(|m| u64::from(m.rays)).sum();
        let each = rays as f64 / (places.len() as f64 * f64::from(REPLICATES));
        if seen.truncation(limit).rms <= hidden || each > MOST_RAYS || observer.cancelled() {
            break;
        }
    }
    survey.cut_at(last, cutoff);
    Ok(())
}

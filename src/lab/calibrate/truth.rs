//! The truth that images are compared with: the same pixels in f64, sampled until their own
//! standard error is small compared with the errors of the images.

use crate::accuracy::allocate::{Allocation, Goal};
use crate::accuracy::pixel_sums::PixelSums;
use crate::accuracy::radiance_bound::RadianceLimit;
use crate::accuracy::unseen::Caps;
use crate::render::{Observer, RenderError, Renderer, Survey};
use crate::scene::Scene;
use crate::settings::{Precision, Settings};
use serde::Serialize;

/// Replicates of the truth: enough for a good estimate of its standard error.
const REPLICATES: u32 = 16;
/// Least samples of a pixel.
const LEAST_SAMPLES: u32 = 128;
/// Most samples of a pixel.
const MOST_SAMPLES: u32 = 1 << 14;
/// Depths tried for complete paths.
const DEPTHS: [u32; 5] = [4, 8, 16, 32, 64];
/// Depth stops growing at this many rays per sample.
const MOST_RAYS: f64 = 256.0;
/// Truncation error allowed / standard error sought.
const HIDDEN_SHARE: f64 = 0.5;
/// Contribution of one untraced ray allowed / standard error sought, for complete paths.
const WEIGHT_SHARE: f64 = 0.1;
/// Least standard error sought: a hundredth of an 8-bit code.
const LEAST_ERROR: f64 = 4e-5;
/// Seed of every truth; no image uses it.
pub const SEED: u32 = 0x7275_7468;

/// Requirements on a truth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sought {
    /// Depth of the paths; `None` for complete paths, as far as they contribute.
    pub depth: Option<u32>,
    /// Its own RMSE at most.
    pub standard_error: f64,
    /// Rays traced at most.
    pub most_rays: f64,
}

/// Quality of a truth.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TruthInfo {
    /// Depth of its paths.
    pub depth: u32,
    /// Throughput below which its paths end.
    pub cutoff: f32,
    /// Estimate of its own RMSE.
    pub standard_error: f64,
    /// Upper bound on the light of rays it did not trace, RMSE.
    pub hidden: f64,
    /// Mean samples per pixel.
    pub samples: f64,
    /// Arithmetic: f64 unless the device has none.
    pub precision: &'static str,
}

/// Nearly exact pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// Linear RGB, unclamped, row by row.
    pub pixels: Vec<[f64; 3]>,
    /// Its quality.
    pub info: TruthInfo,
}

impl Truth {
    /// RMSE of `image` as shown: linear light clamped to [0, 1], all channels.
    pub fn error(&self, image: &PixelSums) -> f64 {
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

/// Renders the truth of an image with the size in `settings`; `None` if cancelled.
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
    let goal = Goal {
        target: Some(target),
        confidence: 0.5,
        first: LEAST_SAMPLES,
        pilot: LEAST_SAMPLES,
        most: MOST_SAMPLES,
    };
    let mut allocation = Allocation::new(width, height, REPLICATES as usize, goal, Caps::default());
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

/// Sets the depth of `survey`: the first whose truncation error is at most `hidden`, or the last
/// affordable one.
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
        let mut seen = PixelSums::new(width, height, REPLICATES as usize);
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

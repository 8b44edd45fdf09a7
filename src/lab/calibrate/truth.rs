//! Truths by independent seeds: the mean of several renders in f64, each with many samples. They use nothing but plain
//! samples of the kernels, so they share no code with the bounds that they judge. Pixels that may hold something smaller
//! than a pixel get more samples than the rest ([`small`]).

use super::judge::{Reference, Shown};
use super::record::TruthRecord;
use super::seeds;
use super::small::{self, Small};
use crate::render::{Observer, RenderError, Renderer, Survey};
use crate::scene::Scene;
use crate::settings::{Precision, Settings};

/// Renders of a truth, at least: fewer say little about their own spread.
const LEAST_SEEDS: u32 = 4;
/// Renders of a truth, at most.
const MOST_SEEDS: u32 = 32;
/// Samples per pixel of the first renders.
const FIRST_SAMPLES: u32 = 16;
/// Samples per pixel of one render, at least, if the rays suffice.
const LEAST_SAMPLES: u32 = 64;
/// Samples per pixel of one render, at most.
const MOST_SAMPLES: u32 = 1 << 14;
/// Error falls with the samples to the power of -3/4 at edges (Mitchell, SIGGRAPH 1996).
const SLOPE: f64 = 0.75;
/// Samples per pixel that depths are compared with.
const DEPTH_SAMPLES: u32 = 8;
/// Depth and cutoff of complete paths, the first that suffices: each twice as deep, and cut at an eighth.
const FIRST_DEPTH: u32 = 8;
const FIRST_CUTOFF: f32 = 1e-3;
const DEEPEST: u32 = 1024;
/// A depth suffices if the next two change the image by less than this share of the error sought.
const HIDDEN_SHARE: f64 = 0.25;
/// Rays per sample at which depth stops growing.
const MOST_RAYS_PER_SAMPLE: f64 = 300.0;
/// Share of the rays of a truth that the comparison of depths may take.
const DEPTH_RAYS: f64 = 0.25;
/// Samples of a pixel that may hold something small, at most.
const MOST_SMALL: u32 = 1 << 16;
/// Samples of such a pixel, at least, whatever the rays.
const LEAST_SMALL: f64 = 4096.0;
/// Share of the rays of a truth that these pixels may take beyond that.
const SMALL_RAYS: f64 = 0.5;
/// Number of the first seed for these pixels: others than those of whole renders.
const SMALL_SEED: u32 = 1 << 16;
/// Least RMSE sought: a tenth of an 8-bit code would need more samples than anybody compares.
const LEAST_ERROR: f64 = 2e-5;

/// Linear RGB, unclamped, rows from the top.
type Pixels = Vec<[f32; 3]>;

/// How long the paths of a truth are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Paths {
    /// Rays in the longest path.
    pub(super) depth: u32,
    /// Rays with less throughput are not traced.
    pub(super) cutoff: f32,
    /// RMSE that longer paths may cause: the change by the last step, which longer steps only shrink.
    pub(super) hidden: f64,
}

/// Renders one scene plainly.
pub(super) struct Tracer<'a> {
    pub(super) renderer: &'a mut Renderer,
    pub(super) scene: &'a Scene,
    /// Size, and f64 where the device has it.
    pub(super) settings: Settings,
    /// Most rays of one truth.
    pub(super) most_rays: f64,
}

/// Pixels that were sampled apart.
#[derive(Debug, Clone, Copy, Default)]
struct Refined {
    pixels: u64,
    samples: u32,
    rays: u64,
}

/// The mean of renders of `scene` with independent seeds, paths of `depth` (complete ones if `None`), sampled until its own
/// RMSE is `sought` or `most_rays` are traced; `None` if cancelled.
///
/// # Errors
/// As [`Renderer::render`].
pub fn reference(
    renderer: &mut Renderer,
    scene: &Scene,
    settings: &Settings,
    depth: Option<u32>,
    (sought, most_rays): (f64, f64),
    observer: &mut dyn Observer,
) -> Result<Option<Reference>, RenderError> {
    let mut tracer = Tracer::new(renderer, scene, settings, most_rays);
    let paths = match depth {
        Some(depth) => Some(Paths { depth, cutoff: 0.0, hidden: 0.0 }),
        None => tracer.complete(sought, observer)?,
    };
    let Some(paths) = paths else { return Ok(None) };
    Ok(tracer.truth(paths, sought, observer)?.map(|truth| truth.reference))
}

/// A truth and its quality.
pub(super) struct Truth {
    pub(super) reference: Reference,
    pub(super) record: TruthRecord,
}

impl<'a> Tracer<'a> {
    pub(super) fn new(
        renderer: &'a mut Renderer,
        scene: &'a Scene,
        settings: &Settings,
        most_rays: f64,
    ) -> Tracer<'a> {
        let double = renderer.device().has_double();
        let precision = if double { Precision::Double } else { Precision::Robust };
        let settings = Settings { precision, cutoff: 0.0, replicates: 1, crop: None, ..settings.clone() };
        Tracer { renderer, scene, settings, most_rays }
    }

    /// Linear pixels and rays of one render; `None` if cancelled.
    fn render(
        &mut self,
        paths: Paths,
        samples: u32,
        seed: u32,
        observer: &mut dyn Observer,
    ) -> Result<Option<(Pixels, u64)>, RenderError> {
        let Paths { depth, cutoff, .. } = paths;
        let settings = Settings { depth, cutoff, samples, seed, ..self.settings.clone() };
        let image = self.renderer.render_with(self.scene, &settings, observer)?;
        Ok((image.done == 1.0).then(|| (image.linear, image.report.rays.total())))
    }

    /// The depth and cutoff from which on paths are complete, as far as an error of `sought` shows. Each step renders the
    /// same samples, and longer paths only add light; so the change between two steps is exactly the light between.
    pub(super) fn complete(
        &mut self,
        sought: f64,
        observer: &mut dyn Observer,
    ) -> Result<Option<Paths>, RenderError> {
        if !self.scene.materials.iter().any(|m| m.has_secondary()) {
            return Ok(Some(Paths { depth: 1, cutoff: 0.0, hidden: 0.0 }));
        }
        let pixels = f64::from(self.settings.width) * f64::from(self.settings.height);
        // Of the first step alone it is not known what longer paths add: anything.
        let mut step = Paths { depth: FIRST_DEPTH, cutoff: FIRST_CUTOFF, hidden: 1.0 };
        let (mut last, mut still, mut spent): (Option<(Paths, Shown)>, u32, f64) = (None, 0, 0.0);
        loop {
            let image = match self.render(step, DEPTH_SAMPLES, seeds::truth(0), observer) {
                Ok(Some(image)) => image,
                Ok(None) => return Ok(None),
                // The step before has to do.
                Err(error) if error.does_not_fit() && last.is_some() => break,
                Err(error) => return Err(error),
            };
            let (linear, rays) = image;
            let shown = Shown::of(&linear);
            let compared = last.is_some();
            if let Some((_, before)) = &last {
                step.hidden = shown.distance(before);
                still = if step.hidden <= HIDDEN_SHARE * sought { still + 1 } else { 0 };
            }
            spent += rays as f64;
            let each = rays as f64 / (pixels * f64::from(DEPTH_SAMPLES));
            last = Some((step, shown));
            // One step alone says nothing of what longer paths add.
            let dear = compared && (each > MOST_RAYS_PER_SAMPLE || spent > DEPTH_RAYS * self.most_rays);
            if still == 2 || step.depth >= DEEPEST || dear {
                break;
            }
            step = Paths { depth: 2 * step.depth, cutoff: step.cutoff / 8.0, hidden: 0.0 };
        }
        Ok(last.map(|(paths, _)| paths))
    }

    /// The truth of `paths`, sampled until its own RMSE is `sought` or its rays are used up; `None` if cancelled.
    pub(super) fn truth(
        &mut self,
        paths: Paths,
        sought: f64,
        observer: &mut dyn Observer,
    ) -> Result<Option<Truth>, RenderError> {
        let sought = sought.max(LEAST_ERROR);
        let mut samples = FIRST_SAMPLES;
        let mut renders: Vec<Pixels> = Vec::new();
        let mut rays;
        let mut reference = loop {
            let Some(part) = self.seeds(paths, samples, 0..LEAST_SEEDS, &mut renders, observer)? else {
                return Ok(None);
            };
            // Renders that are thrown away count no more: they cost half as much again at most.
            rays = part;
            let reference = Reference::of(&renders, paths.hidden);
            // Longer sequences rather than more of them: they fall faster than with the root.
            let wanted = f64::from(samples) * (reference.error() / sought).powf(1.0 / SLOPE);
            let each = part as f64 / f64::from(samples);
            let affordable = self.most_rays / each;
            let next = wanted.max(2.0 * f64::from(samples)).min(affordable).min(f64::from(MOST_SAMPLES));
            // Whole powers of two, at which the sequence is most even.
            let next = next.max(1.0).log2().floor().exp2() as u32;
            // Few samples may agree because they all missed the same.
            let enough = reference.error() <= sought && samples >= LEAST_SAMPLES;
            if enough || next <= samples {
                break reference;
            }
            samples = next;
            renders.clear();
        };
        while reference.error() > sought && (renders.len() as u32) < MOST_SEEDS {
            let each = rays as f64 / renders.len() as f64;
            if rays as f64 + each > self.most_rays {
                break;
            }
            let from = renders.len() as u32;
            let Some(part) = self.seeds(paths, samples, from..from + 1, &mut renders, observer)? else {
                return Ok(None);
            };
            rays += part;
            reference = Reference::of(&renders, paths.hidden);
        }
        let each = rays as f64 / (renders.len() as f64 * f64::from(samples));
        let Settings { width, height, .. } = self.settings;
        let small = small::pixels(self.scene, width, height);
        let at: Vec<u32> = small.keys().copied().collect();
        let Some(refined) = self.refine(paths, samples, (&at, each), &mut renders, observer)? else {
            return Ok(None);
        };
        rays += refined.rays;
        let mut reference = Reference::of(&renders, paths.hidden);
        let met = f64::from(samples.max(refined.samples)) * renders.len() as f64;
        for (at, things) in &small {
            let least = things.iter().map(|thing: &Small| thing.variance(met)).sum::<f64>().min(1.0);
            reference.variance[*at as usize].iter_mut().for_each(|v| *v = v.max(least));
        }
        let record = TruthRecord {
            depth: paths.depth,
            cutoff: paths.cutoff,
            samples,
            seeds: reference.seeds,
            rays,
            small_pixels: refined.pixels,
            small_samples: refined.samples,
            error: reference.error(),
            sought,
            hidden: paths.hidden,
            precision: self.settings.precision.name().into(),
        };
        Ok(Some(Truth { reference, record }))
    }

    /// Replaces `pixels` of `renders`, which may hold something small, by ones with more samples, if they get more;
    /// `None` if cancelled. `each` is the number of rays for one sample of every pixel.
    fn refine(
        &mut self,
        paths: Paths,
        samples: u32,
        (pixels, each): (&[u32], f64),
        renders: &mut [Pixels],
        observer: &mut dyn Observer,
    ) -> Result<Option<Refined>, RenderError> {
        let Settings { width, height, .. } = self.settings;
        let share = pixels.len() as f64 / (f64::from(width) * f64::from(height));
        let most = SMALL_RAYS * self.most_rays / (each * share * renders.len() as f64);
        let more = most.clamp(LEAST_SMALL, f64::from(MOST_SMALL)).log2().floor().exp2() as u32;
        if pixels.is_empty() || more <= samples {
            return Ok(Some(Refined::default()));
        }
        let mut refined = Refined { pixels: pixels.len() as u64, samples: more, rays: 0 };
        for (k, render) in (0..).zip(renders) {
            let Paths { depth, cutoff, .. } = paths;
            let seed = seeds::truth(SMALL_SEED + k);
            let settings = Settings { depth, cutoff, seed, ..self.settings.clone() };
            let mut survey = Survey::new(self.renderer, self.scene, &settings)?;
            let traced = survey.trace(pixels, 0..more, observer)?;
            if traced.marks.len() < pixels.len() || observer.cancelled() {
                return Ok(None);
            }
            let sets = traced.sums.len() / pixels.len();
            for (at, sums) in pixels.iter().zip(traced.sums.chunks(sets)) {
                let sum = |c: usize| sums.iter().map(|sum| sum[c]).sum::<f64>();
                render[*at as usize] = std::array::from_fn(|c| (sum(c) / f64::from(more)) as f32);
            }
            refined.rays += survey.report().rays.total();
        }
        Ok(Some(refined))
    }

    /// Adds a render for each seed; the rays of all, or `None` if cancelled.
    fn seeds(
        &mut self,
        paths: Paths,
        samples: u32,
        range: std::ops::Range<u32>,
        renders: &mut Vec<Pixels>,
        observer: &mut dyn Observer,
    ) -> Result<Option<u64>, RenderError> {
        let mut rays = 0;
        for k in range {
            let Some((linear, part)) = self.render(paths, samples, seeds::truth(k), observer)? else {
                return Ok(None);
            };
            renders.push(linear);
            rays += part;
        }
        Ok(Some(rays))
    }
}

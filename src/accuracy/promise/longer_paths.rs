//! The truncation part from longer paths of drawn pixels ([`drawn`]): how long, how many pixels, and what came of it.

use super::traced::{Region, Tracing};
use super::{DEEPEST, Task};
use crate::accuracy::drawn::{self, Weights};
use crate::accuracy::pixel_sums::PixelSums;
use crate::render::{RenderError, Survey};
use crate::report::ErrorInfo;
use crate::settings::Settings;
use std::collections::BTreeMap;

/// Share of a statement's risk that the truncation part takes where it is measured. Its limit goes with the logarithm of
/// that; the sampling part becomes 1 % wider.
const RISK_SHARE: f64 = 0.05;
/// Fewest pixels drawn: with none of them hiding anything, the part is 0.41 of what is certain.
const LEAST_DRAWS: u32 = 32;
/// Most: 0.08.
const MOST_DRAWS: u32 = 1024;
/// Paths are long enough once they may lack no more than this of what is to be measured, in squares: a twentieth of it.
const LEFT: f64 = 0.0025;
/// The first longer paths are cut at this share of the throughput that their sample lost.
const FIRST_CUTOFF: f64 = 1.0 / 16.0;
/// Each step divides the cutoff by this, and doubles the depth.
const STEP: f32 = 8.0;
/// Share of an image's rays that the draws may take: the comparison of `--budget` with f64 takes as many as the image.
const RAYS_SHARE: f64 = 0.25;
/// Share of these that finding the length of paths may take.
const TRIAL_SHARE: f64 = 0.5;
/// The part is measured where what is certain is at least this share of the sampling part.
const WORTHWHILE: f64 = 0.1;

/// Where paths are cut.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Paths {
    depth: u32,
    cutoff: f32,
}

impl Paths {
    /// Of a survey as it is.
    fn of(survey: &Survey) -> Paths {
        Paths { depth: survey.settings().depth, cutoff: survey.settings().cutoff }
    }

    /// True if nothing is longer.
    fn are_longest(self) -> bool {
        self.depth >= DEEPEST && self.cutoff == 0.0
    }

    /// Longer ones where a sample of `self` loses throughput `cut`.
    fn first_longer(self, cut: f64) -> Paths {
        let cutoff = (FIRST_CUTOFF * cut) as f32;
        let cutoff = if self.cutoff > 0.0 { cutoff.min(self.cutoff / STEP) } else { cutoff };
        Paths { depth: (2 * self.depth + 2).min(DEEPEST), cutoff }
    }

    fn longer(self) -> Paths {
        Paths { depth: (2 * self.depth).min(DEEPEST), cutoff: self.cutoff / STEP }
    }
}

/// Paths that are long enough to compare with.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Longer {
    paths: Paths,
    /// Rays of a sample of a pixel that is drawn.
    rays: f64,
}

/// A truncation part from drawn pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Measured {
    /// The part over what is certain.
    ratio: f64,
    /// Pixels drawn.
    draws: u32,
}

impl Measured {
    /// The statement `error`, whose sampling part has [its confidence](sampling_confidence), with this part.
    pub(super) fn into_error(self, error: ErrorInfo, confidence: f64) -> ErrorInfo {
        let truncation = self.ratio * error.truncation;
        ErrorInfo {
            confidence,
            total: error.total - error.truncation + truncation,
            truncation_certain: Some(error.truncation),
            truncation_pixels: Some(self.draws.into()),
            truncation,
            ..error
        }
    }
}

/// Pixels to draw for `rays` rays where each takes `each`; none where they would be too few.
fn draws(rays: f64, each: f64) -> u32 {
    let most = (rays / each.max(1.0)).min(f64::from(MOST_DRAWS)) as u32;
    if most < LEAST_DRAWS { 0 } else { most }
}

/// Confidence of the sampling part where the truncation part takes its share of the risk.
pub(super) fn sampling_confidence(confidence: f64) -> f64 {
    1.0 - (1.0 - RISK_SHARE) * (1.0 - confidence)
}

impl Tracing<'_> {
    /// `samples` samples of `places` with longer and longer paths, from `paths` on, until `left` says that they are long
    /// enough or another step would take more than `rays` rays in all. `None` if cancelled.
    fn lengthened(
        &mut self,
        (places, samples): (&[u32], u32),
        mut paths: Paths,
        left: impl Fn(&PixelSums) -> f64,
        rays: f64,
    ) -> Result<Option<Longer>, RenderError> {
        let traced = places.len() as f64 * f64::from(samples);
        let mut spent = 0.0;
        loop {
            self.survey.cut_at(paths.depth, paths.cutoff);
            let Some(seen) = self.all_of(places, samples)? else { return Ok(None) };
            let each: f64 = seen.marks.iter().map(|m| f64::from(m.rays)).sum();
            spent += each;
            // Another step takes as many rays again at least.
            if left(&seen) <= LEFT || paths.are_longest() || spent + each > rays {
                return Ok(Some(Longer { paths, rays: each / traced }));
            }
            paths = paths.longer();
        }
    }
}

impl Task<'_> {
    /// The truncation part of `image`, from `survey`. `None` where it would not be worth the rays, longer paths do not fit the
    /// memory, or it was cancelled: what is certain stands then.
    pub(super) fn measured(
        &mut self,
        survey: &Survey,
        image: &PixelSums,
    ) -> Result<Option<Measured>, RenderError> {
        let own = Paths::of(survey);
        let certain = image.truncation(&self.limit).rms;
        let sampling = image.noise().bound(image.replicates, self.request.confidence, 0.0).bound;
        if own.are_longest() || certain <= WORTHWHILE * sampling {
            return Ok(None);
        }
        let rays = RAYS_SHARE * image.marks.iter().map(|m| f64::from(m.rays)).sum::<f64>();
        let weights = Weights::new(image, &self.limit);
        let mut trial = weights.draw(LEAST_DRAWS, !self.settings.seed);
        trial.dedup();
        let cut = trial.iter().map(|p| image.cut(*p as usize)).sum::<f64>() / trial.len().max(1) as f64;
        let settings = Settings { depth: DEEPEST, ..survey.settings().clone() };
        let found = self.survey(&settings).and_then(|mut longer| {
            let limit = &self.limit;
            let left = |seen: &PixelSums| {
                let of = |(at, p): (usize, &u32)| drawn::lacking((image, *p as usize), (seen, at), limit).1;
                trial.iter().enumerate().map(of).sum::<f64>() / trial.len().max(1) as f64
            };
            let region = Region::of(&self.settings);
            let mut tracing = Tracing { survey: &mut longer, region, observer: &mut self.observer };
            // As many as all of them have: how long paths must be is no fine question.
            let samples = trial.iter().map(|p| image.samples[*p as usize]).min().unwrap_or(1);
            let each = (&trial[..], samples);
            match tracing.lengthened(each, own.first_longer(cut), left, TRIAL_SHARE * rays)? {
                Some(found) => self.drawn(&mut longer, (image, &weights), found, rays),
                None => Ok(None),
            }
        });
        match found {
            Err(error) if error.does_not_fit() => Ok(None),
            found => found,
        }
    }

    /// The same by paths as long as `longer`, for about `rays` rays.
    fn drawn(
        &mut self,
        survey: &mut Survey,
        (image, weights): (&PixelSums, &Weights),
        longer: Longer,
        rays: f64,
    ) -> Result<Option<Measured>, RenderError> {
        let limit = &self.limit;
        let count = draws(rays, longer.rays * weights.mean(&image.samples));
        let places = weights.draw(count, self.settings.seed);
        if places.is_empty() {
            return Ok(None);
        }
        // Pixels of as many samples are traced together, each once however often it was drawn.
        let mut by_samples: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        places.iter().for_each(|p| by_samples.entry(image.samples[*p as usize]).or_default().push(*p));
        survey.cut_at(longer.paths.depth, longer.paths.cutoff);
        let mut lacking = 0.0;
        for (samples, drawn) in by_samples {
            let mut once = drawn.clone();
            once.dedup();
            let region = Region::of(&self.settings);
            let mut tracing = Tracing { survey, region, observer: &mut self.observer };
            let Some(seen) = tracing.all_of(&once, samples)? else { return Ok(None) };
            for p in drawn {
                // It is there: the list was made of these.
                let at = once.partition_point(|other| *other < p);
                lacking += drawn::lacking((image, p as usize), (&seen, at), limit).0;
            }
        }
        let risk = RISK_SHARE * (1.0 - self.request.confidence);
        let ratio = drawn::upper_mean(lacking / f64::from(count), count, risk).sqrt();
        Ok((ratio < 1.0).then_some(Measured { ratio, draws: count }))
    }
}

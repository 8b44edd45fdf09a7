//! Settings for an error, chosen before the render: what all shares of an image have in common. Samples cannot be
//! chosen pixel by pixel then, as `--error` does; every pixel gets as many as the image needs on average.

use super::traced::{Region, Tracing};
use super::{DEEPEST, LOOK_SAMPLES, MOST_SAMPLES, Request, Target, Task};
use crate::accuracy::bright;
use crate::accuracy::pixel_sums::PixelSums;
use crate::accuracy::radiance_bound::radiance_limit;
use crate::accuracy::sampling::{Noise, joined};
use crate::accuracy::unseen::Unseen;
use crate::render::{Observer, RenderError, Renderer};
use crate::scene::Scene;
use crate::settings::Settings;
use serde::Serialize;

/// Pixels that are looked at: their noise tells that of all within a few percent.
const PIXELS: u32 = 4096;

/// Settings that should come to an error, and what pixels that were looked at say of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Settled {
    /// The error that was asked for: RMSE in linear light clamped to [0, 1].
    pub asked: f64,
    /// The error that is expected; the sampling part is a bound with the confidence asked for, if the other pixels are
    /// like those that were looked at.
    pub expected: f64,
    /// True if it is no greater than the one asked for.
    pub met: bool,
    /// Pixels looked at.
    pub pixels: u32,
    /// The settings.
    #[serde(skip)]
    pub settings: Settings,
}

impl Renderer {
    /// Chooses samples, depth and precision for an RMSE of `error` with 95 % confidence. The number of samples is a power
    /// of two, at which the sampler is best.
    ///
    /// # Errors
    /// As [`Renderer::render_bounded`].
    pub fn settle(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        request: &Request,
        observer: &mut dyn Observer,
    ) -> Result<Settled, RenderError> {
        settings.check()?;
        request.check()?;
        let Target::Error(error) = request.target else {
            return Ok(Settled {
                asked: f64::INFINITY,
                expected: f64::INFINITY,
                met: true,
                pixels: 0,
                settings: settings.clone(),
            });
        };
        let limit = radiance_limit(scene);
        let caps = bright::caps(scene, settings, &limit);
        let observer = super::MonotoneProgress::new(observer);
        let settings = settings.clone();
        let took = super::Took::nothing();
        Task { renderer: self, scene, settings, request: *request, limit, caps, observer, took }.settle(error)
    }
}

impl Task<'_> {
    fn settle(mut self, error: f64) -> Result<Settled, RenderError> {
        let own = self.settings.clone();
        let depth = if self.request.keep_depth { own.depth } else { DEEPEST };
        self.settings = Settings { replicates: 1, depth, ..own.clone() };
        let mut survey = self.survey(&self.settings.clone())?;
        let chosen = self.choose(&mut survey, error)?;
        self.go_to(&mut survey, &chosen)?;
        let region = Region::of(&self.settings);
        let places = region.spread(PIXELS);
        let all: Vec<u32> = (0..places.len() as u32).collect();
        let mut seen = PixelSums::new(all.len() as u32, 1, 1);
        let (mut samples, mut more) = (0, LOOK_SAMPLES);
        let expected = loop {
            let mut tracing = Tracing { survey: &mut survey, region, observer: &mut self.observer };
            let traced = tracing.trace_some(&places, samples..samples + more)?;
            seen.add(&all, more, &traced);
            samples += more;
            more = samples;
            let rounding = chosen.rounded.map_or(0.0, |r| r.part_at(f64::from(samples)));
            let expected = self.sampling(&seen, &places) + chosen.cut.hidden + rounding;
            if expected <= error || samples >= MOST_SAMPLES || self.observer.cancelled() {
                break expected;
            }
        };
        let settings = Settings {
            samples,
            depth: survey.settings().depth,
            cutoff: survey.settings().cutoff,
            precision: survey.settings().precision,
            ..own
        };
        Ok(Settled { asked: error, expected, met: expected <= error, pixels: places.len() as u32, settings })
    }

    /// The sampling part of an image whose pixels are like those of `seen`, which are at `places`.
    fn sampling(&self, seen: &PixelSums, places: &[u32]) -> f64 {
        let noise: Noise = (0..places.len()).map(|at| seen.noise_of(at)).sum();
        let mut unseen = Unseen::default();
        for (at, place) in places.iter().enumerate() {
            unseen.add(seen.samples[at], self.caps.of(*place as usize), seen.known_of(at));
        }
        // Noise goes with the number of pixels; what is unseen in few of them could be in one of many.
        let all = Region::of(&self.settings).pixels();
        let times = all.div_ceil(places.len().max(1) as u32);
        let unseen = unseen.times(times.into()).squares(self.request.confidence);
        let (_, factor) = noise.factor(1, self.request.confidence);
        let pixels = f64::from(times) * places.len() as f64;
        (joined(f64::from(times) * noise.variance(), factor, unseen) / pixels).sqrt()
    }
}

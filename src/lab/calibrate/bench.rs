//! Renders of one scene: with `--budget`, `--error` and `--time`, and plain ones to compare them with.

use super::judge::Shown;
use super::record::Stated;
use crate::accuracy::promise::{BoundedImage, Layer, Request, Target};
use crate::render::{Observer, RenderError, Renderer};
use crate::report::Report;
use crate::scene::Scene;
use crate::settings::{Precision, Settings};
use std::time::Instant;

/// Plain renders that are tried to fill a time.
const PLAIN_TRIES: u32 = 4;
/// Most samples of these.
const MOST_IN_TIME: u32 = 1 << 16;

/// A plain image, its samples per pixel and its wall seconds.
pub(super) type Timed = (Shown, u32, f64);

/// Renders trials of one scene.
pub(super) struct Bench<'a> {
    pub(super) renderer: &'a mut Renderer,
    pub(super) scene: &'a Scene,
    pub(super) settings: Settings,
    pub(super) confidence: f64,
}

/// An image before it is judged.
pub(super) struct Image {
    pub(super) seed: u32,
    pub(super) shown: Shown,
    pub(super) stated: Stated,
    pub(super) report: Report,
    /// Wall seconds of the call.
    pub(super) wall: f64,
    /// Half-widths of the pixels' intervals; of `--budget` only.
    pub(super) half_widths: Vec<f64>,
    /// Pixels whose samples took different paths; of `--budget` only.
    pub(super) edges: Vec<bool>,
}

impl Bench<'_> {
    fn bounded(
        &mut self,
        settings: &Settings,
        target: Target,
        observer: &mut dyn Observer,
    ) -> Result<Option<(BoundedImage, f64)>, RenderError> {
        let fixed = target == Target::Settings;
        let request = Request {
            confidence: self.confidence,
            keep_depth: fixed,
            keep_precision: fixed,
            ..Request::to(target)
        };
        let from = Instant::now();
        let image = self.renderer.render_bounded_with(self.scene, settings, &request, observer)?;
        let wall = from.elapsed().as_secs_f64();
        Ok((!image.cancelled).then_some((image, wall)))
    }

    /// Renders with `--budget`; `None` if cancelled.
    pub(super) fn budget(
        &mut self,
        seed: u32,
        samples: u32,
        observer: &mut dyn Observer,
    ) -> Result<Option<Image>, RenderError> {
        let settings = Settings { seed, samples, ..self.settings.clone() };
        let bounded = self.bounded(&settings, Target::Settings, observer)?;
        Ok(bounded.map(|(image, wall)| {
            let half_widths = image.layer(Layer::Sampling);
            let edges = image.samples.marks.iter().map(|m| m.hash_least != m.hash_most).collect();
            Image { half_widths, edges, ..Image::of(seed, image, wall) }
        }))
    }

    /// Renders with `--error`; `None` if cancelled.
    pub(super) fn error(
        &mut self,
        seed: u32,
        target: f64,
        observer: &mut dyn Observer,
    ) -> Result<Option<Image>, RenderError> {
        let settings = Settings { seed, samples: 1, ..self.settings.clone() };
        let bounded = self.bounded(&settings, Target::Error(target), observer)?;
        Ok(bounded.map(|(image, wall)| Image::of(seed, image, wall)))
    }

    /// Renders with `--time`, counted from this call; `None` if cancelled.
    pub(super) fn time(
        &mut self,
        seed: u32,
        seconds: f64,
        observer: &mut dyn Observer,
    ) -> Result<Option<Image>, RenderError> {
        let settings = Settings { seed, samples: 1, ..self.settings.clone() };
        let target = Target::Time { seconds, from: Instant::now(), layers: 0 };
        let bounded = self.bounded(&settings, target, observer)?;
        Ok(bounded.map(|(image, wall)| Image::of(seed, image, wall)))
    }

    /// Renders the same number of samples in every pixel without a bound: image, rays and seconds; `None` if cancelled.
    pub(super) fn plain(
        &mut self,
        settings: &Settings,
        observer: &mut dyn Observer,
    ) -> Result<Option<(Shown, u64, f64)>, RenderError> {
        let image = self.renderer.render_with(self.scene, settings, observer)?;
        let report = &image.report;
        Ok((image.done == 1.0).then(|| (Shown::of(&image.linear), report.rays.total(), report.time.render)))
    }

    /// The plain render with the most samples that takes at most `most` seconds, its samples and its wall seconds:
    /// `Some(None)` if one sample takes longer; `None` if cancelled.
    pub(super) fn plain_in_time(
        &mut self,
        seed: u32,
        most: f64,
        observer: &mut dyn Observer,
    ) -> Result<Option<Option<Timed>>, RenderError> {
        let (mut samples, mut best) = (1u32, None);
        for _ in 0..PLAIN_TRIES {
            let settings = Settings { seed, samples, ..self.settings.clone() };
            let from = Instant::now();
            let Some((shown, ..)) = self.plain(&settings, observer)? else { return Ok(None) };
            let wall = from.elapsed().as_secs_f64();
            let fits = wall <= most;
            if fits && best.as_ref().is_none_or(|(_, n, _)| samples > *n) {
                best = Some((shown, samples, wall));
            }
            let next = (f64::from(samples) * most / wall * if fits { 1.0 } else { 0.9 }).floor();
            if (!fits && samples == 1) || next == f64::from(samples) {
                break;
            }
            samples = next.clamp(1.0, f64::from(MOST_IN_TIME)) as u32;
        }
        Ok(Some(best))
    }

    /// The settings that a render with `--error` chose, for a plain render.
    pub(super) fn told(&self, report: &Report) -> Settings {
        let double = report.settings.precision == Precision::Double.name();
        Settings {
            depth: report.settings.depth,
            cutoff: report.settings.cutoff,
            precision: if double { Precision::Double } else { self.settings.precision },
            ..self.settings.clone()
        }
    }
}

impl Image {
    fn of(seed: u32, image: BoundedImage, wall: f64) -> Image {
        Image {
            seed,
            shown: Shown::of(&image.linear()),
            stated: Stated::of(image.report.error.as_ref()),
            report: image.report,
            wall,
            half_widths: Vec::new(),
            edges: Vec::new(),
        }
    }
}

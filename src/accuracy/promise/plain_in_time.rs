//! `--time` where it leaves no time for more: a render with a fixed number of samples, as `--samples` gives it.
//!
//! An image whose error is known takes other kernels, longer to prepare, and keeps more of each pixel. Where only a few
//! samples fit, what that costs would be better spent on samples. So first comes the whole image with one sample, which
//! times the device; then the samples that fit; or, where there is time for more than `ENOUGH`, the
//! image with a bound ([`until_time`](super::until_time)).

use super::Task;
use super::bounded_image::BoundedImage;
use super::until_time::{Clock, strip};
use crate::accuracy::pixel_order;
use crate::render::{Observer, RenderError, Rendered, not_finite};
use crate::settings::Settings;
use crate::settings::sampler::pcg4d;
use std::time::Instant;

/// Samples of every pixel for which there must be time, or the bound is not worth its price: with fewer a render that
/// knows nothing of its error had the smaller one (Cornell boxes of 300x250 to 1200x1000, lavapipe).
const ENOUGH: f64 = 7.0;
/// Share of the time left that several samples are planned for.
const CAUTION: f64 = 0.92;
/// What it takes to begin a render with the same kernels, as a share of what the first took to prepare.
const OVERHEAD: f64 = 0.25;
/// Time to write an image / to write noise, which packs worst: 0.3 to 0.4, rounded up.
const NOISE: f64 = 0.5;
/// Rows may differ in work: the rest may take as little as this share of its forecast.
const HOPE: f64 = 0.5;
/// Share of the image from which the time of the rest is forecast.
const TELLING: f64 = 0.1;

impl Task<'_> {
    /// The image of as many samples as fit, if these are few; `None` if there is time for more, or not even for one
    /// sample of every pixel.
    pub(super) fn plain_in_time(&mut self, clock: &mut Clock) -> Result<Option<BoundedImage>, RenderError> {
        if self.observer.watches() {
            return Ok(None);
        }
        clock.reserve = NOISE * self.write_noise();
        if clock.left() <= 0.0 {
            return Ok(None);
        }
        let Some(first) = self.plain(1, clock)? else { return Ok(None) };
        let took = first.report.time.render;
        let prepared = first.report.time.first_dispatch;
        clock.opened = prepared;
        clock.reserve = self.written(&first);
        let left = clock.left();
        // Other kernels take about as long to prepare as the first.
        if left - prepared >= ENOUGH * took {
            return Ok(None);
        }
        // Not all at once: if it cannot be whole in time, nothing of it is left.
        let fit = (left - OVERHEAD * prepared) / took;
        let more = match fit >= 2.0 {
            true => self
                .plain(2.max((0.5 * fit) as u32), clock)?
                .map(|image| self.more(image, prepared, clock))
                .transpose()?,
            false => None,
        };
        let rendered = match more {
            Some(mut more) => {
                more.report.time.first_dispatch += clock.opened;
                more
            }
            None => first,
        };
        let lost = rendered.report.counters.lost().or_else(|| not_finite(&rendered.linear));
        let cancelled = self.observer.cancelled();
        let mut image = BoundedImage::plain(rendered, self.limit.clone(), &self.request, cancelled);
        let why = if cancelled { Some("the render was interrupted".into()) } else { lost };
        let asked = &mut image.report.asked;
        (asked.time, asked.met, asked.unmet_why) = (Some(clock.seconds), Some(why.is_none()), why);
        Ok(Some(image))
    }

    /// The image of `samples` samples; `None` if it cannot be whole in time.
    fn plain(&mut self, samples: u32, clock: &Clock) -> Result<Option<Rendered>, RenderError> {
        let settings = Settings { samples, replicates: 1, ..self.settings.clone() };
        let mut prepared = self.renderer.prepare(self.scene, &settings)?;
        let mut observer = WholeInTime::new(&mut self.observer, clock);
        let rendered = prepared.render_with(&mut observer)?;
        Ok((rendered.done == 1.0).then_some(rendered))
    }

    /// `image` with the samples for which there is still time.
    fn more(&mut self, mut image: Rendered, prepared: f64, clock: &Clock) -> Result<Rendered, RenderError> {
        while let Some(state) = image.state.take() {
            let had = image.report.settings.samples;
            let pace = image.report.time.render / f64::from(had);
            let samples = had + (CAUTION * (clock.left() - OVERHEAD * prepared) / pace) as u32;
            // Less than a sixteenth of it is not worth a render.
            if samples < had + had.div_ceil(16) {
                break;
            }
            let settings = Settings { samples, replicates: 1, ..self.settings.clone() };
            let mut observer = WholeInTime::new(&mut self.observer, clock);
            let more = self.renderer.more(self.scene, &settings, state, &mut observer)?;
            if more.done < 1.0 {
                break;
            }
            image = more;
        }
        Ok(image)
    }

    /// Seconds that writing an image of noise would take.
    fn write_noise(&self) -> f64 {
        let [x0, y0, x1, y1] = self.settings.region();
        let pixels = (x1 - x0) as usize * (y1 - y0) as usize;
        let one = |at| pcg4d([at as u32, 1, 2, 3])[0] as f32 / u32::MAX as f32;
        let noise: Vec<[f32; 3]> = (0..strip(pixels)).map(|at| [one(at); 3]).collect();
        self.write_seconds(&noise, pixels)
    }

    /// Seconds that writing the image takes.
    fn written(&self, image: &Rendered) -> f64 {
        let pixels = pixel_order::order(image.width, image.height, 0..strip(image.linear.len()));
        let some: Vec<[f32; 3]> = pixels.iter().map(|p| image.linear[*p as usize]).collect();
        self.write_seconds(&some, image.linear.len())
    }
}

/// An observer that cancels at a time, and before it where it is clear that the whole will not be there by then.
struct WholeInTime<'a> {
    observer: &'a mut dyn Observer,
    end: Instant,
    /// When the first of it was there, and the share that it was.
    first: Option<(Instant, f64)>,
    hopeless: bool,
}

impl<'a> WholeInTime<'a> {
    fn new(observer: &'a mut dyn Observer, clock: &Clock) -> WholeInTime<'a> {
        WholeInTime { observer, end: clock.end(), first: None, hopeless: false }
    }
}

impl Observer for WholeInTime<'_> {
    fn progress(&mut self, done: u64, total: u64) {
        self.observer.progress(done, total);
        let share = done as f64 / total.max(1) as f64;
        let (since, begun) = *self.first.get_or_insert((Instant::now(), share));
        if share - begun >= TELLING {
            let rest = since.elapsed().as_secs_f64() * (1.0 - share) / (share - begun);
            self.hopeless = HOPE * rest > self.end.saturating_duration_since(Instant::now()).as_secs_f64();
        }
    }

    fn cancelled(&self) -> bool {
        self.observer.cancelled() || self.hopeless || Instant::now() >= self.end
    }
}

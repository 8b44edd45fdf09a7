//! A survey seen as the source of an allocation, with places in the region for pixels of the image.

use crate::accuracy::pixel_sums::PixelSums;
use crate::render::samples::{Source, Traced};
use crate::render::{Observer, RenderError, Survey};
use crate::settings::Settings;
use std::ops::Range;

/// Pixels of the image, by their places in the region that is rendered.
#[derive(Debug, Clone, Copy)]
pub(super) struct Region {
    x: u32,
    y: u32,
    pub(super) width: u32,
    pub(super) height: u32,
    image_width: u32,
}

impl Region {
    pub(super) fn of(settings: &Settings) -> Region {
        let [x, y, x1, y1] = settings.region();
        Region { x, y, width: x1 - x, height: y1 - y, image_width: settings.width }
    }

    pub(super) fn pixels(&self) -> u32 {
        self.width * self.height
    }

    fn in_image(&self, places: &[u32]) -> Vec<u32> {
        let pixel = |p: &u32| (self.y + p / self.width) * self.image_width + self.x + p % self.width;
        places.iter().map(pixel).collect()
    }

    /// At most `most` places, spread over the region evenly.
    pub(super) fn spread(&self, most: u32) -> Vec<u32> {
        let step = (f64::from(self.pixels()) / f64::from(most)).sqrt().ceil().max(1.0) as u32;
        // Each block gives the place that a hash of its corner says, so that no grid of the scene is missed.
        let block = |(x, y): (u32, u32)| {
            let [h, k, ..] = crate::settings::sampler::pcg4d([x, y, step, 0x5b1c]);
            let (w, h) = (h % step.min(self.width - x), k % step.min(self.height - y));
            (y + h) * self.width + x + w
        };
        let rows = (0..self.height).step_by(step as usize);
        rows.flat_map(|y| (0..self.width).step_by(step as usize).map(move |x| (x, y))).map(block).collect()
    }
}

/// A survey, asked by places.
pub(super) struct Tracing<'a> {
    pub(super) survey: &'a mut Survey,
    pub(super) region: Region,
    pub(super) observer: &'a mut dyn Observer,
}

impl Tracing<'_> {
    /// The first `samples` samples of each of `places`, as an image of their own; `None` if cancelled.
    pub(super) fn all_of(&mut self, places: &[u32], samples: u32) -> Result<Option<PixelSums>, RenderError> {
        let seen = self.see(places, samples)?;
        Ok((seen.samples.len() == places.len()).then_some(seen))
    }

    /// The first `samples` samples of each of `places`, as an image of their own; of the first of them only if cancelled.
    pub(super) fn see(&mut self, places: &[u32], samples: u32) -> Result<PixelSums, RenderError> {
        let traced = self.trace(places, 0..samples)?;
        let count = traced.marks.len() as u32;
        let mut seen = PixelSums::new(count, 1, self.survey.replicates());
        seen.add(&(0..count).collect::<Vec<_>>(), samples, &traced);
        Ok(seen)
    }

    /// As `trace`, until a state is wanted, too.
    pub(super) fn trace_some(&mut self, places: &[u32], samples: Range<u32>) -> Result<Traced, RenderError> {
        self.survey.trace_some(&self.region.in_image(places), samples, self.observer)
    }
}

impl Source for Tracing<'_> {
    type Error = RenderError;

    fn replicates(&self) -> usize {
        self.survey.replicates()
    }

    fn trace(&mut self, pixels: &[u32], samples: Range<u32>) -> Result<Traced, RenderError> {
        self.survey.trace(&self.region.in_image(pixels), samples, self.observer)
    }
}

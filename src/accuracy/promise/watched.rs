//! The image on its way, for an observer that watches.

use super::Task;
use crate::accuracy::pixel_sums::PixelSums;
use crate::render::{ImageSoFar, Observer, Survey};

impl Task<'_> {
    /// Gives the image so far to the observer, if it watches. Pixels without
    /// samples repeat their neighbours, as in the image of a render that ends now.
    pub(super) fn show(&mut self, survey: &Survey, image: &PixelSums) {
        if !self.observer.watches() || image.done() == 0.0 {
            return;
        }
        let seconds = self.took.start.elapsed().as_secs_f64();
        let traced: u64 = image.samples.iter().map(|n| u64::from(*n)).sum();
        self.observer.image(&ImageSoFar {
            linear: &image.filled(),
            samples: traced as f64 / image.samples.len().max(1) as f64,
            rays: survey.rays(),
            seconds,
        });
    }
}

//! Box and primitive tests of each pixel: the layer `tests`.

use super::{Observer, RenderError, Renderer, Survey};
use crate::scene::Scene;
use crate::settings::{Schedule, Settings};

/// Samples of a round, whose tests a mark counts in 32 bits.
const ROUND: u32 = 16;

impl Renderer {
    /// Traces the samples of `settings` once more, by kernels that count. Gives the tests of each pixel, rows from the
    /// top; `None` if it was cancelled.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn tests_per_pixel(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        observer: &mut dyn Observer,
    ) -> Result<Option<Vec<f64>>, RenderError> {
        let schedule = Schedule { count_tests: true, ..settings.schedule };
        let mut survey = Survey::new(self, scene, &Settings { schedule, ..settings.clone() })?;
        let [x0, y0, x1, y1] = settings.region();
        let row = |y: u32| (x0..x1).map(move |x| y * settings.width + x);
        let pixels: Vec<u32> = (y0..y1).flat_map(row).collect();
        let mut tests = vec![0.0; pixels.len()];
        // Whole sets of replicates.
        let round = ROUND.next_multiple_of(settings.replicates.max(1));
        let mut first = 0;
        while first < settings.samples {
            let end = first.saturating_add(round).min(settings.samples);
            let traced = survey.trace(&pixels, first..end, observer)?;
            if traced.marks.len() < pixels.len() {
                return Ok(None);
            }
            // In a counting survey `rays` are tests.
            tests.iter_mut().zip(&traced.marks).for_each(|(sum, mark)| *sum += f64::from(mark.rays));
            first = end;
        }
        Ok(Some(tests))
    }
}

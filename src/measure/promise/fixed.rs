//! `--budget`: the settings as they are, and what error they leave.

use super::Task;
use super::known::Known;
use super::traced::{Region, Tracing};
use crate::measure::budget::{self, Rounding};
use crate::measure::gathered::Gathered;
use crate::render::{RenderError, Survey};
use crate::settings::{Precision, Settings};
use std::time::Instant;

impl Task<'_> {
    /// All samples of all pixels, and the same again in f64 where the device has it.
    pub(super) fn fixed(mut self) -> Result<Known, RenderError> {
        let settings = self.settings.clone();
        let mut survey = Survey::new(self.renderer, self.scene, &settings)?;
        let start = Instant::now();
        let image = self.all(&mut survey, &settings)?;
        let mut render = start.elapsed();
        let complete = image.done() == 1.0 && !self.observer.cancelled();
        let mut prepared = survey.prepared;
        let mut rounding = None;
        let double = Settings { precision: Precision::Double, ..settings.clone() };
        if survey.precision() == Precision::Double {
            rounding = Some(Rounding::none(image.samples.len()));
        } else if complete && self.renderer.device().has_double() {
            let mut exact = Survey::new(self.renderer, self.scene, &double)?;
            prepared += exact.prepared;
            let start = Instant::now();
            let truth = self.all(&mut exact, &double)?;
            render += start.elapsed();
            if truth.done() == 1.0 {
                rounding = Some(budget::rounding(&image, &truth));
            }
        }
        self.known(image, survey, rounding, prepared, render)
    }

    fn all(&mut self, survey: &mut Survey, settings: &Settings) -> Result<Gathered, RenderError> {
        let region = Region::of(settings);
        let mut gathered = Gathered::new(region.width, region.height, settings.replicates as usize);
        let places: Vec<u32> = (0..region.pixels()).collect();
        let mut tracing = Tracing { survey, region, observer: self.observer };
        tracing.gather(&mut gathered, &places, 0..settings.samples)?;
        Ok(gathered)
    }
}

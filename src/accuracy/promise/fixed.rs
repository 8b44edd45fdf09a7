//! `--budget`: the settings as they are, and what error they leave.

use super::Task;
use super::bounded_image::{BoundedImage, Image};
use super::resume_state::{Begun, Bounded, Stage, options};
use super::traced::{Region, Tracing};
use crate::accuracy::budget::{self, Rounding};
use crate::accuracy::pixel_sums::PixelSums;
use crate::render::{Observer, RenderError, ResumeState, Survey};
use crate::report::TimeInfo;
use crate::settings::{Precision, Settings};
use std::time::Instant;

impl Task<'_> {
    /// All samples of all pixels, and the same again in f64 where the device has it.
    pub(super) fn fixed(
        mut self,
        earlier: Option<ResumeState<Bounded>>,
    ) -> Result<BoundedImage, RenderError> {
        let settings = self.settings.clone();
        let mut survey = self.survey(&settings)?;
        let identity = survey.identity(&settings, options(&self.request));
        let (images, before) = match earlier {
            None => (Vec::new(), TimeInfo::default()),
            Some(state) => {
                let (samples, before) = survey.take_up(state, &identity)?;
                (samples.into_budget()?, before)
            }
        };
        let mut images = images.into_iter();
        let region = Region::of(&settings);
        let nothing = || PixelSums::new(region.width, region.height, settings.replicates as usize);
        let (mut image, mut truth) =
            (images.next().unwrap_or_else(nothing), images.next().unwrap_or_else(nothing));

        self.took.start = Instant::now();
        let compared = survey.precision() != Precision::Double && self.renderer.device().has_double();
        let begun = Begun { identity: &identity, before: &before };
        let half = if compared { 0.5 } else { 1.0 };
        while self.some(&mut survey, &settings, &mut image, [0.0, half])? {
            [image, truth] = self.keep_budget(&survey, [image, truth], &begun);
        }
        self.show(&survey, &image);
        let mut rounding = None;
        if survey.precision() == Precision::Double {
            rounding = Some(Rounding::none(image.samples.len()));
        } else if compared && image.done() == 1.0 && !self.observer.cancelled() {
            let double = Settings { precision: Precision::Double, ..settings.clone() };
            let mut exact = self.survey(&double)?;
            while self.some(&mut exact, &double, &mut truth, [0.5, 1.0])? {
                [image, truth] = self.keep_budget(&survey, [image, truth], &begun);
            }
            if truth.done() == 1.0 {
                rounding = Some(budget::rounding(&image, &truth));
            }
        }
        let mut measured = None;
        if image.done() == 1.0 && !self.observer.cancelled() {
            measured = self.measured(&survey, &image)?;
        }
        // Cancelled before the measurement was done, it has to be resumed.
        let complete = image.done() == 1.0 && (rounding.is_some() || !compared);
        let finished = complete && (measured.is_some() || !self.observer.cancelled());
        let kept = (!finished && image.done() > 0.0).then(|| {
            survey.resume_state(identity, Bounded::new(Stage::Settings, vec![image.clone(), truth]))
        });
        let part = rounding.as_ref().map(|r| (r.rmse, r.ways));
        let image = Image {
            samples: image,
            rounding: part,
            measured,
            took: self.took.so_far(),
            before,
            coarse: false,
        };
        let mut known = self.known(image, &survey);
        if let Some(error) = &mut known.report.error {
            error.rounding_values = rounding.as_ref().map(|r| r.values);
        }
        known.rounding = rounding;
        known.cancelled &= !finished;
        known.unfinished = kept;
        Ok(known)
    }

    /// The samples that `gathered` lacks, pixel by pixel in order, until a state is wanted: true if there is more to do
    /// then. `span`: what all of them are of the whole.
    fn some(
        &mut self,
        survey: &mut Survey,
        settings: &Settings,
        gathered: &mut PixelSums,
        [from, to]: [f64; 2],
    ) -> Result<bool, RenderError> {
        let region = Region::of(settings);
        let first = gathered.samples.iter().take_while(|n| **n > 0).count() as u32;
        let places: Vec<u32> = (first..region.pixels()).collect();
        let done = f64::from(first) / f64::from(region.pixels());
        self.observer.span(from + (to - from) * done, to);
        let mut tracing = Tracing { survey, region, observer: &mut self.observer };
        let traced = tracing.trace_some(&places, 0..settings.samples)?;
        gathered.add(&places, settings.samples, &traced);
        Ok(traced.marks.len() < places.len() && !self.observer.cancelled())
    }

    /// Keeps the state, and gives the samples back.
    fn keep_budget(
        &mut self,
        survey: &Survey,
        [image, truth]: [PixelSums; 2],
        begun: &Begun<'_>,
    ) -> [PixelSums; 2] {
        let nothing = || PixelSums::new(image.width, 0, image.replicates);
        let nothing = [nothing(), nothing()];
        let kept = Bounded::new(Stage::Settings, vec![image, truth]);
        // They are the two that were put in.
        <[PixelSums; 2]>::try_from(self.keep(survey, kept, begun)).unwrap_or(nothing)
    }
}

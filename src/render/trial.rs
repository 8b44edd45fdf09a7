//! Trial render: traces up to 16 bands of the image with the final kernels and buffers, to predict the time of
//! the whole, or to set one variant of the kernels beside another.

use super::batches::{End, Part, mean};
use super::tally::Tally;
use super::{Observer, Prepared, Quiet, RenderError};
use crate::kernel::table::Kernel;
use crate::plan::predicted_time::{Model, Unpredictable};
use crate::plan::tiles::Tile;
use crate::report::Report;
use crate::settings::Settings;
use crate::stats::median;
use crate::units::{grouped, plural};
use std::collections::BTreeMap;
use std::time::Instant;

/// Bands over the image's height, a power of two.
const BANDS: u32 = 16;
/// Bands that are traced whatever time they take.
const BANDS_LEAST: usize = 4;
/// Samples of a trial: an eighth of all, within these. Fewer would be all starts (of 3,000 rays a dispatch, half
/// the time on lavapipe is waking threads and waiting for the last), more would be a render.
const SAMPLES: [u64; 2] = [1 << 17, 1 << 18];
/// Seconds after which the first run ends with the bands it has, and no run is begun for a model.
const SECONDS: f64 = 1.0;
/// Runs for a model, of which the first is not counted: it touches memory for the first time, which a render
/// does once and not for every ray.
const RUNS: usize = 4;
/// Runs of one pixel, to time the starts of dispatches.
const STARTS: usize = 5;

/// A trial of a prepared scene.
pub struct Trial<'a> {
    prepared: &'a mut Prepared,
    bands: Vec<Tile>,
    samples: u32,
    /// Some bands were traced, so that those that are left are the ones that time allows.
    begun: bool,
}

/// One run of a trial.
#[derive(Debug, Clone)]
pub struct Run {
    /// Pixels of all bands, linear.
    pub linear: Vec<[f32; 3]>,
    /// Device seconds and samples of each band.
    pub bands: Vec<(f64, u64)>,
    /// Passes, rays and counts.
    pub report: Report,
}

impl Run {
    /// Device seconds.
    pub fn device(&self) -> f64 {
        self.bands.iter().map(|b| b.0).sum()
    }
}

impl<'a> Trial<'a> {
    /// Bands of the whole image, its kernels and buffers.
    pub fn new(prepared: &'a mut Prepared) -> Trial<'a> {
        let (bands, samples) = bands(prepared.settings(), prepared.plan().tile_pixels);
        Trial { prepared, bands, samples, begun: false }
    }

    /// The scene that is tried.
    pub fn prepared(&self) -> &Prepared {
        self.prepared
    }

    /// Only so many of the bands from now on.
    pub fn keep_bands(&mut self, bands: usize) {
        self.bands.truncate(bands.max(1));
    }

    /// The bands and samples of another trial of the same image, so that both trace the same.
    pub fn take_bands(&mut self, other: &Trial<'_>) {
        self.bands.clone_from(&other.bands);
        (self.samples, self.begun) = (other.samples, true);
    }

    /// Traces all bands: the first time as many as there is time for, then always the same.
    ///
    /// # Errors
    /// As [`Renderer::render`]; also if a queue is too small for one sample of a band.
    pub fn run(&mut self, observer: &mut dyn Observer) -> Result<Run, RenderError> {
        let begin = Instant::now();
        let (mut tally, mut linear, mut times) = (Tally::default(), Vec::new(), Vec::new());
        let bands = std::mem::take(&mut self.bands);
        let mut kept = Vec::with_capacity(bands.len());
        for band in bands {
            let late = !self.begun && kept.len() >= BANDS_LEAST && begin.elapsed().as_secs_f64() > SECONDS;
            if late || observer.cancelled() {
                break;
            }
            let traced = self.band(band, self.samples)?;
            let device: f64 = traced.passes.values().map(|(_, seconds)| seconds).sum();
            times.push((device, traced.samples));
            tally.add(&traced);
            let (film, _) = self.prepared.batches.film(band.pixels())?;
            let sets = self.prepared.batches.plan.specialisation.film_sums() as usize;
            linear.extend(film.chunks(sets).map(|pixel| mean(pixel, self.samples)));
            kept.push(band);
        }
        (self.bands, self.begun) = (kept, true);
        let mut report = tally.report(self.prepared.settings(), self.prepared.packed(), self.prepared.plan());
        report.time.device = times.iter().map(|t| t.0).sum();
        report.time.render = begin.elapsed().as_secs_f64();
        Ok(Run { linear, bands: times, report })
    }

    /// A model of the whole from a few runs, each pass at its mean: a render meets the same disturbances, which a median would leave out.
    ///
    /// # Errors
    /// As [`Trial::run`].
    pub fn model(
        &mut self,
        observer: &mut dyn Observer,
    ) -> Result<Result<Model, Unpredictable>, RenderError> {
        let starts = self.starts()?;
        let begin = Instant::now();
        let mut runs = vec![self.run(observer)?];
        while runs.len() < RUNS && begin.elapsed().as_secs_f64() < SECONDS && !observer.cancelled() {
            runs.push(self.run(observer)?);
        }
        runs.retain(|r| r.bands.len() == self.bands.len() && !r.bands.is_empty());
        if runs.len() > 1 {
            runs.remove(0);
        }
        let Some(run) = mean_run(&runs) else {
            return Ok(Err(Unpredictable("the trial was interrupted".into())));
        };
        let samples: u64 = run.bands.iter().map(|b| b.1).sum();
        let [x0, y0, x1, y1] = self.prepared.settings().region();
        let all = u64::from(x1 - x0) * u64::from(y1 - y0) * u64::from(self.prepared.settings().samples);
        let basis = format!(
            "a trial of {} samples in {} ({:.1} % of all samples)",
            grouped(samples),
            plural(run.bands.len() as u64, "band"),
            100.0 * samples as f64 / all as f64
        );
        let spread = spread(&run.bands);
        Ok(Model::new(&run.report, &starts).map(|m| m.with(spread, basis)))
    }

    /// Seconds of a dispatch of each kernel that has one ray or none: the median of several.
    fn starts(&mut self) -> Result<BTreeMap<Kernel, f64>, RenderError> {
        let [x0, y0, x1, y1] = self.prepared.settings().region();
        let pixel = Tile { x: (x0 + x1) / 2, y: (y0 + y1) / 2, width: 1, height: 1 };
        let mut seen: BTreeMap<Kernel, Vec<f64>> = BTreeMap::new();
        for _ in 0..STARTS {
            let traced = self.band(pixel, 1)?;
            for ((_, place), (launches, seconds)) in &traced.passes {
                let Some(pass) = crate::plan::passes::all().nth(*place) else { continue };
                seen.entry(pass.kernel).or_default().push(seconds / *launches as f64);
            }
        }
        Ok(seen.into_iter().map(|(kernel, times)| (kernel, median(&times).unwrap_or(0.0))).collect())
    }

    /// So many samples of every pixel of a band, whatever the observer says (bands are short), in as few batches as there is room for.
    fn band(&mut self, band: Tile, samples: u32) -> Result<Tally, RenderError> {
        let plan = &self.prepared.batches.plan;
        let room = plan.tile_pixels.saturating_mul(plan.batch_samples) / band.pixels();
        self.prepared.batches.batch_samples = room.clamp(1, samples);
        loop {
            let total = u64::from(band.pixels()) * u64::from(samples);
            match self.prepared.batches.samples(&Part::from(&band), 0..samples, &mut Quiet, 0, total)? {
                End::Done(_, tally) => return Ok(tally),
                End::Overflow if self.prepared.batches.batch_samples > 1 => {
                    self.prepared.batches.batch_samples /= 2
                }
                End::Overflow => return Err(self.prepared.batches.pixel_too_deep(band.x, band.y)),
            }
        }
    }
}

/// Runs of the same bands as one, each time at its mean; None of none.
fn mean_run(runs: &[Run]) -> Option<Run> {
    let mut one = runs.first()?.clone();
    let over = |time: &dyn Fn(&Run) -> f64| runs.iter().map(time).sum::<f64>() / runs.len() as f64;
    for (i, pass) in one.report.passes.iter_mut().enumerate() {
        pass.seconds = over(&|r| r.report.passes[i].seconds);
    }
    for (i, band) in one.bands.iter_mut().enumerate() {
        band.0 = over(&|r| r.bands[i].0);
    }
    one.report.time.device = one.report.passes.iter().map(|p| p.seconds).sum();
    Some(one)
}

/// Bands spread over the image's height, in an order whose beginnings are spread over it too, and the samples
/// of each pixel in them.
fn bands(settings: &Settings, tile_pixels: u32) -> (Vec<Tile>, u32) {
    let [x0, y0, x1, y1] = settings.region();
    let (width, height) = ((x1 - x0).min(tile_pixels), y1 - y0);
    let all = u64::from(x1 - x0) * u64::from(height) * u64::from(settings.samples);
    let wanted = (all / 8).clamp(SAMPLES[0], SAMPLES[1]).min(all);
    let count = BANDS.min(height);
    let in_row = (wanted / u64::from(count) / u64::from(width)).max(1);
    let samples = u64::from(settings.samples).min(in_row) as u32;
    let rows =
        (in_row / u64::from(samples)).clamp(1, u64::from((height / count).min(tile_pixels / width))) as u32;
    let mut order: Vec<u32> = (0..BANDS).map(|i| i.reverse_bits() >> (32 - BANDS.ilog2())).collect();
    order.retain(|i| *i < count);
    let slack = x1 - x0 - width;
    let tile = |i: u32| Tile {
        x: x0 + (u64::from(slack) * u64::from(i) / u64::from(count)) as u32,
        y: y0 + i * height / count + (height / count - rows) / 2,
        width,
        height: rows,
    };
    (order.into_iter().map(tile).collect(), samples)
}

/// Standard error of the mean time of a sample over bands of equal size, as a share of it.
fn spread(bands: &[(f64, u64)]) -> f64 {
    let each: Vec<f64> = bands.iter().map(|(seconds, samples)| seconds / *samples as f64).collect();
    let n = each.len() as f64;
    let mean = each.iter().sum::<f64>() / n;
    let variance = each.iter().map(|t| (t - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
    (variance / n).sqrt() / mean
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_are_spread_over_the_image() {
        let scene = crate::lab::gallery::tests::subject("a", 60, 50).scene;
        for (width, height, samples, tile) in [
            (60, 50, 1, 3000),
            (512, 512, 1, 131_072),
            (600, 500, 20, 130_800),
            (5, 3, 7, 15),
            (9000, 40, 1, 4096),
        ] {
            let settings = Settings { width, height, samples, ..Settings::of(&scene) };
            let (bands, each) = bands(&settings, tile);
            assert_eq!(bands.len() as u32, BANDS.min(height));
            assert!(each >= 1 && each <= samples);
            let mut rows: Vec<u32> = bands.iter().map(|b| b.y).collect();
            rows.sort_unstable();
            assert!(rows.windows(2).all(|w| w[1] >= w[0] + bands[0].height), "{rows:?}");
            assert!(
                bands
                    .iter()
                    .all(|b| b.pixels() <= tile && b.x + b.width <= width && b.y + b.height <= height),
                "{bands:?}"
            );
            // The first four lie far apart.
            let mut four: Vec<u32> = bands.iter().take(4).map(|b| b.y).collect();
            four.sort_unstable();
            assert!(height < 16 || four.windows(2).all(|w| w[1] - w[0] >= height / 5), "{four:?}");
        }
    }

    #[test]
    fn equal_bands_have_no_spread() {
        assert_eq!(spread(&[(0.5, 10); 4]), 0.0);
        // 1 and 3: mean 2, variance 2, standard error 1, half of the mean.
        assert!((spread(&[(1.0, 1), (3.0, 1)]) - 0.5).abs() < 1e-12);
    }
}

//! A render whose whole image can be seen on its way: rounds of 1, 1, 2, 4, ... samples of every pixel, tile by tile.
//! Between rounds the running sums of all pixels are on the host. A tile goes on from its own, so that the last image
//! has the bits of one that is traced tile by tile with all samples.

use super::batches::{Batches, Drawn, End, Part, mean};
use super::tally::Tally;
use super::{ImageSoFar, Observer, RenderError};
use crate::kernel::abi::Film;
use crate::plan::tiles;
use std::time::Instant;

impl Batches {
    /// All samples of `drawn`, which is empty, until done or cancelled; gives the observer the image after each round.
    /// Gives the share of samples done and what was counted.
    pub(super) fn render_in_rounds(
        &mut self,
        drawn: &mut Drawn,
        observer: &mut dyn Observer,
    ) -> Result<(f64, Tally), RenderError> {
        let (region, samples) = (self.settings.region(), self.settings.samples);
        let sums = self.plan.specialisation.film_sums() as usize;
        let total = drawn.linear.len() as u64 * u64::from(samples);
        let start = Instant::now();
        let mut films = vec![Film::default(); drawn.linear.len() * sums];
        let mut tally = Tally::default();
        let (mut done, mut first) = (0, 0u32);
        while first < samples {
            let end = first.saturating_mul(2).clamp(1, samples);
            let mut work = tiles::tiles(region, self.plan.tile_pixels);
            while let Some(tile) = work.pop() {
                let places = tile.offsets(region).map(|at| at * sums);
                let film: Vec<Film> = places.flat_map(|at| &films[at..at + sums]).copied().collect();
                let film = (first > 0).then_some(&film[..]);
                match self.samples_onto(film, &Part::from(&tile), first..end, observer, done, total)? {
                    End::Done(0, _) => return Ok((done as f64 / total as f64, tally)),
                    End::Done(traced, mut counted) => {
                        let (film, _) = self.film(tile.pixels())?;
                        for (sets, at) in film.chunks(sums).zip(tile.offsets(region)) {
                            films[at * sums..(at + 1) * sums].copy_from_slice(sets);
                            drawn.linear[at] = mean(sets, first + traced);
                        }
                        done += u64::from(tile.pixels()) * u64::from(traced);
                        if first > 0 {
                            // Every tile and pixel counts once.
                            (counted.tiles, counted.pixels) = (0, 0);
                        }
                        tally.add(&counted);
                    }
                    End::Overflow => self.retry(tile, &mut work)?,
                }
                if observer.cancelled() && done < total {
                    return Ok((done as f64 / total as f64, tally));
                }
            }
            first = end;
            observer.image(&ImageSoFar {
                linear: &drawn.linear,
                samples: f64::from(first),
                rays: tally.rays(),
                seconds: start.elapsed().as_secs_f64(),
            });
        }
        Ok((1.0, tally))
    }
}

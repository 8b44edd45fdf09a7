//! The film of an image: the running sums of each pixel, and how many samples are in them. That is all there is to
//! an image on its way: it can be kept, gone on with, shared out, and joined again, and its bits do not tell.

use super::batches::mean;
use super::identity::Mismatch;
use super::resume_state::{Kind, Payload, ResumeState};
use super::tally::Tally;
use crate::kernel::abi::Film;
use crate::plan::tiles::{self, Tile};
use crate::report::{Report, SettingsInfo};
use crate::settings::Share;
use serde::{Deserialize, Serialize};
use std::io::{self, Write};

/// Bytes of a [`Film`] in a file.
const FILM_BYTES: usize = size_of::<Film>();

/// Sums and numbers of samples of an image's pixels; the payload of a render of fixed settings.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Sums {
    /// The share of the image that is rendered; pixels of other shares have no samples.
    pub(super) share: Share,
    /// Sums of a pixel: its replicates.
    sets: u32,
    /// The report without counts and times.
    pub(super) outline: Box<Report>,
    /// `[x0, y0, x1, y1]`, pixels of the image.
    #[serde(skip)]
    region: [u32; 4],
    /// Samples of each pixel, rows from the top.
    #[serde(skip)]
    samples: Vec<u32>,
    /// The same, `sets` a pixel.
    #[serde(skip)]
    films: Vec<Film>,
}

/// An image on its way, and what was counted for it.
#[derive(Default)]
pub(super) struct Drawn {
    pub(super) sums: Sums,
    pub(super) tally: Tally,
}

impl Sums {
    /// No sample yet.
    pub(super) fn new(region: [u32; 4], sets: u32, share: Share, outline: Report) -> Sums {
        let [x0, y0, x1, y1] = region;
        let pixels = (x1 - x0) as usize * (y1 - y0) as usize;
        let films = vec![Film::default(); pixels * sets as usize];
        Sums { share, sets, outline: outline.into(), region, samples: vec![0; pixels], films }
    }

    /// Samples of all pixels.
    pub(super) fn done(&self) -> u64 {
        self.samples.iter().map(|n| u64::from(*n)).sum()
    }

    /// Pixels of the share.
    pub(super) fn pixels(&self) -> u64 {
        if self.share.is_whole() {
            return self.samples.len() as u64;
        }
        tiles::squares_of(self.share, self.region).iter().map(|t| u64::from(t.pixels())).sum()
    }

    /// What is left to do until every pixel of the share has `end` samples: tiles of at most `pixels` pixels, each with
    /// the number of samples that its pixels have. The first is the last.
    pub(super) fn left(&self, end: u32, pixels: u32) -> Vec<(Tile, u32)> {
        let mut left = Vec::new();
        for tile in tiles::tiles_of(self.share, self.region, pixels) {
            let mut parts = vec![tile];
            while let Some(part) = parts.pop() {
                let mut offsets = part.offsets(self.region);
                let first = offsets.next().map_or(end, |at| self.samples[at]);
                if offsets.all(|at| self.samples[at] == first) {
                    left.extend((first < end).then_some((part, first)));
                } else {
                    parts.extend(part.halves().into_iter().flatten());
                }
            }
        }
        left
    }

    /// The sums of a tile.
    pub(super) fn of(&self, tile: &Tile) -> Vec<Film> {
        let sets = self.sets as usize;
        tile.rows(self.region)
            .flat_map(|row| &self.films[row.start * sets..row.end * sets])
            .copied()
            .collect()
    }

    /// Replaces the sums of a tile, whose pixels have `samples` samples now.
    pub(super) fn set(&mut self, tile: &Tile, samples: u32, films: &[Film]) {
        let sets = self.sets as usize;
        let rows = tile.rows(self.region).zip(films.chunks_exact(tile.width as usize * sets));
        for (row, films) in rows {
            self.films[row.start * sets..row.end * sets].copy_from_slice(films);
            self.samples[row].fill(samples);
        }
    }

    /// The image, linear RGB; pixels without samples are black.
    pub(super) fn linear(&self) -> Vec<[f32; 3]> {
        let films = self.films.chunks_exact(self.sets.max(1) as usize);
        films.zip(&self.samples).map(|(sets, samples)| mean(sets, *samples)).collect()
    }

    /// Takes the pixels of `other`, another share of the same image.
    pub(super) fn join(&mut self, other: &Sums) {
        let sets = self.sets as usize;
        for row in
            tiles::squares_of(other.share, self.region).iter().flat_map(|square| square.rows(self.region))
        {
            self.samples[row.clone()].copy_from_slice(&other.samples[row.clone()]);
            let films = row.start * sets..row.end * sets;
            self.films[films.clone()].copy_from_slice(&other.films[films]);
        }
    }

    /// Checks that it is the share `now`.
    pub(super) fn check(&self, now: Share) -> Result<(), Mismatch> {
        let of = |share: Share| match share.is_whole() {
            true => "the whole image".to_owned(),
            false => format!("share {share}"),
        };
        match self.share == now {
            true => Ok(()),
            false => Err(Mismatch(format!("it belongs to {}, this is {}", of(self.share), of(now)))),
        }
    }
}

impl ResumeState<Sums> {
    /// The share that it is of.
    pub fn share(&self) -> Share {
        self.payload.share
    }

    /// Notes how the scene was read in the reports made of it: the variables of its text, and `--up`.
    pub fn set_reading(&mut self, variables: Vec<String>, up: Option<String>) {
        let scene = &mut self.payload.outline.scene;
        (scene.variables, scene.up) = (variables, up);
    }

    /// True if every pixel of its share has all its samples.
    pub fn is_finished(&self) -> bool {
        self.payload.left(self.identity.settings.samples, u32::MAX).is_empty()
    }

    /// Makes a finished picture the beginning of one of `samples` samples a pixel.
    pub(super) fn take_as_first(&mut self, samples: u32) -> Result<(), Mismatch> {
        let there = self.identity.settings.samples;
        let fault = if !self.is_finished() {
            "it is not finished: continue it with --resume first".to_owned()
        } else if there > samples {
            format!("it has {there} samples per pixel, more than {samples}")
        } else if there == 1 && samples > 1 {
            "its one sample per pixel lies at the centre, where none of several does".to_owned()
        } else {
            self.identity.settings.samples = samples;
            return Ok(());
        };
        Err(Mismatch(fault))
    }
}

impl Payload for Sums {
    const KIND: Kind = Kind::Sums;

    /// Runs of pixels with as many samples (their number, then samples and length of each), then the sums of the pixels
    /// that have any.
    fn put(&self, to: &mut dyn Write) -> io::Result<()> {
        let runs: Vec<&[u32]> = self.samples.chunk_by(|a, b| a == b).collect();
        to.write_all(&(runs.len() as u32).to_le_bytes())?;
        for run in &runs {
            to.write_all(&run[0].to_le_bytes())?;
            to.write_all(&(run.len() as u32).to_le_bytes())?;
        }
        let sets = self.sets as usize;
        let (mut at, mut bytes) = (0, Vec::new());
        for run in runs {
            if run[0] > 0 {
                // In pieces that stay in the cache.
                for films in self.films[at * sets..(at + run.len()) * sets].chunks(1024) {
                    bytes.clear();
                    for film in films {
                        film.sum.iter().chain(&film.compensation).for_each(|x| bytes.extend(x.to_le_bytes()));
                    }
                    to.write_all(&bytes)?;
                }
            }
            at += run.len();
        }
        Ok(())
    }

    fn take(&mut self, mut from: &[u8], settings: &SettingsInfo) -> Option<()> {
        let [x0, y0, x1, y1] = settings.region();
        let (width, height) = (x1.checked_sub(x0)? as usize, y1.checked_sub(y0)? as usize);
        let pixels = width.checked_mul(height).filter(|n| *n > 0)?;
        if !self.share.is_sound() || self.sets != settings.replicates.max(1) {
            return None;
        }
        let mut word = || -> Option<u32> {
            let (word, rest) = from.split_first_chunk()?;
            from = rest;
            Some(u32::from_le_bytes(*word))
        };
        let runs = (0..word()?).map(|_| Some((word()?, word()? as usize))).collect::<Option<Vec<_>>>()?;
        let length = |some: &dyn Fn(u32) -> bool| {
            let lengths = runs.iter().filter(|run| some(run.0)).map(|run| run.1);
            lengths.fold(0usize, usize::saturating_add)
        };
        let (films, there) = (pixels.checked_mul(self.sets as usize)?, length(&|n| n > 0));
        let fits = length(&|_| true) == pixels
            && runs.iter().all(|run| run.0 <= settings.samples)
            && Some(from.len()) == there.checked_mul(FILM_BYTES * self.sets as usize);
        if !fits {
            return None;
        }
        self.region = [x0, y0, x1, y1];
        // Memory that is not written is not taken: of a small share only its own pixels are.
        self.samples = bytemuck::allocation::try_zeroed_vec(pixels).ok()?;
        self.films = bytemuck::allocation::try_zeroed_vec(films).ok()?;
        let mut numbers = from.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b));
        let (mut at, sets) = (0, self.sets as usize);
        for (samples, pixels) in runs {
            if samples > 0 {
                self.samples[at..at + pixels].fill(samples);
                for film in &mut self.films[at * sets..(at + pixels) * sets] {
                    film.sum
                        .iter_mut()
                        .chain(&mut film.compensation)
                        .for_each(|x| *x = numbers.next().unwrap_or(0.0));
                }
            }
            at += pixels;
        }
        Some(())
    }
}

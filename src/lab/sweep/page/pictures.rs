//! The pictures of chosen settings, each with its difference from the truth in false colours.

use super::markup::error;
use crate::compare::metrics::Rgb;
use crate::image::heat::heat;
use crate::image::{Metadata, code8, png8};
use crate::lab::sweep::folder::Folder;
use crate::lab::sweep::record::Record;
use crate::lab::sweep::row::Row;
use crate::lab::sweep::truth_tracer::SweepError;
use crate::units::seconds;
use glam::DVec3;
use std::path::Path;

/// Wider pictures are shrunk by a whole factor.
const WIDEST: u32 = 1024;
/// Most settings of the Pareto front that are shown.
const MOST: usize = 8;
/// The false colours span the decades from here to 1.
pub(super) const LEAST: f64 = 1e-4;

/// What the page shows.
#[derive(Default)]
pub(super) struct Pictures {
    /// PNG.
    pub truth: Vec<u8>,
    pub list: Vec<Shown>,
    /// Width and height of every picture.
    pub size: [u32; 2],
}

/// One picture, however many settings gave it.
pub(super) struct Shown {
    /// Why it is shown.
    pub tags: Vec<&'static str>,
    /// Every setting with this picture: name, and its figures in words.
    pub settings: Vec<(String, String)>,
    /// PNG.
    pub picture: Vec<u8>,
    /// PNG of the difference from the truth.
    pub difference: Vec<u8>,
}

/// The truth, and the pictures of settings on the Pareto front, with the largest error, and the
/// slowest.
pub(super) fn pictures(folder: Folder<'_>, record: &Record, truth: &[DVec3]) -> Result<Pictures, SweepError> {
    let Record { width, height, .. } = *record;
    let factor = width.div_ceil(WIDEST).max(1);
    let size = [width.div_ceil(factor), height.div_ceil(factor)];
    let mut list = Vec::new();
    for (row, tags) in chosen(record) {
        let image = folder.picture(row)?;
        let apart: Vec<[f64; 3]> = image.iter().zip(truth).map(|(a, b)| [worst(a, b); 3]).collect();
        let same = record.rows.iter().filter(|r| same_picture(r, row));
        list.push(Shown {
            tags,
            settings: same.map(|r| (r.name.clone(), figures(r))).collect(),
            picture: png(&shrunk(&image, width, factor, mean), size)?,
            difference: png(&shrunk(&apart, width, factor, largest), size)?,
        });
    }
    Ok(Pictures { truth: png(&shrunk(truth, width, factor, mean), size)?, list, size })
}

impl Rgb for [f64; 3] {
    fn rgb(&self) -> [f64; 3] {
        *self
    }
}

fn same_picture(a: &Row, b: &Row) -> bool {
    a.key == b.key || (!a.image.linear_sha256.is_empty() && a.image.linear_sha256 == b.image.linear_sha256)
}

fn figures(row: &Row) -> String {
    let flip = row.error.as_ref().map(|e| e.flip);
    format!("{}, RMSE {}, FLIP {}", seconds(row.seconds()), error(row.rmse()), error(flip))
}

/// Rows with different pictures, each with the reasons to show it.
fn chosen(record: &Record) -> Vec<(&Row, Vec<&'static str>)> {
    let front = super::tables::front_rows(record);
    let by = |value: &dyn Fn(&Row) -> f64| record.rows.iter().max_by(|a, b| value(a).total_cmp(&value(b)));
    let steps = front.len().min(MOST);
    let thinned = (0..steps).map(|i| front[i * (front.len() - 1) / (steps - 1).max(1)]);
    let reasons = thinned
        .map(|row| (row, "Pareto front"))
        .chain(by(&|r| r.rmse().unwrap_or(-1.0)).map(|row| (row, "largest error")))
        .chain(by(&|r| r.seconds()).map(|row| (row, "slowest")));
    let mut list: Vec<(&Row, Vec<&'static str>)> = Vec::new();
    for (row, reason) in reasons {
        match list.iter_mut().find(|(other, _)| same_picture(other, row)) {
            Some((_, tags)) if tags.contains(&reason) => {}
            Some((_, tags)) => tags.push(reason),
            None => list.push((row, vec![reason])),
        }
    }
    list
}

/// The largest difference of any channel, as shown.
fn worst(a: &[f32; 3], b: &DVec3) -> f64 {
    let channels = a.rgb().into_iter().zip(b.rgb());
    channels.map(|(a, b)| (a.clamp(0.0, 1.0) - b.clamp(0.0, 1.0)).abs()).fold(0.0, f64::max)
}

/// 8-bit codes of the mean of a block.
fn mean(block: &[[f64; 3]]) -> [u8; 3] {
    let n = block.len() as f64;
    std::array::from_fn(|c| code8((block.iter().map(|p| p[c].clamp(0.0, 1.0)).sum::<f64>() / n) as f32))
}

/// The false colour of the largest of a block: shrinking must not hide it.
fn largest(block: &[[f64; 3]]) -> [u8; 3] {
    false_color(block.iter().map(|p| p[0]).fold(0.0, f64::max))
}

/// Decades from [`LEAST`] to 1; black below.
fn false_color(error: f64) -> [u8; 3] {
    heat(1.0 - error.log10() / LEAST.log10())
}

/// Blocks of `factor` by `factor` pixels, fewer at the far edges, each through `to_code`.
fn shrunk<P: Rgb>(image: &[P], width: u32, factor: u32, to_code: fn(&[[f64; 3]]) -> [u8; 3]) -> Vec<u8> {
    let (width, factor) = (width as usize, factor as usize);
    let rows: Vec<&[P]> = image.chunks(width).collect();
    let mut rgb = Vec::new();
    for band in rows.chunks(factor) {
        for x in (0..width).step_by(factor) {
            let end = (x + factor).min(width);
            let block: Vec<[f64; 3]> = band.iter().flat_map(|row| row[x..end].iter().map(P::rgb)).collect();
            rgb.extend(to_code(&block));
        }
    }
    rgb
}

fn png(rgb: &[u8], [width, height]: [u32; 2]) -> Result<Vec<u8>, SweepError> {
    let mut bytes = Vec::new();
    let nothing: [(&str, &str); 0] = [];
    png8(width, height, rgb, &Metadata::new(nothing), &mut bytes)
        .map_err(SweepError::file(Path::new("index.html")))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn false_colours_span_the_decades() {
        assert_eq!((false_color(0.0), false_color(LEAST)), (heat(0.0), heat(0.0)));
        assert_eq!(
            (false_color(1e-2), false_color(1.0), false_color(7.0)),
            (heat(0.5), heat(1.0), heat(1.0))
        );
    }

    #[test]
    fn one_wrong_pixel_survives_the_shrinking() {
        let mut apart = vec![[0.0; 3]; 12];
        apart[5] = [1.0; 3];
        let rgb = shrunk(&apart, 4, 2, largest);
        assert_eq!((&rgb[..3], &rgb[3..6]), (&heat(1.0)[..], &heat(0.0)[..]));
        assert_eq!(rgb.len(), 2 * 2 * 3, "the last band is half as high");
    }

    fn row(k: usize) -> Row {
        let mut row = Row { key: k.to_string(), name: k.to_string(), on_front: k < 20, ..Row::default() };
        row.measured.render.median = k as f64;
        row
    }

    #[test]
    fn the_front_is_thinned_and_the_extremes_are_there() {
        let record = Record { rows: (0..30).map(row).collect(), ..Record::default() };
        let names: Vec<&str> = chosen(&record).iter().map(|(r, _)| r.name.as_str()).collect();
        assert!(names.contains(&"0") && names.contains(&"19") && names.contains(&"29"), "{names:?}");
        assert!(names.len() <= MOST + 2);
        assert!(chosen(&Record::default()).is_empty());
    }

    #[test]
    fn equal_pictures_are_shown_once_with_every_reason() {
        let mut rows: Vec<Row> = [5, 29].map(row).into();
        assert_eq!(chosen(&Record { rows: rows.clone(), ..Record::default() }).len(), 2);
        rows.iter_mut().for_each(|r| r.image.linear_sha256 = "abc".into());
        let record = Record { rows, ..Record::default() };
        let list = chosen(&record);
        assert_eq!(list.len(), 1);
        assert!(list[0].1.contains(&"Pareto front") && list[0].1.contains(&"slowest"));
    }
}

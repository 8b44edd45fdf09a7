//! The pictures of chosen settings, each with its difference from the truth in false colours.

use crate::lab::page::markup::error;
use crate::lab::page::pictures::{difference, fitted, picture};
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
    let whole = [record.width, record.height];
    let page = SweepError::file(Path::new("index.html"));
    let mut list = Vec::new();
    for (row, tags) in chosen(record) {
        let image = folder.picture(row)?;
        let same = record.rows.iter().filter(|r| same_picture(r, row));
        list.push(Shown {
            tags,
            settings: same.map(|r| (r.name.clone(), figures(r))).collect(),
            picture: picture(&image, whole, WIDEST).map_err(&page)?,
            difference: difference(&image, truth, whole, WIDEST).map_err(&page)?,
        });
    }
    let truth = picture(truth, whole, WIDEST).map_err(&page)?;
    Ok(Pictures { truth, list, size: fitted(whole, WIDEST).1 })
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

#[cfg(test)]
mod tests {
    use super::*;

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

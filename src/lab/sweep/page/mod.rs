//! The page of a sweep: one file with plots, tables and pictures, and the plots as separate files.

mod charts;
mod html;
mod pictures;
mod rows;
mod tables;

use super::folder::Folder;
use super::record::Record;
use super::truth_tracer::SweepError;
use crate::image::{Metadata, png8};
use crate::lab::plot;
use glam::DVec3;

/// Pixels of a plot.
const SIZE: (u32, u32) = (560, 420);

/// Writes `index.html` and the plots as SVG and PNG. `truth` are the pixels that the rows were
/// judged by.
///
/// # Errors
/// If a picture cannot be read, or a file not written.
pub(super) fn write(folder: Folder<'_>, record: &Record, truth: &[DVec3]) -> Result<(), SweepError> {
    let mut plots = Vec::new();
    for drawn in charts::plots(record) {
        let chart = [drawn.chart.clone()];
        let svg = plot::svg(&chart, SIZE).map_err(SweepError::Plot)?;
        let (width, height, rgb) = plot::pixels(&chart, SIZE).map_err(SweepError::Plot)?;
        folder.write(&format!("{}.svg", drawn.name), &mut |out| out.write_all(svg.as_bytes()))?;
        let metadata = Metadata::new([("Software", "whitted sweep"), ("Description", drawn.caption)]);
        folder.write(&format!("{}.png", drawn.name), &mut |out| png8(width, height, &rgb, &metadata, out))?;
        plots.push((drawn, svg));
    }
    let pictures = pictures::pictures(folder, record, truth)?;
    let text = html::page(record, &plots, &pictures);
    folder.write("index.html", &mut |out| out.write_all(text.as_bytes()))
}

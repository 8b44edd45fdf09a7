//! The page of a sweep: one file with plots, tables and pictures, and the plots beside it.

mod charts;
mod html;
mod pictures;

use super::record::Record;
use super::trace::SweepError;
use crate::atomic_file;
use crate::image::{Metadata, png8};
use crate::lab::plot;
use glam::DVec3;
use std::io::Write;
use std::path::Path;

/// Pixels of a plot.
const SIZE: (u32, u32) = (560, 420);

/// Writes `index.html` and the plots as SVG and PNG. `truth` are the pixels that judged the rows.
///
/// # Errors
/// If a picture cannot be read, or a file not written.
pub fn write(folder: &Path, record: &Record, truth: &[DVec3]) -> Result<(), SweepError> {
    let mut plots = Vec::new();
    for (name, chart) in charts::charts(record) {
        let chart = [chart];
        let svg = plot::svg(&chart, SIZE).map_err(SweepError::Plot)?;
        let (width, height, rgb) = plot::pixels(&chart, SIZE).map_err(SweepError::Plot)?;
        save(&folder.join(format!("{name}.svg")), &mut |out| out.write_all(svg.as_bytes()))?;
        let metadata = Metadata::new([("Software", "whitted sweep")]);
        save(&folder.join(format!("{name}.png")), &mut |out| png8(width, height, &rgb, &metadata, out))?;
        plots.push(svg);
    }
    let shown = pictures::shown(folder, record, truth)?;
    let text = html::page(record, &plots, &shown);
    save(&folder.join("index.html"), &mut |out| out.write_all(text.as_bytes()))
}

fn save(path: &Path, fill: &mut dyn FnMut(&mut dyn Write) -> std::io::Result<()>) -> Result<(), SweepError> {
    atomic_file::write(path, |out| fill(out)).map_err(SweepError::file(path))
}

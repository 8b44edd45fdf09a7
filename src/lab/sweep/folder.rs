//! Files in a sweep's folder: the record (`sweep.json`, `sweep.csv`), the truth (`truth.bin`) and
//! one picture per row (`points/KEY.exr`).

use super::record::Record;
use super::row::Row;
use super::truth::{Identity, Truth};
use super::truth_tracer::SweepError;
use crate::atomic_file;
use crate::image::{Format, Metadata, Picture, View, linear_sha256};
use crate::render::{Rendered, ResumeState, State, Sums};
use crate::report::Report;
use std::fs::{self, File};
use std::io::{self, BufReader, Write};
use std::path::{Path, PathBuf};

/// A sweep's folder. Files are replaced whole or not at all.
#[derive(Debug, Clone, Copy)]
pub(super) struct Folder<'a>(&'a Path);

impl<'a> Folder<'a> {
    /// The folder at `path`; it need not exist.
    pub(super) fn new(path: &'a Path) -> Folder<'a> {
        Folder(path)
    }

    /// Creates the folder and the one for pictures.
    pub(super) fn create(self) -> Result<(), SweepError> {
        let points = self.path("points");
        fs::create_dir_all(&points).map_err(SweepError::file(&points))
    }

    fn path(self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Writes one file through `fill`.
    pub(super) fn write(
        self,
        name: &str,
        fill: &mut dyn FnMut(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), SweepError> {
        let path = self.path(name);
        atomic_file::write(&path, |out| fill(out)).map_err(SweepError::file(&path))
    }

    /// The record of an earlier run; `None` if there is no `sweep.json`.
    pub(super) fn record(self) -> Result<Option<Record>, SweepError> {
        let path = self.path("sweep.json");
        if !path.exists() {
            return Ok(None);
        }
        let text = fs::read_to_string(&path).map_err(SweepError::file(&path))?;
        serde_json::from_str(&text).map(Some).map_err(|e| {
            let text = format!("not the record of a sweep ({e}); start over with --fresh");
            SweepError::File { path, error: io::Error::other(text) }
        })
    }

    /// Writes `sweep.json`.
    pub(super) fn write_json(self, record: &Record) -> Result<(), SweepError> {
        self.write("sweep.json", &mut |out| {
            serde_json::to_writer_pretty(&mut *out, record)?;
            out.write_all(b"\n")
        })
    }

    /// Writes `sweep.csv`.
    pub(super) fn write_csv(self, record: &Record) -> Result<(), SweepError> {
        self.write("sweep.csv", &mut |out| out.write_all(record.csv().as_bytes()))
    }

    /// The stored truth; `None` if the file is missing, damaged or the truth of something else.
    pub(super) fn truth(self, identity: &Identity) -> Option<Truth> {
        let file = File::open(self.path("truth.bin")).ok()?;
        Truth::load(&mut BufReader::new(file), identity).ok()?
    }

    /// Writes `truth.bin`.
    pub(super) fn write_truth(self, truth: &Truth) -> Result<(), SweepError> {
        self.write("truth.bin", &mut |out| truth.save(out))
    }

    /// Name of the picture of a row with this key, relative to the folder.
    pub(super) fn picture_name(key: &str) -> String {
        format!("points/{key}.exr")
    }

    /// True if the picture of `row` is stored, every bit of it.
    pub(super) fn has_picture(self, row: &Row) -> bool {
        self.picture(row).is_ok()
    }

    /// The picture of a row: linear RGB, rows from the top.
    pub(super) fn picture(self, row: &Row) -> Result<Vec<[f32; 3]>, SweepError> {
        let path = self.path(&row.image.file);
        let broken = |why: &dyn std::fmt::Display| SweepError::File {
            path: path.clone(),
            error: io::Error::other(format!("{why}; the same command renders it again")),
        };
        let linear = Picture::read(&path).map_err(|error| broken(&error))?.linear;
        match linear_sha256(&linear) == row.image.linear_sha256 {
            true => Ok(linear),
            false => Err(broken(&"the picture is damaged")),
        }
    }

    fn state_path(self, key: &str) -> PathBuf {
        self.path(&format!("points/{key}.partial"))
    }

    /// What was kept of a point on its way; `None` if there is nothing, or it is damaged.
    pub(super) fn state(self, key: &str) -> Option<ResumeState<Sums>> {
        let file = File::open(self.state_path(key)).ok()?;
        ResumeState::read(&mut BufReader::new(file)).ok()
    }

    /// Keeps the state of a point.
    pub(super) fn write_state(self, key: &str, state: &dyn State) -> Result<(), SweepError> {
        let path = self.state_path(key);
        atomic_file::write(&path, |out| state.write(out)).map_err(SweepError::file(&path))
    }

    /// Removes the states of points that are not among the `wanted` keys.
    pub(super) fn remove_states_but(self, wanted: &[String]) {
        let Ok(entries) = fs::read_dir(self.path("points")) else { return };
        for path in entries.flatten().map(|entry| entry.path()) {
            let key = path.file_stem().unwrap_or_default();
            let is_state = path.extension().is_some_and(|e| e == "partial");
            if is_state && !wanted.iter().any(|w| key == w.as_str()) {
                let _ = fs::remove_file(path);
            }
        }
    }

    /// Removes the state of a point that is done. One that cannot be removed only takes room.
    pub(super) fn remove_state(self, key: &str) {
        let _ = fs::remove_file(self.state_path(key));
    }

    /// Writes a picture to the file that its report names.
    pub(super) fn write_picture(self, rendered: &Rendered, report: &Report) -> Result<(), SweepError> {
        let view = View { width: rendered.width, height: rendered.height, linear: &rendered.linear };
        let metadata = Metadata::of(report, rendered.done);
        self.write(&report.image.file, &mut |out| Format::Exr.encode(view, &metadata, out))
    }

    /// Removes the picture of a row that is no longer wanted. A file that cannot be removed only
    /// takes room.
    pub(super) fn remove_picture(self, row: &Row) {
        let _ = fs::remove_file(self.path(&row.image.file));
    }
}

//! Saving a rendered image to a file.

use super::{Format, Metadata, View};
use crate::atomic_file;
use crate::report::Report;
use std::io;
use std::path::{Path, PathBuf};

/// Why an image is not saved.
#[derive(Debug, thiserror::Error)]
pub enum SaveError {
    /// The file name does not end like a format that can be written.
    #[error("{}: the extension is none of {}", path.display(), Format::EXTENSIONS)]
    Extension {
        /// Of the file.
        path: PathBuf,
    },
    /// The file cannot be written.
    #[error("cannot write {}", path.display())]
    Write {
        /// Of the file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
}

/// Writes `view` in the format that the extension of `path` names, whole or not at all. `report` and `done`, the share
/// of the work that was finished, become the file's metadata.
pub(crate) fn save(path: &Path, view: View<'_>, report: &Report, done: f64) -> Result<(), SaveError> {
    let format = Format::of(path).ok_or_else(|| SaveError::Extension { path: path.to_owned() })?;
    let metadata = Metadata::of(report, done);
    atomic_file::write(path, |out| format.encode(view, &metadata, out))
        .map_err(|source| SaveError::Write { path: path.to_owned(), source })
}

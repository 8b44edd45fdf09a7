//! The file of records beside the tables: JSON lines, a header and then one line per scene.

use super::plan::Header;
use super::record::SceneRecord;
use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Records, in an open file or only here.
#[derive(Debug, Default)]
pub struct Store {
    path: PathBuf,
    file: Option<File>,
    records: Vec<SceneRecord>,
}

/// Why a file of records cannot be continued.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// It cannot be read or written.
    #[error("cannot use {}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: io::Error,
    },
    /// It holds something else.
    #[error("{} line {line} is no record of a calibration: {why}; choose another -o, or remove that file", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// From 1.
        line: usize,
        /// The reason.
        why: String,
    },
    /// It was made by other trials.
    #[error("{} holds records of other trials ({difference}); choose another -o, or remove that file", path.display())]
    Other {
        /// The file.
        path: PathBuf,
        /// What differs.
        difference: String,
    },
}

impl Store {
    /// Opens the file at `path`, or begins it. A last line without an end, as a crash leaves it, is removed.
    ///
    /// # Errors
    /// If the file cannot be read or written, is something else, or was made by other trials.
    pub fn open(path: &Path, header: &Header) -> Result<Store, StoreError> {
        let failed = |source| StoreError::File { path: path.to_owned(), source };
        let file = OpenOptions::new().read(true).append(true).create(true).open(path).map_err(failed)?;
        let text = std::fs::read_to_string(path).map_err(failed)?;
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        let mut store = Store { path: path.to_owned(), file: None, records: Vec::new() };
        let foreign = |line: usize, error: serde_json::Error| StoreError::Foreign {
            path: path.to_owned(),
            line: line + 1,
            why: error.to_string(),
        };
        let mut lines = text[..whole].lines().enumerate();
        match lines.next() {
            None if text.is_empty() || text.starts_with("{\"program\"") => {
                file.set_len(0).map_err(failed)?;
                store.file = Some(file);
                store.append(header)?;
            }
            None => {
                let why = "it has no complete line".to_owned();
                return Err(StoreError::Foreign { path: path.to_owned(), line: 1, why });
            }
            Some((at, line)) => {
                let there: Header = serde_json::from_str(line).map_err(|e| foreign(at, e))?;
                if let Some(difference) = header.difference(&there) {
                    return Err(StoreError::Other { path: path.to_owned(), difference });
                }
                for (at, line) in lines {
                    store.records.push(serde_json::from_str(line).map_err(|e| foreign(at, e))?);
                }
                file.set_len(whole as u64).map_err(failed)?;
                store.file = Some(file);
            }
        }
        Ok(store)
    }

    /// The records so far.
    pub fn records(&self) -> &[SceneRecord] {
        &self.records
    }

    /// True if a scene has its record.
    pub fn has(&self, family: &str, number: u32) -> bool {
        self.records.iter().any(|r| r.family == family && r.number == number)
    }

    /// Appends a record, on the disk when this returns.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn push(&mut self, record: SceneRecord) -> Result<(), StoreError> {
        self.append(&record)?;
        self.records.push(record);
        Ok(())
    }

    fn append(&mut self, value: &impl serde::Serialize) -> Result<(), StoreError> {
        let Some(file) = &mut self.file else { return Ok(()) };
        let failed = |source| StoreError::File { path: self.path.clone(), source };
        let mut line = serde_json::to_vec(value).map_err(|e| failed(e.into()))?;
        line.push(b'\n');
        // One write at the end of the file: a line is there or is recognised as unfinished.
        file.write_all(&line).and_then(|()| file.sync_data()).map_err(failed)
    }
}

#[cfg(test)]
mod tests {
    use super::super::plan::Trials;
    use super::*;
    use crate::report::{DeviceInfo, ProgramInfo};

    fn header(seeds: u32) -> Header {
        let trials = Trials {
            seed: 1,
            width: 8,
            height: 6,
            seeds,
            samples: vec![4],
            errors: vec![0.03],
            times: Vec::new(),
            confidence: 0.95,
            truth_rays: 1e6,
        };
        let (program, device) = (ProgramInfo::default(), DeviceInfo::default());
        Header { program, device, trials, files: Vec::new() }
    }

    fn record(number: u32) -> SceneRecord {
        SceneRecord { family: "wires".into(), number, ..SceneRecord::default() }
    }

    #[test]
    fn records_come_back_and_half_a_line_is_written_anew() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("records.jsonl");
        let mut store = Store::open(&path, &header(2)).unwrap();
        store.push(record(0)).unwrap();
        store.push(record(1)).unwrap();
        drop(store);
        let text = std::fs::read_to_string(&path).unwrap();
        // A crash in the middle of the last line.
        std::fs::write(&path, &text[..text.len() - 9]).unwrap();
        let mut store = Store::open(&path, &header(2)).unwrap();
        assert!(store.has("wires", 0) && !store.has("wires", 1));
        store.push(record(1)).unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
        assert_eq!(Store::open(&path, &header(2)).unwrap().records(), [record(0), record(1)]);
    }

    #[test]
    fn other_trials_and_other_files_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("records.jsonl");
        drop(Store::open(&path, &header(2)).unwrap());
        let error = Store::open(&path, &header(3)).unwrap_err().to_string();
        assert!(error.contains("--seeds 2 there, 3 now") && error.contains("remove"), "{error}");
        for text in ["# A page\n", "# A page"] {
            std::fs::write(&path, text).unwrap();
            assert!(Store::open(&path, &header(2)).is_err());
            assert_eq!(std::fs::read_to_string(&path).unwrap(), text, "left as it was");
        }
    }
}

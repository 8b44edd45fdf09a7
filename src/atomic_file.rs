//! Files that appear whole or not at all: written beside the target, synced, renamed over it.

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Writes `path` through `fill`. On any error the old file, if there was one, is untouched and
/// nothing is left beside it. Devices and pipes are written in place.
pub fn write(path: &Path, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    if is_special(path) {
        let mut out = BufWriter::new(OpenOptions::new().write(true).open(path)?);
        fill(&mut out)?;
        return out.flush();
    }
    let target = followed(path);
    let (partial, file) = Partial::create(&target)?;
    let mut out = BufWriter::new(file);
    fill(&mut out)?;
    out.into_inner().map_err(io::IntoInnerError::into_error)?.sync_all()?;
    partial.rename_to(&target)?;
    sync_folder(&target);
    Ok(())
}

/// Writes `bytes` to `path`, without waiting for the disk: a power cut may leave the file damaged, which its
/// reader must be able to tell.
pub fn write_unsynced(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let (partial, mut file) = Partial::create(path)?;
    file.write_all(bytes)?;
    partial.rename_to(path)
}

/// Name of an output that is not complete, beside the one it would have: `a.incomplete.png` for `a.png`. A file under
/// its own name is a complete one.
pub fn incomplete(path: &Path) -> PathBuf {
    match path.extension() {
        Some(extension) => {
            let mut end = OsString::from("incomplete.");
            end.push(extension);
            path.with_extension(end)
        }
        None => path.with_extension("incomplete"),
    }
}

/// Checks that [`write()`] could create `path`, so that long work is not lost at its end. Leaves
/// nothing behind.
pub fn check(path: &Path) -> io::Result<()> {
    if path.is_dir() {
        return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a directory"));
    }
    if is_special(path) {
        return Ok(());
    }
    let target = followed(path);
    let folder = folder_of(&target);
    if !folder.is_dir() {
        let text = format!("there is no directory {}", folder.display());
        return Err(io::Error::new(io::ErrorKind::NotFound, text));
    }
    Partial::create(&target).map(drop)
}

/// A link stays a link: the file it names is replaced.
fn followed(path: &Path) -> PathBuf {
    fs::canonicalize(path).unwrap_or_else(|_| path.to_owned())
}

fn is_special(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|m| !m.is_file() && !m.is_dir())
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// The file on its way; removed on drop unless renamed.
struct Partial {
    path: PathBuf,
    renamed: bool,
}

impl Partial {
    fn create(target: &Path) -> io::Result<(Partial, File)> {
        let name = target
            .file_name()
            .ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "it has no file name"))?
            .to_string_lossy();
        for attempt in 0u32.. {
            let path = folder_of(target).join(format!(".{name}.{}-{attempt}.partial", std::process::id()));
            match OpenOptions::new().write(true).create_new(true).open(&path) {
                Ok(file) => return Ok((Partial { path, renamed: false }, file)),
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
            }
        }
        Err(io::Error::other("no free name for the partial file"))
    }

    fn rename_to(mut self, target: &Path) -> io::Result<()> {
        fs::rename(&self.path, target)?;
        self.renamed = true;
        Ok(())
    }
}

impl Drop for Partial {
    fn drop(&mut self) {
        if !self.renamed {
            // Nothing better can be done while an error is already under way.
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// Makes the rename itself last through a power cut, where the file system can do that: the file is
/// whole either way.
fn sync_folder(target: &Path) {
    let _ = File::open(folder_of(target)).and_then(|folder| folder.sync_all());
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_appears_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        for text in ["one", "another"] {
            check(&path).unwrap();
            write(&path, |out| out.write_all(text.as_bytes())).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
            assert_eq!(names(folder.path()), ["a.png"]);
        }
    }

    #[test]
    fn a_failure_leaves_the_old_file_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        fs::write(&path, "old").unwrap();
        let result = write(&path, |out| {
            out.write_all(b"half of the new")?;
            Err(io::Error::other("stopped"))
        });
        assert_eq!(result.unwrap_err().to_string(), "stopped");
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(names(folder.path()), ["a.png"]);
    }

    #[test]
    fn an_incomplete_file_has_a_name_of_its_own() {
        for (name, beside) in [
            ("d/a.png", "d/a.incomplete.png"),
            ("a.b.EXR", "a.b.incomplete.EXR"),
            ("d.e/a", "d.e/a.incomplete"),
        ] {
            assert_eq!(incomplete(Path::new(name)), Path::new(beside));
        }
    }

    #[test]
    fn check_tells_what_is_wrong() {
        let folder = tempfile::tempdir().unwrap();
        let missing = check(&folder.path().join("no/a.png")).unwrap_err();
        assert!(missing.to_string().starts_with("there is no directory"), "{missing}");
        assert_eq!(check(folder.path()).unwrap_err().to_string(), "it is a directory");
        assert_eq!(names(folder.path()), [""; 0]);
    }

    #[cfg(unix)]
    #[test]
    fn links_and_devices_stay_what_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let (real, link) = (folder.path().join("real.png"), folder.path().join("link.png"));
        fs::write(&real, "old").unwrap();
        std::os::unix::fs::symlink(&real, &link).unwrap();
        write(&link, |out| out.write_all(b"new")).unwrap();
        assert!(link.is_symlink());
        assert_eq!(fs::read_to_string(&real).unwrap(), "new");

        check(Path::new("/dev/null")).unwrap();
        write(Path::new("/dev/null"), |out| out.write_all(b"gone")).unwrap();
        assert!(is_special(Path::new("/dev/null")));
    }
}

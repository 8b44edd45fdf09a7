//! Files of a command line: none that is written may be one that is read, or another one that is written. Files are
//! compared by identity, not by name: `a.png`, `./b/../a.png`, a link to it and a hard link are one file, and so is a
//! file that does not exist yet, by whatever way its folder is named. Every command asks here before it does anything.

use super::console;
use super::failure::Failure;
use crate::atomic_file;
use crate::scene::Scene;
use anyhow::Context;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

/// Links in a row that are followed to a file that does not exist, as many as systems follow.
const LINKS: u32 = 40;

/// What messages call it.
const STANDARD_OUTPUT: &str = "standard output";

/// What a command reads and writes.
#[derive(Debug, Default)]
pub(super) struct Files {
    reads: Vec<Named>,
    writes: Vec<Named>,
    /// Folders in which a command writes files under names of its own.
    fills: Vec<Named>,
    /// True if the result goes to standard output.
    to_standard_output: bool,
}

/// A file with its place on the command line.
#[derive(Debug)]
struct Named {
    /// For messages: `--report r.json`.
    what: String,
    path: PathBuf,
    identity: Option<Identity>,
    /// False for what is written only in some cases: whether it can be is not tried.
    always: bool,
}

/// What makes two names one file.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Identity {
    /// Device and inode.
    #[cfg(unix)]
    Inode(u64, u64),
    /// The name that the system gives a file that exists.
    #[cfg(not(unix))]
    Canonical(PathBuf),
    /// A file that does not exist yet: its folder and its name there.
    New(Box<Identity>, OsString),
}

impl Files {
    /// None yet.
    pub(super) fn new() -> Files {
        Files::default()
    }

    /// A file that is read; `what` names it on the command line.
    pub(super) fn reads(mut self, what: &str, path: &Path) -> Files {
        self.reads.push(Named::of(what, path));
        self
    }

    /// The files that a scene was read from.
    pub(super) fn reads_scene(self, scene: &Scene) -> Files {
        scene.files().fold(self, |files, path| files.reads("the scene's file", path))
    }

    /// A file that is written, if there is one; `-` is standard output.
    pub(super) fn writes(mut self, what: &str, path: Option<&Path>) -> Files {
        match path {
            Some(path) if path.as_os_str() == "-" => {
                self.to_standard_output = true;
                self.prints()
            }
            Some(path) => {
                self.writes.push(Named::of(what, path));
                self
            }
            None => self,
        }
    }

    /// A file that is written in some cases, such as at an interrupt.
    pub(super) fn may_write(mut self, what: &str, path: &Path) -> Files {
        self.writes.push(Named { always: false, ..Named::of(what, path) });
        self
    }

    /// A folder that the command fills with files.
    pub(super) fn fills(mut self, what: &str, folder: &Path) -> Files {
        self.fills.push(Named::of(what, folder));
        self
    }

    /// Standard output, which may have been sent to a file.
    pub(super) fn prints(mut self) -> Files {
        let is_new = self.writes.iter().all(|file| file.what != STANDARD_OUTPUT);
        if let Some(identity) = standard_output().filter(|_| is_new) {
            let (what, path) = (STANDARD_OUTPUT.to_owned(), PathBuf::new());
            self.writes.push(Named { what, path, identity: Some(identity), always: false });
        }
        self
    }

    /// Checks that no file is overwritten that was named for something else, then that all can be written.
    ///
    /// # Errors
    /// [`Failure::Usage`] names the two; another failure says why a file cannot be written.
    pub(super) fn check(&self) -> Result<(), Failure> {
        for (at, file) in self.writes.iter().enumerate() {
            let Some(identity) = &file.identity else { continue };
            let is_same = |other: &&Named| other.identity.as_ref() == Some(identity);
            if let Some(read) = self.reads.iter().find(is_same) {
                return Err(usage(format!("{} would overwrite {}", file.what, read.what)));
            }
            if let Some(other) = self.writes[..at].iter().find(is_same) {
                return Err(usage(format!("{} and {} name the same file", other.what, file.what)));
            }
        }
        for folder in &self.fills {
            if let Some(read) = self.reads.iter().find(|read| folder.holds(&read.path)) {
                let (what, read) = (&folder.what, &read.what);
                return Err(usage(format!("{what} would fill the folder of {read}, and might overwrite it")));
            }
        }
        if self.to_standard_output && console::is_closed() {
            return Err(usage(
                "standard output is closed: what goes there would be lost; redirect it or name a file".into(),
            ));
        }
        for file in self.writes.iter().filter(|file| file.always) {
            atomic_file::check(&file.path)
                .with_context(|| format!("cannot write {}", file.path.display()))?;
        }
        Ok(())
    }
}

impl Named {
    fn of(what: &str, path: &Path) -> Named {
        let what = format!("{what} {}", path.display());
        Named { what, path: path.to_owned(), identity: identity(path, LINKS), always: true }
    }

    /// True if `file` lies in this folder, or below it.
    fn holds(&self, file: &Path) -> bool {
        let Ok(real) = fs::canonicalize(file) else { return false };
        self.identity.is_some() && real.ancestors().skip(1).any(|a| identity(a, LINKS) == self.identity)
    }
}

fn usage(why: String) -> Failure {
    Failure::Usage(why)
}

/// What `path` stands for; None for devices and pipes, which hold nothing that could be overwritten, and for a name
/// in a folder that does not exist.
fn identity(path: &Path, links: u32) -> Option<Identity> {
    if let Ok(about) = fs::metadata(path) {
        return existing(path, &about);
    }
    if let Ok(target) = fs::read_link(path) {
        // A link to a file that does not exist.
        let target = folder_of(path).join(target);
        return links.checked_sub(1).and_then(|links| identity(&target, links));
    }
    let name = path.file_name()?.to_owned();
    // Folders of these systems tell names apart by more than their case.
    let name = if cfg!(any(windows, target_os = "macos")) { name.to_ascii_lowercase() } else { name };
    Some(Identity::New(Box::new(identity(folder_of(path), LINKS)?), name))
}

#[cfg(unix)]
fn existing(_: &Path, about: &fs::Metadata) -> Option<Identity> {
    use std::os::unix::fs::MetadataExt;
    (about.is_file() || about.is_dir()).then(|| Identity::Inode(about.dev(), about.ino()))
}

#[cfg(not(unix))]
fn existing(path: &Path, about: &fs::Metadata) -> Option<Identity> {
    let real = (about.is_file() || about.is_dir()).then(|| fs::canonicalize(path).ok());
    real.flatten().map(Identity::Canonical)
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// The file that standard output goes to, if it is one.
#[cfg(unix)]
fn standard_output() -> Option<Identity> {
    use std::os::fd::AsFd;
    let own = std::io::stdout().as_fd().try_clone_to_owned().ok()?;
    let about = fs::File::from(own).metadata().ok()?;
    about.is_file().then(|| existing(Path::new(""), &about))?
}

#[cfg(not(unix))]
fn standard_output() -> Option<Identity> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Why `files` is refused before anything runs; None if it is not.
    fn refusal(files: &Files) -> Option<String> {
        match files.check() {
            Ok(()) => None,
            Err(failure @ Failure::Usage(_)) => Some(failure.message()),
            Err(other) => panic!("{other:?}"),
        }
    }

    #[test]
    fn different_files_are_not_mixed_up() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("in"), "").unwrap();
        fs::create_dir(at("d")).unwrap();
        let out = [at("a"), at("b"), at("d/a"), at("d/in")];
        let files = out.iter().fold(Files::new().reads("IN", &at("in")), |f, o| f.writes("OUT", Some(o)));
        assert_eq!(refusal(&files), None);
        // Devices take from everyone.
        let null = Path::new("/dev/null");
        let files = Files::new().reads("IN", null).writes("A", Some(null)).writes("B", Some(null));
        assert_eq!(refusal(&files), None);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "nothing is left");
    }

    #[cfg(unix)]
    #[test]
    fn one_file_is_known_by_all_its_names() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("d")).unwrap();
        std::os::unix::fs::symlink(at("d"), at("way")).unwrap();
        // One file that exists, one that does not.
        fs::write(at("d/there"), "").unwrap();
        std::os::unix::fs::symlink("there", at("d/link-there")).unwrap();
        std::os::unix::fs::symlink("new", at("d/link-new")).unwrap();
        std::os::unix::fs::symlink("link-new", at("d/link-link-new")).unwrap();
        fs::hard_link(at("d/there"), at("hard")).unwrap();
        let there = ["d/there", "d/../d/there", "way/there", "d/link-there", "hard", "d/./there"];
        let new = ["d/new", "d/../way/new", "way/new", "d/link-new", "way/link-link-new"];
        for names in [&there[..], &new[..]] {
            for (a, b) in names.iter().flat_map(|a| names.iter().map(move |b| (at(a), at(b)))) {
                let both = Files::new().writes("-o", Some(&a)).writes("--report", Some(&b));
                let why = refusal(&both).unwrap_or_else(|| panic!("{a:?} {b:?}"));
                assert!(why.contains("-o") && why.contains("--report") && why.contains("same file"), "{why}");
                let over = Files::new().reads("the scene", &a).writes("--json", Some(&b));
                let why = refusal(&over).unwrap_or_else(|| panic!("{a:?} {b:?}"));
                assert!(why.contains("would overwrite the scene"), "{why}");
            }
        }
        for (a, b) in [("d/there", "d/new"), ("hard", "way/new"), ("d/new", "new")] {
            let files = Files::new().writes("-o", Some(&at(a))).writes("--report", Some(&at(b)));
            assert_eq!(refusal(&files), None, "{a} {b}");
        }
        // A ring of links ends.
        std::os::unix::fs::symlink("ring", at("ring")).unwrap();
        assert_eq!(identity(&at("ring"), LINKS), None);
    }

    #[test]
    fn a_folder_to_fill_holds_no_file_that_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("out")).unwrap();
        fs::create_dir(at("out/below")).unwrap();
        for name in ["scene", "out/scene", "out/below/scene"] {
            fs::write(at(name), "").unwrap();
            let files = Files::new().reads("the scene", &at(name)).fills("-o", &at("out/../out"));
            assert_eq!(refusal(&files).is_some(), name.starts_with("out"), "{name}");
        }
        let files = Files::new().reads("the scene", &at("scene")).fills("-o", &at("new"));
        assert_eq!(refusal(&files), None);
    }
}

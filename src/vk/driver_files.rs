//! The driver files that the user names: loaders pass over what they cannot load without a word.

use std::env;
use std::ffi::OsString;
use std::fmt::Display;
use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};

/// Variables that name driver manifests, as loaders read them: the first that is set counts.
const REPLACING: [&str; 2] = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"];
/// Names more, beside those of the system.
const ADDING: &str = "VK_ADD_DRIVER_FILES";

/// What a variable names that cannot be used.
pub(super) struct Unusable {
    pub(super) variable: &'static str,
    /// One sentence per file, for the user.
    pub(super) notes: Vec<String>,
    /// The variable's value without those files; empty where none is left. Some loaders give up on all drivers where one
    /// file is none.
    pub(super) rest: OsString,
}

/// The variables of an environment that name driver files which cannot be used.
pub(super) fn unusable(get: &dyn Fn(&'static str) -> Option<OsString>) -> Vec<Unusable> {
    let set = |name: &'static str| get(name).filter(|v| !v.is_empty()).map(|v| (name, v));
    let replacing = REPLACING.into_iter().find_map(set);
    let named = replacing.into_iter().chain(set(ADDING));
    let sift = |(variable, files): (&'static str, OsString)| {
        let (mut notes, mut rest) = (Vec::new(), Vec::new());
        for file in env::split_paths(&files).filter(|f| !f.as_os_str().is_empty()) {
            match check(&file) {
                Ok(()) => rest.push(file),
                Err(why) => {
                    notes.push(format!("{variable} names {}, which is no driver: {why}", file.display()))
                }
            }
        }
        // The paths come from such a list, so they make one again.
        let rest = env::join_paths(rest).unwrap_or(files);
        (!notes.is_empty()).then_some(Unusable { variable, notes, rest })
    };
    named.filter_map(sift).collect()
}

/// Checks a manifest and the library that it names; a folder is searched for manifests by newer loaders.
fn check(file: &Path) -> Result<(), String> {
    if file.is_dir() {
        let has_manifest = |entry: fs::DirEntry| entry.path().extension().is_some_and(|e| e == "json");
        let mut entries = fs::read_dir(file).map_err(text)?.flatten();
        return match entries.any(has_manifest) {
            true => Ok(()),
            false => Err("it is a folder without driver files (*.json)".into()),
        };
    }
    let data = fs::read(file).map_err(text)?;
    let manifest: serde_json::Value =
        serde_json::from_slice(&data).map_err(|error| format!("it is not JSON: {error}"))?;
    let library = manifest["ICD"]["library_path"]
        .as_str()
        .ok_or("it has no `library_path` in an object `ICD`, as a driver's manifest has")?;
    match place(file, library) {
        Some(path) => check_library(&path).map_err(|why| format!("its library {}: {why}", path.display())),
        // A bare name is searched for by the system.
        None => Ok(()),
    }
}

/// Where a manifest's library is, unless the system searches for it.
fn place(manifest: &Path, library: &str) -> Option<PathBuf> {
    let library = Path::new(library);
    if library.is_absolute() {
        return Some(library.into());
    }
    (library.components().count() > 1).then(|| manifest.parent().unwrap_or(Path::new("")).join(library))
}

/// Checks that a library can be for this program: on systems with ELF files by its header.
fn check_library(path: &Path) -> Result<(), String> {
    if path.is_dir() {
        return Err("it is a folder".into());
    }
    let mut file = File::open(path).map_err(text)?;
    if !cfg!(all(unix, not(target_vendor = "apple"))) {
        return Ok(());
    }
    let mut header = [0; 20];
    file.read_exact(&mut header).map_err(|_| "it is too short for a library")?;
    check_header(&header)
}

/// Checks the first bytes of an ELF file (System V ABI, "ELF header"): magic, class, byte order, machine.
fn check_header(header: &[u8; 20]) -> Result<(), String> {
    if header[..4] != *b"\x7fELF" {
        return Err("it is not a library".into());
    }
    let bits = match header[4] {
        1 => 32,
        _ => 64,
    };
    if bits != usize::BITS {
        return Err(format!("it is for {bits}-bit programs, this one has {} bits", usize::BITS));
    }
    let little = header[5] == 1;
    let machine = [header[18], header[19]];
    let machine = if little { u16::from_le_bytes(machine) } else { u16::from_be_bytes(machine) };
    match own_machine() {
        Some(own) if own != machine || little != cfg!(target_endian = "little") => Err(format!(
            "it is for another processor (ELF machine {machine}), this program is for {}",
            env::consts::ARCH
        )),
        _ => Ok(()),
    }
}

/// The `e_machine` of this program, where it is known.
fn own_machine() -> Option<u16> {
    Some(match env::consts::ARCH {
        "x86" => 3,
        "powerpc64" => 21,
        "s390x" => 22,
        "arm" => 40,
        "x86_64" => 62,
        "aarch64" => 183,
        "riscv64" => 243,
        "loongarch64" => 258,
        _ => return None,
    })
}

fn text(error: impl Display) -> String {
    error.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The header of a library for this program.
    fn header() -> [u8; 20] {
        let mut header = [0; 20];
        header[..4].copy_from_slice(b"\x7fELF");
        header[4] = if usize::BITS == 64 { 2 } else { 1 };
        header[5] = if cfg!(target_endian = "little") { 1 } else { 2 };
        header[18..].copy_from_slice(&own_machine().unwrap_or_default().to_ne_bytes());
        header
    }

    fn why(file: &Path) -> String {
        check(file).expect_err("no driver")
    }

    #[test]
    fn what_is_no_driver_says_why() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, data: &[u8]| {
            let path = folder.path().join(name);
            fs::write(&path, data).unwrap();
            path
        };
        let manifest = |name: &str, library: &str| {
            write(name, format!(r#"{{"ICD": {{"library_path": "{library}"}}}}"#).as_bytes())
        };
        assert!(why(&folder.path().join("none.json")).contains("No such file"));
        assert!(why(folder.path()).contains("folder without driver files"));
        assert!(why(&write("garbage.json", b"\x00garbage")).contains("not JSON"));
        assert!(why(&write("other.json", b"{}")).contains("library_path"));
        assert!(why(&manifest("missing.json", "./none.so")).contains("No such file"));
        write("text.so", b"#!/bin/sh\nexit 0 # longer than a header\n");
        assert!(why(&manifest("text.json", "./text.so")).contains("not a library"));
        write("short.so", b"\x7fELF");
        assert!(why(&manifest("short.json", "./short.so")).contains("too short"));

        let mut narrow = header();
        narrow[4] = 3 - narrow[4];
        write("narrow.so", &narrow);
        assert!(why(&manifest("narrow.json", "./narrow.so")).contains("-bit"));
        let mut other = header();
        other[18] ^= 1;
        write("other.so", &other);
        assert!(why(&manifest("foreign.json", "./other.so")).contains("another processor"));

        write("own.so", &header());
        assert_eq!(check(&manifest("own.json", "./own.so")), Ok(()));
        let absolute = folder.path().join("own.so");
        assert_eq!(check(&manifest("absolute.json", absolute.to_str().unwrap())), Ok(()));
        // The system searches for it.
        assert_eq!(check(&manifest("bare.json", "libvulkan_none.so")), Ok(()));
        // Now the folder has manifests.
        assert_eq!(check(folder.path()), Ok(()));
    }

    #[test]
    fn what_can_be_used_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let good = folder.path().join("good.json");
        fs::write(&good, r#"{"ICD": {"library_path": "libvulkan_none.so"}}"#).unwrap();
        let bad = folder.path().join("bad.json");
        let list = |files: &[&PathBuf]| env::join_paths(files).unwrap();
        let found = |files: &[&PathBuf], also: Option<&PathBuf>| {
            let (first, also) = (list(files), also.map(|file| list(&[file])));
            unusable(&|name| match name {
                "VK_ICD_FILENAMES" => Some(first.clone()),
                ADDING => also.clone(),
                _ => None,
            })
        };
        assert!(found(&[&good, &good], Some(&good)).is_empty());
        let one = found(&[&bad, &good], None);
        assert_eq!((one.len(), one[0].variable, &one[0].rest), (1, REPLACING[1], &list(&[&good])));
        assert!(one[0].notes[0].contains("bad.json") && one[0].notes.len() == 1);
        let both = found(&[&bad], Some(&bad));
        assert_eq!(
            both.iter().map(|u| (u.variable, u.rest.is_empty())).collect::<Vec<_>>(),
            [(REPLACING[1], true), (ADDING, true)]
        );
    }
}

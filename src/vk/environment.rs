//! Variables that drivers read from the environment, set before one is loaded.

use super::driver_files;
use crate::host::cache_folder;
use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// lavapipe's bits of a vector. Mesa's disk cache does not tell code for one width from code for another.
const WIDTH: &str = "LP_NATIVE_VECTOR_WIDTH";
/// Where Mesa keeps compiled code.
const FOLDER: &str = "MESA_SHADER_CACHE_DIR";
/// Whether it keeps none; the second is the name in older releases.
const DISABLE: [&str; 2] = ["MESA_SHADER_CACHE_DISABLE", "MESA_GLSL_CACHE_DISABLE"];
/// Free bytes of a file system that Mesa's cache is let to. Mesa maps an index of 1.3 MB, which it lengthens without reserving
/// room: on a file system in memory that is full, the first write to it ends the process (SIGBUS). The rest is
/// for what other processes write meanwhile.
const ROOM: u64 = 64 << 20;

/// What the user should know of the environment, one sentence each.
static NOTES: OnceLock<Vec<String>> = OnceLock::new();

/// Keeps Mesa from using code that was compiled for other vectors, and from a cache folder without room, and loaders from
/// driver files that are none. Drivers read the environment when they are loaded; call this first of all, while
/// the process has one thread: later calls change nothing, and neither does the first in a process that has more
/// threads already.
pub fn prepare() {
    NOTES.get_or_init(|| {
        let unusable = driver_files::unusable(&env::var_os);
        let mut notes: Vec<String> = unusable.iter().flat_map(|u| u.notes.clone()).collect();
        if is_alone() {
            // Without any driver the loader is to say so itself.
            let sifted = unusable.into_iter().filter(|u| !u.rest.is_empty());
            let sifted = sifted.map(|u| Change { variable: u.variable, value: u.rest, note: String::new() });
            notes.extend(change(&env::var_os).into_iter().chain(sifted).map(apply));
        }
        notes.retain(|note| !note.is_empty());
        notes
    });
}

/// What [`prepare`] found and changed, for the user.
pub(super) fn notes() -> &'static [String] {
    NOTES.get().map_or(&[], Vec::as_slice)
}

/// A variable to be set.
#[derive(Debug, PartialEq, Eq)]
struct Change {
    variable: &'static str,
    value: OsString,
    /// A sentence for the user; empty where nothing is lost.
    note: String,
}

/// True if this is the only thread, where the system tells.
fn is_alone() -> bool {
    std::fs::read_dir("/proc/self/task").is_ok_and(|tasks| tasks.count() == 1)
}

fn apply(change: Change) -> String {
    // SAFETY: no other thread reads or writes the environment, since there is none (`is_alone`).
    unsafe { env::set_var(change.variable, change.value) };
    change.note
}

/// What is to be changed in an environment.
fn change(get: &dyn Fn(&'static str) -> Option<OsString>) -> Option<Change> {
    let set = |name| get(name).filter(|value| !value.is_empty());
    if DISABLE.into_iter().any(|name| set(name).is_some_and(|v| is_true(&v))) {
        return None;
    }
    let own = match (set(FOLDER), set(WIDTH)) {
        (None, Some(width)) => match cache_folder::under(get).zip(bits(&width)) {
            Some((folder, bits)) => Some(folder.join(format!("mesa-{bits}-bit-vectors"))),
            // No place, or a width that Mesa will not understand either.
            None => return Some(disable(String::new())),
        },
        _ => None,
    };
    let folder = own.clone().or_else(|| mesa_folder(get))?;
    match free(&folder) {
        Some(bytes) if bytes < ROOM => Some(disable(format!(
            "the driver's cache of compiled kernels is off: the file system of {} has {} MiB free, it wants {}",
            folder.display(),
            bytes >> 20,
            ROOM >> 20
        ))),
        _ => own.map(|own| Change { variable: FOLDER, value: own.into(), note: String::new() }),
    }
}

fn disable(note: String) -> Change {
    Change { variable: DISABLE[0], value: "true".into(), note }
}

/// As Mesa reads a switch.
fn is_true(value: &OsString) -> bool {
    value.to_str().is_some_and(|v| ["1", "true", "y", "yes"].iter().any(|yes| v.eq_ignore_ascii_case(yes)))
}

/// A number of bits.
fn bits(width: &OsString) -> Option<u32> {
    width.to_str()?.trim().parse().ok()
}

/// The folder that Mesa keeps its cache under.
fn mesa_folder(get: &dyn Fn(&'static str) -> Option<OsString>) -> Option<PathBuf> {
    let set = |name| get(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    set(FOLDER)
        .or_else(|| set("MESA_GLSL_CACHE_DIR"))
        .or_else(|| set("XDG_CACHE_HOME"))
        .or_else(|| Some(set("HOME")?.join(".cache")))
}

/// Free bytes of the file system where `folder` is or would be made, where the system tells.
#[cfg(unix)]
fn free(folder: &Path) -> Option<u64> {
    use std::os::unix::ffi::OsStrExt;
    let there = folder.ancestors().find(|f| f.exists())?;
    let path = std::ffi::CString::new(there.as_os_str().as_bytes()).ok()?;
    let mut found = std::mem::MaybeUninit::<libc::statvfs>::uninit();
    // SAFETY: the path ends in NUL, and `found` has room for what is written to it.
    if unsafe { libc::statvfs(path.as_ptr(), found.as_mut_ptr()) } != 0 {
        return None;
    }
    // SAFETY: the call has succeeded, so it has written all of it.
    let found = unsafe { found.assume_init() };
    #[allow(clippy::unnecessary_cast)] // the types differ between systems
    Some(found.f_bavail as u64 * found.f_frsize as u64)
}

#[cfg(not(unix))]
fn free(_folder: &Path) -> Option<u64> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn changed(variables: &[(&'static str, &str)]) -> Option<Change> {
        change(&|name| variables.iter().find(|(n, _)| *n == name).map(|(_, value)| value.into()))
    }

    /// Each width has a folder of its own; what the user has chosen stays.
    #[test]
    fn a_vector_width_has_a_cache_of_its_own() {
        let folder = |variables: &[_]| changed(variables).map(|c| (c.variable, c.value));
        let home = ("HOME", "/");
        assert_eq!(folder(&[home]), None);
        let narrow = folder(&[home, (WIDTH, "128")]);
        assert_eq!(narrow.as_ref().map(|n| n.0), Some(FOLDER));
        assert_ne!(narrow, folder(&[home, (WIDTH, "512")]));
        assert_eq!(folder(&[home, (WIDTH, "128"), (FOLDER, "/")]), None);
        assert_eq!(folder(&[home, (WIDTH, "128"), (DISABLE[0], "true")]), None);
        let off = Some((DISABLE[0], "true".into()));
        assert_eq!(folder(&[home, (WIDTH, "wide")]), off);
        assert_eq!(folder(&[(WIDTH, "128")]), off);
        assert_eq!(folder(&[(WIDTH, "128"), (DISABLE[0], "false")]), off);
    }

    /// The system's own table of processes has no room at all.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_file_system_without_room_has_no_cache() {
        let full = changed(&[("XDG_CACHE_HOME", "/proc")]).expect("a change");
        assert_eq!((full.variable, full.value), (DISABLE[0], "true".into()));
        assert!(full.note.contains("/proc has 0 MiB free"), "{}", full.note);
        assert_eq!(
            changed(&[("XDG_CACHE_HOME", "/proc/none"), (WIDTH, "128")]).map(|c| c.variable),
            Some(DISABLE[0])
        );
    }
}

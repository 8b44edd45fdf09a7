//! The user's cache folder, and files in it: what a later run may use again and can do without.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Whole or not at all: another process may be reading. A cache that cannot be written is none.
pub fn write(file: &Path, data: &[u8]) {
    let Some(folder) = file.parent() else { return };
    let temporary = file.with_extension(format!("{}.tmp", std::process::id()));
    let written = std::fs::create_dir_all(folder)
        .and_then(|()| std::fs::write(&temporary, data))
        .and_then(|()| std::fs::rename(&temporary, file));
    if written.is_err() {
        drop(std::fs::remove_file(&temporary));
    }
}

/// The user's cache folder: `$XDG_CACHE_HOME/whitted`, or under `~/.cache`.
pub fn path() -> Option<PathBuf> {
    under(&|name| std::env::var_os(name))
}

/// The same in another environment.
pub fn under(get: &dyn Fn(&'static str) -> Option<OsString>) -> Option<PathBuf> {
    let folder = get("XDG_CACHE_HOME")
        .map(PathBuf::from)
        .filter(|p| p.is_absolute())
        .or_else(|| Some(PathBuf::from(get("HOME")?).join(".cache")))?;
    Some(folder.join("whitted"))
}

//! The user's cache folder, and files in it: what a later run may use again and can do without.

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
    let folder = std::env::var_os("XDG_CACHE_HOME")
        .map(PathBuf::from)
        .filter(|p| p.is_absolute())
        .or_else(|| Some(PathBuf::from(std::env::var_os("HOME")?).join(".cache")))?;
    Some(folder.join("whitted"))
}

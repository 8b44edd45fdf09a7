//! The user's cache folder, and files in it: what a later run may use again and can do without.
//!
//! A file is sealed: a line of text with the format's version, SHA-256 of key and content, then the content. The key
//! says what the content was made from. A file that is damaged, or was made from something else and came under this
//! name, is no file: its content is made again and the file replaced.

use sha2::{Digest, Sha256};
use std::ffi::OsString;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

const MAGIC: &[u8] = b"whitted cache 1\n";
const CHECKSUM: usize = 32;
/// Bytes of the largest file that is read: what is larger was not written here.
const LARGEST: u64 = 1 << 30;

/// The content of `file`, if it is there, whole, and was made from `key`.
pub fn read(file: &Path, key: &[u8]) -> Option<Vec<u8>> {
    // Opening a pipe would wait for its writer.
    let about = std::fs::metadata(file).ok()?;
    if !about.is_file() || about.len() > LARGEST {
        return None;
    }
    let mut bytes = Vec::new();
    File::open(file).ok()?.take(LARGEST).read_to_end(&mut bytes).ok()?;
    let (sum, content) = bytes.strip_prefix(MAGIC)?.split_at_checked(CHECKSUM)?;
    (seal(key, content) == sum).then(|| content.to_vec())
}

/// Writes `content`, made from `key`. Whole or not at all: another process may be reading. A cache that cannot be
/// written is none.
pub fn write(file: &Path, key: &[u8], content: &[u8]) {
    let Some(folder) = file.parent() else { return };
    let temporary = file.with_extension(format!("{}.tmp", std::process::id()));
    let bytes = [MAGIC, &seal(key, content), content].concat();
    let written = std::fs::create_dir_all(folder)
        .and_then(|()| std::fs::write(&temporary, bytes))
        .and_then(|()| std::fs::rename(&temporary, file));
    if written.is_err() {
        drop(std::fs::remove_file(&temporary));
    }
}

fn seal(key: &[u8], content: &[u8]) -> [u8; CHECKSUM] {
    let mut hash = Sha256::new();
    hash.update((key.len() as u64).to_le_bytes());
    hash.update(key);
    hash.update(content);
    hash.finalize().into()
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn only_what_was_written_for_the_key_comes_back() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("made/later");
        assert_eq!(read(&file, b"key"), None);
        write(&file, b"key", b"content");
        assert_eq!(read(&file, b"key").as_deref(), Some(&b"content"[..]));
        // A byte cannot change sides.
        for other in [&b""[..], b"ke", b"keyc", b"kez"] {
            assert_eq!(read(&file, other), None, "{other:?}");
        }
        assert_eq!(fs::read_dir(file.parent().unwrap()).unwrap().count(), 1, "nothing is left beside it");
        fs::remove_file(&file).unwrap();
        fs::create_dir(&file).unwrap();
        assert_eq!(read(&file, b"key"), None, "a folder is no file");
        write(&file, b"key", b"content");
        assert_eq!(read(&file, b"key"), None);
    }

    #[test]
    fn no_damaged_file_comes_back() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        write(&file, b"key", b"content");
        let whole = fs::read(&file).unwrap();
        let refused = |bytes: &[u8], what: &str| {
            fs::write(&file, bytes).unwrap();
            assert_eq!(read(&file, b"key"), None, "{what}");
        };
        for bit in 0..8 * whole.len() {
            let mut damaged = whole.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            refused(&damaged, &format!("bit {bit}"));
        }
        for length in 0..whole.len() {
            refused(&whole[..length], &format!("{length} bytes"));
        }
        refused(&[&whole[..], b"x"].concat(), "one byte more");
    }
}

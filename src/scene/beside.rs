//! Finds files that a file names, as it was written on another system.

use std::path::{Path, PathBuf};

/// The file `name` in `folder`, and whether that is the name as written. Where it is not, and `loosely`: with backslashes
/// between folders, in other letter case, or the last part of the path alone, in `folder` itself.
pub(super) fn find(folder: &Path, name: &[u8], loosely: bool) -> Option<(PathBuf, bool)> {
    if let Ok(text) = std::str::from_utf8(name) {
        let path = folder.join(text);
        if path.is_file() {
            return Some((path, true));
        }
    }
    let parts: Vec<&[u8]> = name.split(|b| *b == b'/' || (loosely && *b == b'\\')).collect();
    if !loosely {
        // Bytes that are no UTF-8 have no path that every system can write: the folder is searched for them.
        return follow(folder, &parts, false).map(|path| (path, true));
    }
    let last = parts.last().map_or(&[][..], |part| std::slice::from_ref(part));
    follow(folder, &parts, true).or_else(|| follow(folder, last, true)).map(|path| (path, false))
}

/// The file at the end of `parts`, each looked for in the folder before it.
fn follow(folder: &Path, parts: &[&[u8]], loosely: bool) -> Option<PathBuf> {
    let mut path = folder.to_owned();
    for part in parts {
        match *part {
            b"" | b"." => {}
            b".." => path.push(".."),
            name => path = entry(&path, name, loosely)?,
        }
    }
    path.is_file().then_some(path)
}

/// The entry `name` of a folder; of several that differ in letter case the first by bytes.
fn entry(folder: &Path, name: &[u8], loosely: bool) -> Option<PathBuf> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let mut found: Vec<_> = std::fs::read_dir(folder)
        .ok()?
        .flatten()
        .map(|entry| entry.file_name())
        .filter(|own| {
            let own = own.as_encoded_bytes();
            own == name || (loosely && own.eq_ignore_ascii_case(name))
        })
        .collect();
    found.sort_unstable_by_key(|own| (own.as_encoded_bytes() != name, own.clone()));
    Some(folder.join(found.first()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn written_on_another_system() {
        let root = tempfile::tempdir().unwrap();
        let file = root.path().join("Sub/Paint.MTL");
        std::fs::create_dir(root.path().join("Sub")).unwrap();
        std::fs::write(&file, "").unwrap();
        std::fs::write(root.path().join("own.mtl"), "").unwrap();
        let find = |name: &str, loosely| find(root.path(), name.as_bytes(), loosely);
        assert_eq!(find("Sub/Paint.MTL", false), Some((file.clone(), true)));
        for name in [".\\sub\\paint.mtl", "sub/../SUB/paint.mtl", "SUB\\Paint.MTL"] {
            let (path, written) = find(name, true).unwrap();
            assert!(!written && path.canonicalize().unwrap() == file.canonicalize().unwrap(), "{name}");
            assert_eq!(find(name, false), None, "{name}");
        }
        assert!(find("C:\\Users\\me\\OWN.mtl", true).is_some());
        assert_eq!(find("none.mtl", true), None);
        assert_eq!(find("", true), None);
    }
}

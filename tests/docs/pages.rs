//! Markdown pages of the repository, and the parts of them that the tests write.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// The absolute path of a file of the repository.
pub fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

/// The text of a file of the repository.
pub fn read(name: &str) -> String {
    fs::read_to_string(path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// All Markdown pages, by their path in the repository, in alphabetical order.
pub fn all() -> Vec<String> {
    fn walk(folder: &str, found: &mut Vec<String>) {
        for entry in fs::read_dir(path(folder)).expect("a folder") {
            let name = entry.expect("an entry").file_name().into_string().expect("a name in UTF-8");
            let below = if folder.is_empty() { name.clone() } else { format!("{folder}/{name}") };
            if path(&below).is_dir() && !["target", "out", ".git", ".cargo"].contains(&name.as_str()) {
                walk(&below, found);
            } else if name.ends_with(".md") {
                found.push(below);
            }
        }
    }
    let mut found = Vec::new();
    walk("", &mut found);
    found.sort();
    assert!(found.len() > 5, "only {found:?}");
    found
}

/// What `WHITTED_UPDATE_DOCS` asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Update {
    /// Unset: pages are compared only.
    Nothing,
    /// `1`: what is out of date is rewritten.
    Stale,
    /// `all`: transcripts are rewritten even if only times differ.
    All,
}

impl Update {
    /// From the environment.
    pub fn asked() -> Update {
        match std::env::var("WHITTED_UPDATE_DOCS").as_deref() {
            Err(_) | Ok("" | "0") => Update::Nothing,
            Ok("all") => Update::All,
            Ok(_) => Update::Stale,
        }
    }
}

/// Tests run in parallel, and two of them may write the same page.
static PAGES: Mutex<()> = Mutex::new(());

/// Replaces a page by `edit(its text)` where that is asked for, and fails if it would change otherwise.
pub fn check(page: &str, edit: impl FnOnce(&str) -> String) {
    let guard = PAGES.lock().unwrap_or_else(PoisonError::into_inner);
    let old = read(page);
    let new = edit(&old);
    if old == new {
        return;
    }
    if Update::asked() >= Update::Stale {
        fs::write(path(page), new).unwrap_or_else(|e| panic!("{page}: {e}"));
        return;
    }
    drop(guard);
    let line = old.lines().zip(new.lines()).position(|(a, b)| a != b);
    let line = line.unwrap_or(old.lines().count().min(new.lines().count()));
    panic!(
        "{page} is out of date from line {} on; `WHITTED_UPDATE_DOCS=1 cargo test --test docs` rewrites it\n  page     {}\n  program  {}",
        line + 1,
        old.lines().nth(line).unwrap_or("(the end)"),
        new.lines().nth(line).unwrap_or("(the end)"),
    );
}

/// `page` with `text` between the marks called `name`.
pub fn with_block(page: &str, name: &str, text: &str) -> String {
    let open = page.find(&format!("<!-- {name}:")).unwrap_or_else(|| panic!("no mark <!-- {name}: ... -->"));
    let begin = open + page[open..].find('\n').expect("a line end") + 1;
    let end = page.find(&format!("<!-- end of {name} -->")).expect("the closing mark");
    format!("{}{text}{}", &page[..begin], &page[end..])
}

#[test]
fn a_block_is_replaced_between_its_marks() {
    let page = "a\n<!-- x: by hand -->\nold\n<!-- end of x -->\nb\n";
    assert_eq!(with_block(page, "x", "new\n"), "a\n<!-- x: by hand -->\nnew\n<!-- end of x -->\nb\n");
}

//! Every transcript of the pages is what the program prints today.

use crate::pages::{self, Update};
use crate::transcript::{self, Transcript};
use std::path::Path;

/// Runs the transcripts of a page one after the other in one folder; later ones may use the files of earlier ones.
fn check(page: &str) {
    let folder = tempfile::tempdir().expect("a folder");
    std::os::unix::fs::symlink(pages::path("scenes"), folder.path().join("scenes")).expect("a link");
    let text = pages::read(page);
    let mut edits = Vec::new();
    for Transcript { mask, body } in transcript::find(&text) {
        let old = &text[body.clone()];
        let new = transcript::run(old, folder.path(), Path::new(env!("CARGO_BIN_EXE_whitted")));
        let difference = transcript::difference(old, &new, mask);
        match Update::asked() {
            Update::Nothing => {
                if let Some((page_line, run_line)) = difference {
                    panic!(
                        "a transcript of {page} is out of date; `WHITTED_UPDATE_DOCS=1 cargo test --test docs` \
                         rewrites it\n  page     {page_line}\n  program  {run_line}\nall that it prints:\n{new}"
                    );
                }
            }
            Update::Stale if difference.is_none() => {}
            Update::Stale | Update::All => edits.push((old.to_owned(), new)),
        }
    }
    if !edits.is_empty() {
        // Other tests may have rewritten other parts of the page in the meantime.
        pages::check(page, |text| {
            edits.iter().fold(text.to_owned(), |text, (old, new)| text.replacen(old, new, 1))
        });
    }
}

#[test]
fn transcripts_of_the_readme() {
    check("README.md");
}

#[test]
fn transcripts_of_the_guide() {
    check("docs/guide.md");
}

#[test]
fn transcripts_of_other_pages() {
    let others =
        pages::all().into_iter().filter(|page| !["README.md", "docs/guide.md"].contains(&page.as_str()));
    for page in others {
        check(&page);
    }
}

#[test]
fn every_console_block_is_a_transcript() {
    for page in pages::all() {
        let text = pages::read(&page);
        let blocks = text.lines().filter(|line| line.trim_start().starts_with("```console")).count();
        assert_eq!(blocks, transcript::find(&text).len(), "{page}: a block of ```console without its mark");
    }
}

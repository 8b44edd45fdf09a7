//! Links between pages resolve, and so do the pages and sections that comments cite.

use crate::pages;
use std::collections::HashSet;
use std::path::Path;

/// The lines of a page outside fenced blocks.
fn prose(page: &str) -> impl Iterator<Item = &str> {
    let mut fenced = false;
    page.lines().filter(move |line| {
        let fence = line.trim_start().starts_with("```");
        fenced ^= fence;
        !fenced && !fence
    })
}

/// The headings of a page, without their marks.
fn headings(page: &str) -> impl Iterator<Item = &str> {
    prose(page).filter(|line| line.starts_with('#')).map(|line| line.trim_start_matches('#').trim())
}

/// The anchors of a page's headings, by GitHub's rule: lower case, blanks to hyphens, punctuation dropped, and
/// `-1`, `-2` for repeated ones.
fn anchors(page: &str) -> HashSet<String> {
    let mut anchors = HashSet::new();
    for heading in headings(page) {
        let kept = heading.to_lowercase();
        let kept = kept.chars().filter(|c| c.is_alphanumeric() || [' ', '-', '_'].contains(c));
        let anchor: String = kept.map(|c| if c == ' ' { '-' } else { c }).collect();
        let again = (1..).map(|i| format!("{anchor}-{i}"));
        let free = std::iter::once(anchor.clone()).chain(again).find(|a| !anchors.contains(a));
        anchors.extend(free);
    }
    anchors
}

/// Targets of the links and images in a page.
fn links(page: &str) -> Vec<&str> {
    prose(page).flat_map(|line| line.split("](").skip(1)).filter_map(|rest| rest.split(')').next()).collect()
}

/// Relative links of `page` (its text is `text`) that lead nowhere; `read` gives the text of a file by its path.
fn broken<'a>(page: &str, text: &'a str, read: &dyn Fn(&Path) -> Option<String>) -> Vec<&'a str> {
    let folder = Path::new(page).parent().unwrap_or(Path::new(""));
    let leads_nowhere = |link: &&str| {
        let (file, anchor) =
            link.split_once('#').map_or((*link, None), |(file, anchor)| (file, Some(anchor)));
        if file.contains("://") {
            return false;
        }
        let target = if file.is_empty() { Some(text.to_owned()) } else { read(&folder.join(file)) };
        target.is_none_or(|target| anchor.is_some_and(|anchor| !anchors(&target).contains(anchor)))
    };
    links(text).into_iter().filter(leads_nowhere).collect()
}

#[test]
fn links_and_anchors_resolve() {
    // A picture or a folder has no anchors, so its text does not matter.
    let read = |file: &Path| {
        let path = pages::path("").join(file);
        std::fs::read_to_string(&path).ok().or_else(|| path.exists().then(String::new))
    };
    for page in pages::all() {
        let text = pages::read(&page);
        assert_eq!(broken(&page, &text, &read), [""; 0], "{page} has links that lead nowhere");
    }
}

#[test]
fn a_broken_link_is_noticed() {
    let other = |file: &Path| (file == Path::new("docs/b.md")).then(|| "# A b, c\n# A b, c\n".to_owned());
    let text =
        "# Here\n[](b.md) [](b.md#a-b-c-1) [](#here) [](https://x.org/#y)\n```\n[](not/a/link.md)\n```\n";
    assert_eq!(broken("docs/a.md", text, &other), [""; 0]);
    let text = "[](c.md) [](b.md#a-b) [](#there)";
    assert_eq!(broken("docs/a.md", text, &other), ["c.md", "b.md#a-b", "#there"]);
}

/// Sections of the page on numerics that `text` cites ("numerics.md, Boxes") but `page` does not have.
fn unknown_sections(text: &str, page: &str) -> Vec<String> {
    let sections: Vec<&str> = headings(page).collect();
    let cited = text.split("numerics.md, ").skip(1).filter(|t| !sections.iter().any(|s| t.starts_with(s)));
    cited.map(|t| t.chars().take(40).collect()).collect()
}

/// Pages of `docs` that `text` names by their path but that are not there.
fn unknown_pages(text: &str) -> Vec<String> {
    let is_part = |c: char| c.is_ascii_alphanumeric() || "-_./".contains(c);
    let named =
        text.match_indices("docs/").map(|(at, _)| text[at..].chars().take_while(|c| is_part(*c)).collect());
    let named = named.filter(|name: &String| name.ends_with(".md"));
    named.filter(|name| !pages::path(name).exists()).collect()
}

#[test]
fn comments_cite_pages_and_sections_that_exist() {
    fn sources(folder: &Path, found: &mut Vec<std::path::PathBuf>) {
        for entry in std::fs::read_dir(folder).expect("a folder") {
            let file = entry.expect("an entry").path();
            let kinds = ["rs", "glsl", "comp", "py", "sh"];
            if file.is_dir() {
                sources(&file, found);
            } else if file.extension().is_some_and(|e| kinds.iter().any(|k| e == *k)) {
                found.push(file);
            }
        }
    }
    let numerics = pages::read("docs/numerics.md");
    let mut files = Vec::new();
    for folder in ["src", "glsl", "tests", "benches"] {
        sources(&pages::path(folder), &mut files);
    }
    files.retain(|f| !f.ends_with("tests/docs/links.rs"));
    let mut citing = 0;
    for file in files {
        let text = std::fs::read_to_string(&file).expect("a text");
        citing += usize::from(text.contains("numerics.md, "));
        assert_eq!(unknown_sections(&text, &numerics), [""; 0], "{}", file.display());
        assert_eq!(unknown_pages(&text), [""; 0], "{}", file.display());
    }
    assert!(citing > 10, "only {citing} files cite the page");
}

/// Paths of code between backticks in `page` that are not there.
fn unknown_paths(page: &str) -> Vec<&str> {
    let spans = prose(page).flat_map(|line| line.split('`').skip(1).step_by(2));
    let folders = ["src/", "glsl/", "tests/", "benches/", "scenes/", ".ci/", ".github/"];
    let is_path =
        |span: &&str| folders.iter().any(|f| span.starts_with(f)) && !span.contains(['*', ' ', '{']);
    let is_missing = |span: &&str| !span.contains("NAME") && !pages::path(span).exists();
    spans.filter(is_path).filter(is_missing).collect()
}

#[test]
fn pages_name_paths_that_exist() {
    // Decisions and the changelog speak of the code as it was.
    let history = |page: &String| page.starts_with("docs/design/decisions/") || page == "CHANGELOG.md";
    for page in pages::all().into_iter().filter(|page| !history(page)) {
        assert_eq!(unknown_paths(&pages::read(&page)), [""; 0], "{page}");
    }
}

#[test]
fn a_wrong_citation_is_noticed() {
    assert_eq!(unknown_paths("`src/lib.rs` `src/*.rs` `src/no_such_file.rs`"), ["src/no_such_file.rs"]);
    assert_eq!(unknown_sections("(numerics.md, Boxes)", "## Boxes\n"), [""; 0]);
    assert_eq!(unknown_sections("(numerics.md, Boxes)", "## Boxing\n").len(), 1);
    assert_eq!(unknown_pages("docs/numerics.md and docs/no-such-page.md"), ["docs/no-such-page.md"]);
}

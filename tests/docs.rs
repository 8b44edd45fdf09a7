//! The documentation names what there is. Tables that the code knows are written into ARCHITECTURE.md by
//! `WHITTED_UPDATE_DOCS=1 cargo test --test docs`.

use clap::CommandFactory;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use whitted::cli::args::Cli;
use whitted::kernel::abi::{self, Buf};
use whitted::kernel::table::KERNELS;
use whitted::plan::element_bytes;
use whitted::plan::passes::{EPILOGUE, PER_DEPTH, PROLOGUE, Pass, SELF_TEST, Size, Way, When};
use whitted::settings::Precision;

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

fn read(name: &str) -> String {
    std::fs::read_to_string(path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// True if `text` has `word` as code: between backticks, or in a code block's line.
fn names(text: &str, word: &str) -> bool {
    let is_part = |c: char| c.is_alphanumeric() || c == '_' || c == '-';
    text.match_indices(word)
        .any(|(at, _)| !text[..at].ends_with(is_part) && !text[at + word.len()..].starts_with(is_part))
}

/// Tests run in parallel, and two of them may write the same file.
static ARCHITECTURE: Mutex<()> = Mutex::new(());

/// The part of ARCHITECTURE.md between the marks called `name` is `table`, or becomes it if asked to.
fn check_table(name: &str, table: &str) {
    let guard = ARCHITECTURE.lock().unwrap_or_else(PoisonError::into_inner);
    let text = read("ARCHITECTURE.md");
    let open = text.find(&format!("<!-- {name}:")).expect("the opening mark");
    let begin = open + text[open..].find('\n').expect("a line end") + 1;
    let end = text.find(&format!("<!-- end of {name} -->")).expect("the closing mark");
    if text[begin..end] == *table {
        return;
    }
    if std::env::var_os("WHITTED_UPDATE_DOCS").is_some() {
        let whole = format!("{}{table}{}", &text[..begin], &text[end..]);
        std::fs::write(path("ARCHITECTURE.md"), whole).expect("ARCHITECTURE.md can be written");
        return;
    }
    drop(guard);
    panic!(
        "the {name} of ARCHITECTURE.md are out of date; `WHITTED_UPDATE_DOCS=1 cargo test --test docs` writes\n\n{table}"
    );
}

fn buffer_name(buffer: Buf) -> &'static str {
    abi::BUFFERS[buffer as usize].0
}

/// First sentence of the comment that opens a kernel.
fn purpose(kernel: &str) -> String {
    let source = read(&format!("glsl/{kernel}.comp"));
    let comment: Vec<&str> = source.lines().map_while(|line| line.strip_prefix("// ")).collect();
    let text = comment.join(" ");
    text.split(". ").next().unwrap_or_default().trim_end_matches('.').to_owned()
}

#[test]
fn the_pass_table_is_the_codes() {
    let mut table =
        String::from("| kernel | what it does | reads | writes | on | when |\n|---|---|---|---|---|---|\n");
    let list = |buffers: &[Buf]| {
        buffers.iter().map(|b| format!("`{}`", buffer_name(*b))).collect::<Vec<_>>().join(" ")
    };
    let mut rows = |passes: &[Pass], place: &str| {
        for p in passes {
            let on = match p.size {
                Size::One => "one",
                Size::Samples => "samples",
                Size::Pixels => "pixels",
                Size::Rays => "rays",
            };
            let when = match p.when {
                When::Always => "",
                When::NotLast => ", but not the last",
                When::PerLights => ", for each group of lights",
                When::Branching => ", from 2 on, where rays branch",
            };
            let way = match p.way {
                Way::Both => "",
                Way::Split => "; split",
                Way::Fused => "; fused",
            };
            let (name, what) = (p.kernel.name(), purpose(p.kernel.name()));
            let (reads, writes) = (list(p.reads), list(p.writes));
            writeln!(table, "| `{name}` | {what} | {reads} | {writes} | {on} | {place}{when}{way} |")
                .unwrap();
        }
    };
    rows(PROLOGUE, "once per batch, first");
    rows(PER_DEPTH, "every depth");
    rows(EPILOGUE, "once per batch, last");
    rows(SELF_TEST, "once per device, before any frame");
    for kernel in &KERNELS {
        assert!(table.contains(&format!("| `{}` |", kernel.name)), "{} is in no pass", kernel.name);
    }
    check_table("passes", &table);
}

#[test]
fn the_buffer_table_is_the_codes() {
    let bytes = |element: &str| element_bytes(element, Precision::Robust);
    let double = |element: &str| element_bytes(element, Precision::Double);
    // The comment above a buffer's line in abi.rs says what it holds.
    let source = read("src/kernel/abi.rs");
    let comment = |name: &str| {
        let lines: Vec<&str> = source.lines().collect();
        let at =
            lines.iter().position(|l| l.trim_start().starts_with(&format!("{name} / "))).expect("its line");
        let above = lines[..at].iter().rev().map_while(|l| l.trim_start().strip_prefix("/// "));
        let mut words: Vec<&str> = above.collect();
        words.reverse();
        words.join(" ").trim_end_matches('.').replace('|', "\\|")
    };
    let mut table = String::from(
        "| binding | buffer | element | bytes | in f64 | what it holds |\n|---:|---|---|---:|---:|---|\n",
    );
    for (binding, (name, element, _)) in abi::BUFFERS.iter().enumerate() {
        writeln!(
            table,
            "| {binding} | `{name}` | `{element}` | {} | {} | {} |",
            bytes(element),
            double(element),
            comment(name)
        )
        .unwrap();
    }
    let place = |bytes: &dyn Fn(&str) -> u64| 2 * bytes("Ray") + bytes("Hit") + bytes("Surface");
    writeln!(
        table,
        "\nA place in a queue takes {} bytes ({} in f64), 8 more for each solid that a ray can be in, {} more where rays branch or\n\
         lights come in groups. Where kernels are fused it takes {} bytes and 8 more for each solid; where rays branch {}, and twice as much\n\
         for solids. A sample of a batch takes {} bytes, a pixel of a tile {}.",
        place(&bytes),
        place(&double),
        bytes("Contribution"),
        // Rays of this depth and of the next, at a ray's own places, and where they are.
        2 * bytes("Ray") + bytes("uint"),
        2 * 2 * bytes("Ray") + bytes("uint") + bytes("Contribution"),
        bytes("vec3"),
        bytes("Film")
    )
    .unwrap();
    check_table("buffers", &table);
}

/// All options, with the commands they belong to.
fn options() -> Vec<(String, String)> {
    fn walk(command: &clap::Command, above: &str, all: &mut Vec<(String, String)>) {
        for argument in command.get_arguments() {
            if let Some(long) = argument.get_long().filter(|l| !["help", "version"].contains(l)) {
                all.push((above.to_owned(), format!("--{long}")));
            }
        }
        for sub in command.get_subcommands() {
            walk(sub, &format!("{above} {}", sub.get_name()), all);
        }
    }
    let mut all = Vec::new();
    walk(&Cli::command(), "whitted", &mut all);
    all
}

fn commands() -> Vec<String> {
    fn walk(command: &clap::Command, above: &str, all: &mut Vec<String>) {
        for sub in command.get_subcommands() {
            let name = format!("{above} {}", sub.get_name());
            all.push(name.clone());
            walk(sub, &name, all);
        }
    }
    let mut all = Vec::new();
    walk(&Cli::command(), "whitted", &mut all);
    all
}

#[test]
fn the_readme_names_every_command_and_option() {
    let readme = read("README.md");
    for command in commands() {
        assert!(names(&readme, &command), "README.md does not name `{command}`");
    }
    for (command, option) in options() {
        assert!(names(&readme, &option), "README.md does not name {option} of `{command}`");
    }
}

#[test]
fn the_readme_names_no_command_or_option_that_is_not_there() {
    let readme = read("README.md");
    let commands = commands();
    let options = options();
    for line in readme.lines() {
        for (at, _) in line.match_indices("whitted ") {
            // Only where the program is called; prose and folder names are no calls.
            let called = line[..at].ends_with(['`']) || line[..at].ends_with("$ ");
            let Some(word) = line[at..].split([' ', '`']).nth(1).filter(|_| called) else { continue };
            let known = word.starts_with('-')
                || word == "help"
                || commands.iter().any(|c| c.split(' ').nth(1) == Some(word));
            assert!(known, "README.md calls `whitted {word}`, which is not there");
        }
        // Options of cargo, apt and rustup have no place in a line that calls none of them.
        if line.contains("cargo") {
            continue;
        }
        for (at, _) in line.match_indices("--") {
            let word: String =
                line[at..].chars().take_while(|c| c.is_ascii_lowercase() || *c == '-').collect();
            let starts = !line[..at].ends_with(|c: char| c.is_alphanumeric() || c == '-' || c == '|');
            if starts && word.len() > 3 && !word.ends_with('-') {
                let known = ["--help", "--version"].contains(&word.as_str())
                    || options.iter().any(|(_, o)| *o == word);
                assert!(known, "README.md names {word}, which is not there");
            }
        }
    }
}

#[test]
fn the_readme_names_what_the_script_does() {
    let (readme, script) = (read("README.md"), read("whitted.sh"));
    for word in ["render", "test"] {
        assert!(readme.contains(&format!("./whitted.sh {word}")), "README.md lacks ./whitted.sh {word}");
        assert!(script.contains(&format!("./whitted.sh {word}")), "whitted.sh lacks {word}");
    }
}

#[test]
fn the_scene_format_names_every_key() {
    let text = read("docs/scene-format.md");
    // The words that the readers accept, from the readers.
    let parser = read("src/scene/parse.rs") + &read("src/scene/material.rs");
    let mut keys: Vec<&str> = Vec::new();
    for part in parser.split("only(&[").skip(1).chain(parser.split("const TOP").skip(1)) {
        let list = part.split(';').next().unwrap_or_default();
        keys.extend(
            list.split('"')
                .skip(1)
                .step_by(2)
                .filter(|k| k.chars().all(|c| c.is_ascii_lowercase() || c == '_')),
        );
    }
    let top = parser.split("const TOP: [&str; 7] = [").nth(1).and_then(|t| t.split(']').next());
    keys.extend(top.expect("the list of tables").split('"').skip(1).step_by(2));
    assert!(keys.contains(&"look_from") && keys.contains(&"secondary") && keys.contains(&"mesh"), "{keys:?}");
    for key in keys {
        assert!(names(&text, key), "docs/scene-format.md does not name `{key}`");
    }
    let mtl = read("src/scene/mtl.rs");
    for key in mtl.split('"').skip(1).step_by(2).filter(|k| k.starts_with("whitted_") && k.len() > 8) {
        assert!(
            names(&text, key.split(' ').next().unwrap_or(key)),
            "docs/scene-format.md does not name `{key}`"
        );
    }
}

#[test]
fn the_scene_formats_example_is_a_scene() {
    let text = read("docs/scene-format.md");
    let mut examples = text.split("```toml\n").skip(1).filter_map(|t| t.split("```").next());
    let example = examples.next().expect("an example");
    let scene = whitted::scene::Scene::parse(example, "docs/example.toml").expect("a sound example");
    assert_eq!((scene.spheres.len(), scene.polygons.len(), scene.lights.len()), (1, 1, 1));
}

#[test]
fn files_that_are_linked_exist() {
    // Every page of `docs`, whatever is added there.
    let docs = std::fs::read_dir(path("docs")).expect("docs").map(|e| e.expect("an entry").file_name());
    let docs = docs.filter_map(|f| Some(format!("docs/{}", f.to_str()?))).filter(|f| f.ends_with(".md"));
    let others = ["README.md", "ARCHITECTURE.md", "CHANGELOG.md", "scenes/README.md"].map(String::from);
    for page in docs.chain(others) {
        let text = read(&page);
        for link in text.split("](").skip(1).filter_map(|t| t.split(')').next()) {
            let file = link.split('#').next().unwrap_or_default();
            if file.is_empty() || file.contains("://") {
                continue;
            }
            let target = path(&page).parent().expect("a folder").join(file);
            assert!(target.exists(), "{page} links to {link}, which is not there");
        }
    }
}

/// Sections of the page on numerics that `text` cites ("numerics.md, Boxes") or links to
/// ("numerics.md#boxes") but `page` does not have.
fn unknown_sections(text: &str, page: &str) -> Vec<String> {
    let sections: Vec<&str> = page.lines().filter_map(|l| l.strip_prefix("## ")).collect();
    let anchor = |s: &&str| s.to_lowercase().replace(' ', "-");
    let cited = text.split("numerics.md, ").skip(1).filter(|t| !sections.iter().any(|s| t.starts_with(s)));
    let linked = text.split("numerics.md#").skip(1).filter_map(|t| t.split(')').next());
    let linked = linked.filter(|t| !sections.iter().any(|s| anchor(s) == **t));
    cited.chain(linked).map(|t| t.chars().take(40).collect()).collect()
}

#[test]
fn cited_sections_of_the_numerics_exist() {
    fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).expect("a folder") {
            let file = entry.expect("an entry").path();
            if file.is_dir() {
                sources(&file, found);
            } else if file.extension().is_some_and(|e| ["rs", "glsl", "comp"].iter().any(|x| e == *x)) {
                found.push(file);
            }
        }
    }
    let page = read("docs/numerics.md");
    let mut files = vec![path("README.md"), path("ARCHITECTURE.md")];
    for folder in ["src", "glsl", "tests"] {
        sources(&path(folder), &mut files);
    }
    files.retain(|f| !f.ends_with("tests/docs.rs"));
    let mut citing = 0;
    for file in files {
        let text = std::fs::read_to_string(&file).expect("a text");
        citing += usize::from(text.contains("numerics.md, "));
        assert_eq!(unknown_sections(&text, &page), [""; 0], "{}", file.display());
    }
    assert!(citing > 10, "only {citing} files cite the page");
    assert_eq!(unknown_sections("(numerics.md, Boxes) numerics.md#local-frame)", &page), [""; 0]);
    assert_eq!(unknown_sections("(numerics.md, Spells) numerics.md#spells)", &page).len(), 2);
}

#[test]
fn a_missing_name_is_noticed() {
    assert!(names("use `--crop` here", "--crop"));
    assert!(!names("use `--cropped` here", "--crop"));
    assert!(!names("the `next_rays`", "rays"));
}

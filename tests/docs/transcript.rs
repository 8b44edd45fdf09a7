//! A transcript: a fenced block of `$ command` lines, each followed by what it prints. A comment above the
//! block marks it: `<!-- transcript -->`, or `<!-- transcript: numbers -->` where figures depend on the machine.

use std::path::Path;
use std::process::Command;

/// What may differ between a page and a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mask {
    /// Times, rates and the names of devices.
    Times,
    /// Every number and its unit as well.
    Numbers,
}

/// A transcript in a page.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Transcript {
    /// What may differ.
    pub mask: Mask,
    /// Bytes of the block's body in the page, without its fences.
    pub body: std::ops::Range<usize>,
}

/// All transcripts of a page, in order.
pub fn find(page: &str) -> Vec<Transcript> {
    let mut found = Vec::new();
    // A mark begins its line; elsewhere a page speaks of marks.
    for (at, mark) in page.match_indices("\n<!-- transcript") {
        let rest = &page[at + mark.len()..];
        let (kind, rest) = rest.split_once("-->").expect("the comment's end");
        let mask = match kind.trim() {
            "" => Mask::Times,
            ": numbers" => Mask::Numbers,
            other => panic!("no kind of transcript: {other}"),
        };
        let block =
            rest.trim_start().strip_prefix("```console\n").expect("a block of ```console below the mark");
        let begin = page.len() - block.len();
        let end = begin + block.find("```").expect("the block's end");
        found.push(Transcript { mask, body: begin..end });
    }
    found
}

/// The commands of a block: each `$ ` line, with the lines that a trailing backslash continues.
fn commands(body: &str) -> Vec<String> {
    let mut commands: Vec<String> = Vec::new();
    let mut continues = false;
    for line in body.lines() {
        if continues {
            let command = commands.last_mut().expect("a command to continue");
            command.push('\n');
            command.push_str(line);
        } else if let Some(command) = line.strip_prefix("$ ") {
            commands.push(command.to_owned());
        } else {
            continue;
        }
        continues = line.ends_with('\\');
    }
    commands
}

/// The body as a run in `folder` prints it now: both streams of each command, with the program at `program`.
pub fn run(body: &str, folder: &Path, program: &Path) -> String {
    let programs = program.parent().expect("a folder of the program");
    let path = std::env::var("PATH").unwrap_or_default();
    let mut text = String::new();
    for command in commands(body) {
        // One file for both streams keeps their order.
        let output = Command::new("sh")
            .args(["-c", &format!("exec 2>&1\n{command}")])
            .current_dir(folder)
            .env("PATH", format!("{}:{path}", programs.display()))
            .env("WHITTED_DEVICE", "cpu")
            .output()
            .expect("sh runs");
        text.push_str(&format!("$ {command}\n"));
        for line in String::from_utf8_lossy(&output.stdout).lines() {
            text.push_str(line.trim_end());
            text.push('\n');
        }
    }
    text
}

/// The first line that differs beyond what `mask` allows, in both texts.
pub fn difference(page: &str, run: &str, mask: Mask) -> Option<(String, String)> {
    let mut pairs: Vec<_> = page.lines().map(|line| (line, "(no such line)")).collect();
    for (i, line) in run.lines().enumerate() {
        match pairs.get_mut(i) {
            Some(pair) => pair.1 = line,
            None => pairs.push(("(no such line)", line)),
        }
    }
    let differing = pairs.into_iter().find(|(a, b)| masked(a, mask) != masked(b, mask))?;
    Some((differing.0.to_owned(), differing.1.to_owned()))
}

/// The words of a line that must be the same, with `#` for what may differ. Commands are compared as they are.
fn masked(line: &str, mask: Mask) -> Vec<String> {
    if line.starts_with("$ ") {
        return vec![line.to_owned()];
    }
    let words: Vec<&str> = line.split_whitespace().collect();
    if line.contains("llvmpipe") {
        return vec![words[0].to_owned(), "#".to_owned()];
    }
    let bare = |word: &str| word.trim_matches(['(', ')', ';', ',', ':', '+', '-']).to_owned();
    let mut kept: Vec<String> = Vec::new();
    let mut i = 0;
    while i < words.len() {
        let unit = words.get(i + 1).map(|w| bare(w)).unwrap_or_default();
        let masks_unit = match mask {
            Mask::Times => TIME_UNITS.contains(&unit.as_str()),
            Mask::Numbers => [TIME_UNITS, OTHER_UNITS].concat().contains(&unit.as_str()),
        };
        if is_number(&bare(words[i])) && (masks_unit || mask == Mask::Numbers) {
            kept.push("#".to_owned());
            i += 1 + usize::from(masks_unit);
        } else {
            kept.push(words[i].to_owned());
            i += 1;
        }
    }
    kept
}

const TIME_UNITS: &[&str] = &["ns", "us", "ms", "s", "min", "h"];
const OTHER_UNITS: &[&str] = &["%", "k", "M", "G", "B", "KiB", "MiB", "GiB"];

/// True for `12`, `1,024`, `3.5e-3`, and for long hexadecimal words such as a UUID.
fn is_number(word: &str) -> bool {
    word.replace(',', "").parse::<f64>().is_ok()
        || word.len() == 32 && word.bytes().all(|b| b.is_ascii_hexdigit())
}

#[test]
fn blocks_are_found_with_their_kind() {
    let page = "text\n<!-- transcript -->\n```console\n$ a\nb\n```\n<!-- transcript: numbers -->\n```console\n$ c\n```\n";
    let found = find(page);
    assert_eq!(
        found.iter().map(|t| (&page[t.body.clone()], t.mask)).collect::<Vec<_>>(),
        [("$ a\nb\n", Mask::Times), ("$ c\n", Mask::Numbers)]
    );
}

#[test]
fn commands_run_in_order_with_both_streams_and_continued_lines() {
    let folder = tempfile::tempdir().expect("a folder");
    let program = Path::new("/none/whitted");
    let body = "$ echo one >&2; echo two\nold\n$ echo \\\n  three > file\n$ cat file || echo none\n";
    let text = run(body, folder.path(), program);
    assert_eq!(
        text,
        "$ echo one >&2; echo two\none\ntwo\n$ echo \\\n  three > file\n$ cat file || echo none\nthree\n"
    );
}

#[test]
fn only_times_and_devices_may_differ() {
    let differ = |a: &str, b: &str| difference(a, b, Mask::Times).is_some();
    assert!(!differ("a.png: 283 k rays in 1.2 s\n", "a.png: 283 k rays in   98 ms\n"));
    assert!(!differ("device  llvmpipe (LLVM 15)\n", "device  llvmpipe (LLVM 17)\n"));
    assert!(!differ("render 309 ms (300 ms to 313 ms);\n", "render 1.1 s (2 s to 3 min);\n"));
    for (page, run) in [
        ("283 k rays in 1.2 s", "284 k rays in 1.2 s"),
        ("asked for an error of 0.02: kept", "asked for an error of 0.02: not kept"),
        ("12 s", "12 m"),
        ("$ sleep 1 s", "$ sleep 2 s"),
        ("a", "a\nb"),
        ("a\nb", "a"),
    ] {
        assert!(differ(page, run), "{page} | {run}");
    }
}

#[test]
fn only_numbers_may_differ() {
    let differ = |a: &str, b: &str| difference(a, b, Mask::Numbers).is_some();
    assert!(!differ("scan  2  3  257 us  0.1 %  1,024  -", "scan  2  4  1 ms  12 %  7 k  -"));
    assert!(differ("scan  2  3  257 us", "spawn  2  3  257 us"));
    assert!(differ("scan  2  3", "scan  2  -"));
    assert!(differ("scan  2  3", "scan  2"));
}

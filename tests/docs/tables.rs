//! Tables that the code knows, as the architecture page has them.

use crate::pages::{self, read};
use std::fmt::Write;
use whitted::kernel::abi::{self, Buf};
use whitted::plan::element_bytes;
use whitted::plan::passes::{self, EPILOGUE, PER_DEPTH, PROLOGUE, Pass, SELF_TEST, Size, Way, When};
use whitted::settings::Precision;

/// The block called `name` of the architecture page is `table`.
fn write(name: &str, table: &str) {
    pages::check("docs/design/architecture.md", |page| pages::with_block(page, name, table));
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
                Size::Walks => "some rays",
            };
            let when = match p.when {
                When::Always => "",
                When::NotLast => ", but not the last",
                When::PerLights => ", for each group of lights",
                When::Branching => ", from 2 on, where rays branch",
            };
            let way = match p.way {
                Way::Any => "",
                Way::Split => "; split",
                Way::Stages => "; split or in parts",
                Way::Parts => "; in parts",
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
    write("passes", &table);
}

#[test]
fn the_buffer_table_is_the_codes() {
    let bytes = |element: &str| element_bytes(element, Precision::Robust);
    let double = |element: &str| element_bytes(element, Precision::Double);
    // The comment above a buffer's line in buffers.rs says what it holds.
    let source = read("src/kernel/abi/buffers.rs");
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
    let bound = |way: Way| {
        let widths = passes::all().filter(|p| p.is_of(way)).map(|p| {
            let both: std::collections::BTreeSet<u32> =
                p.reads.iter().chain(p.writes).map(|b| *b as u32).collect();
            both.len()
        });
        widths.max().unwrap()
    };
    writeln!(
        table,
        "\nThe widest split kernel binds {} storage buffers, as many as a device must offer; the widest fused one binds {}, and is used\n\
         only where the device offers that many.",
        bound(Way::Split),
        bound(Way::Fused)
    )
    .unwrap();
    write("buffers", &table);
}

#[test]
fn the_index_of_decisions_lists_every_page() {
    let mut rows = String::from("| decision | date | status |\n|---|---|---|\n");
    let folder = "docs/design/decisions/";
    for page in
        pages::all().iter().filter_map(|page| page.strip_prefix(folder)).filter(|page| *page != "README.md")
    {
        let text = read(&format!("{folder}{page}"));
        let title = text.lines().next().and_then(|line| line.strip_prefix("# ")).expect("a title");
        let stated = text
            .lines()
            .find_map(|line| line.strip_prefix("Date: "))
            .expect("`Date: YYYY-MM-DD. Status: ...`");
        let (date, status) = stated.split_once(". Status: ").expect("a status");
        assert!(
            page.starts_with(title.split(':').next().expect("a number")),
            "{page}: the number of {title}"
        );
        writeln!(rows, "| [{title}]({page}) | {date} | {} |", status.trim_end_matches('.')).unwrap();
    }
    pages::check(&format!("{folder}README.md"), |page| pages::with_block(page, "decisions", &rows));
}

/// A table of a page: names of its columns, and its rows.
type Table<'a> = (Vec<&'a str>, Vec<Vec<&'a str>>);

/// The first table below the heading that contains `heading`.
fn table<'a>(page: &'a str, heading: &str) -> Table<'a> {
    let section = page.split("\n## ").find(|s| s.lines().next().is_some_and(|title| title.contains(heading)));
    let section = section.unwrap_or_else(|| panic!("no section {heading}"));
    let cells = |line: &'a str| line.trim_matches('|').split(" | ").map(str::trim).collect::<Vec<_>>();
    let lines =
        section.lines().skip_while(|line| !line.starts_with('|')).take_while(|line| line.starts_with('|'));
    let mut rows: Vec<Vec<&str>> = lines.map(cells).collect();
    assert!(rows.len() > 2, "no table in section {heading}");
    let head = rows.remove(0);
    (head, rows.split_off(1))
}

/// The place of the column called `name`.
fn column((head, _): &Table<'_>, name: &str) -> usize {
    head.iter().position(|title| *title == name).unwrap_or_else(|| panic!("no column {name} in {head:?}"))
}

/// The fractions `kept/tried` in a column, added up over the rows of single scenes.
fn added(table: &Table<'_>, name: &str) -> (u64, u64) {
    let at = column(table, name);
    let (mut kept, mut tried) = (0, 0);
    for row in table.1.iter().filter(|row| !row[0].starts_with("**")) {
        let fraction = row[at].split(' ').next().and_then(|f| f.split_once('/')).expect("kept/tried");
        kept += fraction.0.parse::<u64>().expect("a count");
        tried += fraction.1.parse::<u64>().expect("a count");
    }
    (kept, tried)
}

#[test]
fn the_readme_sums_up_the_measured_promises() {
    let (extremes, calibration) = (read("docs/extremes.md"), read("docs/calibration.md"));
    let cases = table(&extremes, "Cases");
    let verdict = column(&cases, "verdict");
    let passed = cases.1.iter().filter(|row| row[verdict] == "pass").count();
    let mut text = String::from("| promise | kept | measured by |\n|---|---:|---|\n");
    let mut row = |promise: &str, (kept, tried): (u64, u64), by: &str| {
        writeln!(text, "| {promise} | {kept} of {tried} | {by} |").unwrap();
    };
    row(
        "numerical extremes stay within derived bounds",
        (passed as u64, cases.1.len() as u64),
        "[`whitted stress`](docs/extremes.md)",
    );
    let by = "[`whitted calibrate`](docs/calibration.md)";
    row(
        "`--budget`, scenes drawn at random: the true error is within the stated one",
        added(&table(&calibration, "`--budget`"), "error within total bound"),
        by,
    );
    row(
        "`--error E`, the same scenes: the true error is at most E",
        added(&table(&calibration, "`--error`"), "of these, kept"),
        by,
    );
    pages::check("README.md", |page| pages::with_block(page, "right", &text));
}

#[test]
fn fractions_are_added_over_scenes_alone() {
    let page = "# P\n\n## A `x`\n\nText.\n\n| scene | kept |\n|---|---:|\n| a | 3/4 = 75 % |\n| b | 1/2 |\n| **all** | 9/9 |\n";
    assert_eq!(added(&table(page, "`x`"), "kept"), (4, 6));
}

//! `docs/cli.md`, written from the definitions of the command line.

use crate::pages;
use clap::{Arg, Command, CommandFactory};
use std::fmt::Write;
use whitted::cli::args::Cli;
use whitted::cli::failure::Code;

const HEAD: &str = "\
# Command line

<!-- Generated from the definitions of the command line; `WHITTED_UPDATE_DOCS=1 cargo test --test docs` rewrites it. -->

The [guide](guide.md) explains the commands by examples. `whitted help COMMAND` and `whitted COMMAND --help` print the same
texts as this page, `whitted man` writes them as manual pages, and `whitted completions` as completion scripts for shells.
";

/// A text in a cell of a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('\n', " ").replace('<', "&lt;")
}

/// An option or argument as a row: how it is written, and its meaning with default and values.
fn row(arg: &Arg) -> String {
    let value = || {
        let names =
            arg.get_value_names().unwrap_or_default().iter().map(|n| n.to_string()).collect::<Vec<_>>();
        let takes_value = arg.get_action().takes_values() && !names.is_empty();
        if takes_value { format!(" {}", names.join(" ")) } else { String::new() }
    };
    let written = match (arg.get_short(), arg.get_long()) {
        (Some(short), Some(long)) => format!("`-{short}`, `--{long}{}`", value()),
        (Some(short), None) => format!("`-{short}{}`", value()),
        (None, Some(long)) => format!("`--{long}{}`", value()),
        (None, None) => format!("`{}`", value().trim()),
    };
    let mut meaning = cell(&arg.get_help().map(ToString::to_string).unwrap_or_default());
    let list = |values: Vec<String>| values.join(", ");
    let values: Vec<_> = arg.get_possible_values().into_iter().filter(|v| !v.is_hide_set()).collect();
    if arg.get_action().takes_values() && !values.is_empty() {
        let value = |v: &clap::builder::PossibleValue| match v.get_help() {
            Some(help) => format!("`{}` ({})", v.get_name(), cell(&help.to_string())),
            None => format!("`{}`", v.get_name()),
        };
        write!(meaning, ". Values: {}", list(values.iter().map(value).collect())).expect("a String takes it");
    }
    let defaults =
        arg.get_default_values().iter().map(|v| v.to_string_lossy().into_owned()).collect::<Vec<_>>();
    if arg.get_action().takes_values() && !defaults.is_empty() && !arg.is_hide_default_value_set() {
        write!(meaning, " [default: {}]", list(defaults)).expect("a String takes it");
    }
    if let Some(variable) = arg.get_env() {
        write!(meaning, " [env: {}]", variable.to_string_lossy()).expect("a String takes it");
    }
    format!("| {written} | {meaning} |\n")
}

/// The tables of a command's arguments and options, one per heading, in the order of help.
fn tables(command: &Command) -> String {
    let shown = |arg: &&Arg| !arg.is_hide_set() && !["help", "version"].contains(&arg.get_id().as_str());
    let heading = |arg: &Arg| match arg.get_help_heading() {
        Some(heading) => heading.to_owned(),
        None if arg.is_positional() => "Arguments".to_owned(),
        None => "Options".to_owned(),
    };
    let mut groups: Vec<(String, String)> = Vec::new();
    let options = command.get_arguments().filter(|arg| !arg.is_positional());
    for arg in command.get_positionals().chain(options).filter(shown) {
        let heading = heading(arg);
        match groups.iter_mut().find(|(name, _)| *name == heading) {
            Some((_, rows)) => rows.push_str(&row(arg)),
            None => groups.push((heading, row(arg))),
        }
    }
    let table = |(name, rows): &(String, String)| format!("\n| {name} | |\n|---|---|\n{rows}");
    groups.iter().map(table).collect()
}

/// The text behind the options: prose as it is, a paragraph that begins with `Title:` as a block. Exit codes
/// are the same for all commands and stand at the end of the page.
fn notes(command: &Command) -> String {
    let text = command.get_after_help().map(ToString::to_string).unwrap_or_default();
    let mut notes = String::new();
    for paragraph in text.split("\n\n").filter(|p| !p.starts_with("Exit codes:")) {
        match paragraph.trim_end().split_once(":\n") {
            Some((title, lines)) => {
                let lines: Vec<&str> =
                    lines.lines().map(|line| line.strip_prefix("  ").unwrap_or(line)).collect();
                write!(notes, "\n{title}:\n\n```text\n{}\n```\n", lines.join("\n"))
            }
            None => write!(notes, "\n{}\n", paragraph.trim_end()),
        }
        .expect("a String takes it");
    }
    notes
}

/// The section of `command`, called `name`, and of the commands below it.
fn sections(command: &mut Command, name: &str) -> String {
    let about = command.get_about().map(ToString::to_string).unwrap_or_default();
    let usage = command.render_usage().to_string().replace("Usage: ", "");
    let mut text =
        format!("\n## {name}\n\n{about}.\n\n```text\n{usage}\n```\n{}{}", tables(command), notes(command));
    let below: Vec<String> = command.get_subcommands().map(|c| c.get_name().to_owned()).collect();
    for sub in below.iter().filter(|n| *n != "help") {
        let sub_command = command.find_subcommand_mut(sub).expect("it was listed");
        text.push_str(&sections(sub_command, &format!("{name} {sub}")));
    }
    text
}

fn page() -> String {
    let mut root = Cli::command();
    root.build();
    let mut text = format!(
        "{HEAD}{}\n## Exit codes\n\n| code | meaning |\n|---:|---|\n",
        sections(&mut root, "whitted")
    );
    for (code, meaning) in Code::ALL {
        writeln!(text, "| {} | {meaning} |", code as u8).expect("a String takes it");
    }
    text
}

#[test]
fn the_page_of_the_command_line_is_its_definitions() {
    pages::check("docs/cli.md", |_| page());
}

#[test]
fn the_page_has_every_option_that_help_shows() {
    fn walk(command: &Command, page: &str) {
        for long in command.get_arguments().filter(|a| !a.is_hide_set()).filter_map(|a| a.get_long()) {
            if long == "version" {
                continue;
            }
            assert!(
                page.contains(&format!("--{long}")),
                "--{long} of {} is not in the page",
                command.get_name()
            );
        }
        command.get_subcommands().for_each(|sub| walk(sub, page));
    }
    walk(&Cli::command(), &page());
}

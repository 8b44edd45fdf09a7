//! `whitted completions` and `whitted man`: files for shells and for man(1), from the definitions in `cli`.

use crate::atomic_file;
use crate::cli::args::{Cli, CompletionsArgs, ManArgs};
use crate::cli::console::print;
use crate::cli::failure::Failure;
use anyhow::Context;
use clap::CommandFactory;
use clap_mangen::Man;
use clap_mangen::roff::{Roff, roman};
use std::fs;
use std::io;

/// Prints the completion script of a shell.
pub fn completions(args: &CompletionsArgs) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "whitted", &mut script);
    print(&String::from_utf8_lossy(&script))
}

/// Prints the page of `whitted`, or writes one page per command to a folder.
pub fn man(args: &ManArgs) -> Result<(), Failure> {
    let mut root = Cli::command().disable_help_subcommand(true);
    root.build();
    let Some(folder) = &args.output else {
        let page = page(root).context("cannot write the manual page")?;
        return print(&String::from_utf8_lossy(&page));
    };
    fs::create_dir_all(folder).with_context(|| format!("cannot create {}", folder.display()))?;
    for command in all(&root) {
        let path =
            folder.join(format!("{}.1", command.get_display_name().unwrap_or_else(|| command.get_name())));
        let write = |out: &mut dyn io::Write| out.write_all(&page(command)?);
        atomic_file::write(&path, write).with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(())
}

/// `command` and all that are below it.
fn all(command: &clap::Command) -> Vec<clap::Command> {
    let below = command.get_subcommands().filter(|c| !c.is_hide_set()).flat_map(all);
    std::iter::once(command.clone()).chain(below).collect()
}

/// The roff text of one command's page.
fn page(command: clap::Command) -> io::Result<Vec<u8>> {
    let notes = command.get_after_help().map(ToString::to_string).unwrap_or_default();
    let (has_commands, has_version) = (command.has_subcommands(), command.get_version().is_some());
    let man = Man::new(command);
    let mut out = Vec::new();
    man.render_title(&mut out)?;
    man.render_name_section(&mut out)?;
    man.render_synopsis_section(&mut out)?;
    man.render_description_section(&mut out)?;
    man.render_options_section(&mut out)?;
    if has_commands {
        man.render_subcommands_section(&mut out)?;
    }
    render_notes(&notes).to_writer(&mut out)?;
    if has_version {
        man.render_version_section(&mut out)?;
    }
    Ok(out)
}

/// The text after the options. clap_mangen would fill its lines into one paragraph; here a paragraph that
/// begins with `Title:` becomes a section with its lines as they are.
fn render_notes(notes: &str) -> Roff {
    let mut roff = Roff::new();
    for paragraph in notes.split("\n\n") {
        match paragraph.split_once(":\n") {
            Some((title, lines)) => {
                roff.control("SH", [title.to_uppercase().as_str()]).control("nf", []);
                roff.text([roman(lines.trim_end())]);
                roff.control("fi", []);
            }
            None => {
                roff.control("PP", []).text([roman(paragraph.trim_end())]);
            }
        }
    }
    roff
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_command_has_a_page_with_its_options_and_examples() {
        let mut root = Cli::command().disable_help_subcommand(true);
        root.build();
        let commands = all(&root);
        assert!(commands.iter().any(|c| c.get_display_name() == Some("whitted-generate-sphereflake")));
        for command in commands {
            let options: Vec<_> = command
                .get_arguments()
                .filter(|a| !a.is_hide_set())
                .filter_map(|a| a.get_long())
                .map(String::from)
                .collect();
            let page = String::from_utf8(page(command).unwrap()).unwrap().replace('\\', "");
            for option in options.iter().filter(|o| *o != "help") {
                assert!(page.contains(&format!("--{option}")), "--{option} is not in\n{page}");
            }
            assert!(page.contains("\n.SH EXAMPLE"), "{page}");
        }
    }

    #[test]
    fn lines_of_examples_stay_lines() {
        let text =
            render_notes("Some prose\nin two lines.\n\nExamples:\n  whitted a\n  whitted b\n").render();
        assert!(text.contains(".PP\nSome prose\nin two lines."), "{text}");
        assert!(text.contains(".SH EXAMPLES\n.nf\n  whitted a\n  whitted b\n.fi"), "{text}");
    }
}

//! Pages name what there is, and nothing that is not there.

use crate::pages::{all, read};
use clap::CommandFactory;
use std::path::Path;
use whitted::cli::args::Cli;
use whitted::scene::Scene;

/// True if `text` has `word` with nothing of a name before or behind it.
fn names(text: &str, word: &str) -> bool {
    let is_part = |c: char| c.is_alphanumeric() || c == '_' || c == '-';
    text.match_indices(word)
        .any(|(at, _)| !text[..at].ends_with(is_part) && !text[at + word.len()..].starts_with(is_part))
}

/// The names of all commands ("generate sphereflake") and of all long options, `--` included.
fn commands_and_options() -> (Vec<String>, Vec<String>) {
    fn walk(command: &clap::Command, above: &str, commands: &mut Vec<String>, options: &mut Vec<String>) {
        options.extend(command.get_arguments().filter_map(|a| a.get_long()).map(|long| format!("--{long}")));
        for sub in command.get_subcommands() {
            let name = format!("{above}{}", sub.get_name());
            walk(sub, &format!("{name} "), commands, options);
            commands.push(name);
        }
    }
    let (mut commands, mut options) =
        (vec!["help".to_owned()], vec!["--help".to_owned(), "--version".to_owned()]);
    walk(&Cli::command(), "", &mut commands, &mut options);
    (commands, options)
}

/// Calls of `whitted` in `text` that name no command, and options in lines of such calls that do not exist.
fn unknown(text: &str, commands: &[String], options: &[String]) -> Vec<String> {
    let mut unknown = Vec::new();
    for line in text.lines() {
        for (at, _) in line.match_indices("whitted ") {
            // Only where the program is called; prose and folder names are no calls.
            if !line[..at].ends_with('`') && !line[..at].ends_with("$ ") {
                continue;
            }
            let mut words = line[at..].split([' ', '`', '\\', '|', '(', ')', ']', ',']).skip(1);
            let command = words.next().unwrap_or_default();
            let known = command.starts_with('-')
                || command.chars().all(|c| c.is_uppercase())
                || commands.iter().any(|c| c.split(' ').next() == Some(command));
            if !known {
                unknown.push(command.to_owned());
            }
        }
        let other_program =
            ["cargo", "apt", "git ", "against", "povray", "spirv-", "curl"].iter().any(|w| line.contains(w));
        for (at, _) in line.match_indices("--").filter(|_| !other_program) {
            let word: String =
                line[at..].chars().take_while(|c| c.is_ascii_lowercase() || *c == '-').collect();
            let starts = !line[..at].ends_with(|c: char| c.is_alphanumeric() || "-|:".contains(c));
            if starts && word.len() > 3 && !word.ends_with('-') && !options.contains(&word) {
                unknown.push(word);
            }
        }
    }
    unknown
}

#[test]
fn pages_name_no_command_or_option_that_is_not_there() {
    let (commands, options) = commands_and_options();
    // Decisions and the changelog also speak of what there was.
    let history = |page: &String| page.starts_with("docs/design/decisions/") || page == "CHANGELOG.md";
    for page in all().into_iter().filter(|page| !history(page)) {
        assert_eq!(unknown(&read(&page), &commands, &options), [""; 0], "{page}");
    }
}

#[test]
fn a_wrong_name_is_noticed() {
    let (commands, options) = (["render".to_owned()], ["--size".to_owned()]);
    let unknown = |text: &str| unknown(text, &commands, &options);
    assert_eq!(unknown("`whitted render` and --size and a -- dash"), [""; 0]);
    assert_eq!(unknown("`whitted rendre`\n$ whitted render --sise 3"), ["rendre", "--sise"]);
    assert!(names("use `--crop` here", "--crop"));
    assert!(!names("use `--cropped` here", "--crop"));
    assert!(!names("the `next_rays`", "rays"));
}

#[test]
fn the_guide_covers_every_command() {
    let guide = read("docs/guide.md");
    for command in commands_and_options().0.iter().filter(|c| *c != "help") {
        assert!(
            names(&guide, &format!("whitted {command}")),
            "docs/guide.md does not name `whitted {command}`"
        );
    }
}

#[test]
fn the_readme_names_what_the_script_does() {
    let (readme, script) = (read("README.md"), read("whitted.sh"));
    for word in ["render", "test"] {
        assert!(
            readme.contains(&format!("./whitted.sh {word}")),
            "README.md does not name ./whitted.sh {word}"
        );
        assert!(script.contains(&format!("./whitted.sh {word}")), "whitted.sh has no {word}");
    }
    assert!(readme.lines().count() <= 200, "README.md is a front page, not a manual");
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
    let scene = Scene::parse(example, Path::new("docs/example.toml")).expect("a sound example");
    assert_eq!((scene.spheres.len(), scene.polygons.len(), scene.lights.len()), (1, 1, 1));
}

#[test]
fn the_page_of_the_report_names_every_key() {
    fn keys(value: &serde_json::Value, found: &mut Vec<String>) {
        match value {
            serde_json::Value::Object(fields) => {
                for (key, value) in fields {
                    found.push(key.clone());
                    keys(value, found);
                }
            }
            serde_json::Value::Array(items) => items.iter().for_each(|item| keys(item, found)),
            _ => {}
        }
    }
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).display().to_string();
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell.toml");
    assert_cmd::Command::new(env!("CARGO_BIN_EXE_whitted"))
        .args(["render", scene, "-o", &at("a.png"), "--report", &at("a.json"), "--size", "12x10", "--budget"])
        .args(["--samples", "4", "--device", "cpu"])
        .assert()
        .success();
    let report = std::fs::read_to_string(at("a.json")).expect("the report");
    let mut found = Vec::new();
    keys(&serde_json::from_str(&report).expect("JSON"), &mut found);
    assert!(
        found.iter().any(|key| key == "by_depth") && found.iter().any(|key| key == "rounding_pixels"),
        "{found:?}"
    );
    let page = read("docs/report.md");
    for key in found {
        assert!(names(&page, &key), "docs/report.md does not name `{key}`");
    }
}

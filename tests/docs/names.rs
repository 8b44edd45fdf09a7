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
            ["cargo", "apt", "git ", "against", "povray", "spirv-", "curl", "openjd run", "parallel"]
                .iter()
                .any(|w| line.contains(w));
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

/// The keys of a table, as the remedy of an unknown one lists them.
fn keys_of(table: &str) -> Vec<String> {
    let camera = "[camera]\nlook_from = [0, 0, 5]\nlook_at = [0, 0, 0]\n";
    let text = match table {
        "" => format!("zzz = 1\n{camera}"),
        "[camera]" => format!("{camera}zzz = 1\n"),
        other => format!("{camera}{other}\nzzz = 1\n"),
    };
    let error = Scene::parse(&text, Path::new("a.toml")).expect_err("an unknown key");
    assert!(error.message.contains("zzz"), "{error}");
    error.remedy.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

#[test]
fn the_scene_format_names_every_key() {
    let text = read("docs/scene-format.md");
    let tables =
        ["", "[camera]", "[render]", "[[light]]", "[material.a]", "[[sphere]]", "[[polygon]]", "[[mesh]]"];
    for table in tables {
        let keys = keys_of(table);
        assert!(keys.len() > 1, "{table}: {keys:?}");
        for key in keys {
            assert!(names(&text, &key), "docs/scene-format.md does not name `{key}`");
        }
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

//! `${name}` in scene text.

use super::error::{SceneError, Source, did_you_mean, list};
use std::path::Path;

/// A scene's text with values in place of names.
pub(super) struct Filled {
    pub text: String,
    /// In the order of the text.
    places: Vec<Place>,
}

/// One value.
struct Place {
    /// From 1.
    line: usize,
    /// In the filled text, from 1.
    column: usize,
    /// Characters of the value.
    value: usize,
    /// Characters of the name with `${}`.
    name: usize,
}

/// Puts `variables` into `text`, the text of `file`. `$${` stands for `${`.
///
/// # Errors
/// If a name has no value, or a value no name in the text.
pub(super) fn fill(text: &str, file: &Path, variables: &[(String, String)]) -> Result<Filled, SceneError> {
    let source = Source { file, text: text.as_bytes() };
    let mut filled = Filled { text: String::with_capacity(text.len()), places: Vec::new() };
    let mut used = vec![false; variables.len()];
    let (mut at, mut line, mut column) = (0, 1, 1);
    while at < text.len() {
        let rest = &text[at..];
        let (taken, put, is_value) = if rest.starts_with("$${") {
            (3, "${", true)
        } else if let Some(inside) = rest.strip_prefix("${") {
            let name = name(inside).ok_or_else(|| {
                source.error(
                    at,
                    "scene",
                    "`${` opens no name",
                    "write `${name}`, or `$${` for the characters themselves",
                )
            })?;
            let found = variables.iter().rposition(|(known, _)| known == name);
            let index = found.ok_or_else(|| unknown(source, at, name, variables))?;
            used[index] = true;
            (name.len() + 3, variables[index].1.as_str(), true)
        } else {
            let next = if rest.starts_with('$') { 1 } else { rest.find('$').unwrap_or(rest.len()) };
            (next, &rest[..next], false)
        };
        if is_value {
            let (value, name) = (put.chars().count(), rest[..taken].chars().count());
            filled.places.push(Place { line, column, value, name });
        }
        for c in put.chars() {
            (line, column) = if c == '\n' { (line + 1, 1) } else { (line, column + 1) };
        }
        filled.text.push_str(put);
        at += taken;
    }
    let is_used = |name| variables.iter().zip(&used).any(|((known, _), used)| *used && known == name);
    match variables.iter().find(|(name, _)| !is_used(name)) {
        Some((name, _)) => Err(unnamed(source, name)),
        None => Ok(filled),
    }
}

/// The name before the next `}`: letters, digits and `_`, not a digit first.
fn name(inside: &str) -> Option<&str> {
    let name = inside.split_once('}')?.0;
    is_name(name).then_some(name)
}

/// True for letters, digits and `_` that begin with no digit.
pub(crate) fn is_name(name: &str) -> bool {
    let word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    name.chars().all(word) && name.chars().next().is_some_and(|c| !c.is_ascii_digit())
}

fn unknown(source: Source, at: usize, name: &str, variables: &[(String, String)]) -> SceneError {
    let names = || variables.iter().map(|(known, _)| known.as_str());
    let known = match list(names()) {
        none if none.is_empty() => String::new(),
        some => format!(", or use one of {some}"),
    };
    let give = if name == "frame" { "--frame 1".into() } else { format!("-D {name}=VALUE") };
    let message = format!("`${{{name}}}` has no value{}", did_you_mean(name, names()));
    source.error(at, "scene", message, format!("give `{give}`{known}"))
}

/// `name` was given, and nothing in the text asks for it.
pub(super) fn unnamed(source: Source, name: &str) -> SceneError {
    let remedy = if name == "frame" {
        "write it where frames differ, or leave out `--frame`"
    } else {
        "leave out `-D` for it, or write it in the scene"
    };
    SceneError {
        line: 0,
        column: 0,
        ..source.error(0, "scene", format!("`${{{name}}}` does not occur"), remedy)
    }
}

impl Filled {
    /// `error`, found in the filled text of `file`, at its place in the text as written.
    pub fn replace(&self, mut error: SceneError, file: &Path) -> SceneError {
        if error.file != file {
            return error;
        }
        let column = error.column;
        for place in self.places.iter().filter(|p| p.line == error.line && p.column < column) {
            // Within a value, the name is meant.
            let passed = (column - place.column).min(place.value);
            let whole = passed == place.value;
            error.column = error.column + if whole { place.name } else { 0 } - passed;
        }
        error
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filled(text: &str, variables: &[(&str, &str)]) -> Result<Filled, String> {
        let variables: Vec<_> = variables.iter().map(|(n, v)| (n.to_string(), v.to_string())).collect();
        fill(text, Path::new("s.toml"), &variables).map_err(|e| e.to_string())
    }

    #[test]
    fn letters_of_several_bytes_may_come_first() {
        for text in ["é", "${x}é$é"] {
            let used: &[(&str, &str)] = if text.contains('{') { &[("x", "ß")] } else { &[] };
            assert_eq!(filled(text, used).unwrap().text, text.replace("${x}", "ß"));
        }
    }

    #[test]
    fn names_become_values() {
        let text = "a = ${x}$\nb = \"$${x} ${file_2}.obj\" # 5$, $$ ${x}";
        let filled = filled(text, &[("x", "7"), ("file_2", "é")]).unwrap();
        assert_eq!(filled.text, "a = 7$\nb = \"${x} é.obj\" # 5$, $$ 7");
    }

    #[test]
    fn the_last_value_of_a_name_holds() {
        assert_eq!(filled("${x}", &[("x", "1"), ("x", "2")]).unwrap().text, "2");
    }

    #[test]
    fn unknown_and_unused_names_are_errors() {
        let of = |text, variables: &[(&str, &str)]| filled(text, variables).err().unwrap();
        let error = of("a\n  ${raduis}", &[("radius", "1")]);
        assert!(
            error.starts_with("s.toml:2:3: scene: `${raduis}` has no value; did you mean `radius`?"),
            "{error}"
        );
        assert!(of("${frame}", &[]).contains("--frame 1"));
        assert!(of("a", &[("b", "1")]).starts_with("s.toml: scene: `${b}` does not occur"));
        for open in ["${", "${}", "${1a}", "${a b}", "${a"] {
            assert!(of(open, &[("a", "1")]).contains("opens no name"), "{open}");
        }
    }

    #[test]
    fn errors_keep_the_columns_of_the_text_as_written() {
        let text = "ab ${long_name} cd ${y} ef\nzz ${y}";
        let filled = filled(text, &[("long_name", "1"), ("y", "2345678901234")]).unwrap();
        let file = Path::new("s.toml");
        let column = |part: &str| {
            let source = Source { file, text: filled.text.as_bytes() };
            let error = source.error(filled.text.find(part).unwrap(), "scene", "bad", "good");
            let error = filled.replace(error, file);
            (error.line, error.column)
        };
        assert_eq!((column("ab"), column("1 cd"), column("cd")), ((1, 1), (1, 4), (1, 17)));
        assert_eq!(
            (column("2345"), column("01234"), column("ef"), column("zz")),
            ((1, 20), (1, 20), (1, 25), (2, 1))
        );
    }
}

//! `whitted import`.

use crate::atomic_file;
use crate::cli::args::{ImportArgs, ReadArgs};
use crate::cli::console::{self, Console};
use crate::cli::failure::Failure;
use crate::cli::files::Files;
use crate::cli::read;
use crate::scene::{import, is_model};
use anyhow::{Context, anyhow};
use std::path::{Path, PathBuf};

/// Writes the scene around a model.
pub fn run(args: &ImportArgs, console: &mut Console) -> Result<(), Failure> {
    let ImportArgs { model, output, .. } = args;
    if !is_model(model) {
        return Err(Failure::Usage(format!(
            "{} is no model: import writes a scene around one",
            model.display()
        )));
    }
    let to_file = output.as_os_str() != "-";
    if to_file && is_model(output) {
        return Err(Failure::Usage("the output is a scene: write -o NAME.toml".into()));
    }
    let files = || Files::new().reads("the model", model).writes("-o", Some(output));
    files().check()?;
    let reading = ReadArgs { strict: args.strict, up: args.up, ..ReadArgs::default() };
    let scene = read::scene(model, &reading, args.size, console)?;
    files().reads_scene(&scene).check()?;
    // Files that a scene names are looked for from its folder.
    let folder = if to_file { output.parent().unwrap_or(Path::new("")) } else { Path::new("") };
    let file = relative(model, folder).with_context(|| format!("cannot find {}", model.display()))?;
    let Some(file) = file.to_str() else {
        return Err(
            anyhow!("the name of {} is not UTF-8, which a scene's text must be", model.display()).into()
        );
    };
    let text = import(&scene, file);
    if !to_file {
        return console::print(&text);
    }
    atomic_file::write(output, |out| out.write_all(text.as_bytes()))
        .with_context(|| format!("cannot write {}", output.display()))?;
    console.say(&format!("{}: `whitted render {0} -o a.png` draws it", output.display()));
    Ok(())
}

/// The path to `file` from `folder`.
fn relative(file: &Path, folder: &Path) -> std::io::Result<PathBuf> {
    let beside = file.parent().unwrap_or(Path::new(""));
    let whole = |path: &Path| if path.as_os_str().is_empty() { Path::new(".") } else { path }.canonicalize();
    let (from, to) = (whole(folder)?, whole(beside)?);
    let name = file.file_name().unwrap_or(file.as_os_str());
    let shared = from.components().zip(to.components()).take_while(|(a, b)| a == b).count();
    if shared == 0 {
        return Ok(to.join(name));
    }
    let up = from.components().skip(shared).map(|_| std::path::Component::ParentDir);
    Ok(up.chain(to.components().skip(shared)).collect::<PathBuf>().join(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_start_at_the_scenes_folder() {
        let root = tempfile::tempdir().unwrap();
        for folder in ["a/b", "a/c"] {
            std::fs::create_dir_all(root.path().join(folder)).unwrap();
        }
        let model = root.path().join("a/b/m.obj");
        let from = |folder: &str| relative(&model, &root.path().join(folder)).unwrap();
        assert_eq!(from("a/b"), Path::new("m.obj"));
        assert_eq!(from("a"), Path::new("b/m.obj"));
        assert_eq!(from("a/c"), Path::new("../b/m.obj"));
        assert!(relative(&model, &root.path().join("none")).is_err());
    }
}

//! `whitted info`.

mod picture;
mod shapes;

use crate::cli::args::InfoArgs;
use crate::cli::console::{self, Console};
use crate::cli::delivery::write_json;
use crate::cli::failure::Failure;
use crate::cli::files::Files;
use crate::cli::read;
use crate::image::is_picture;
use crate::scene::is_model;
use crate::units::plural;
use anyhow::Context;
use picture::PictureFile;
use serde::Serialize;
use shapes::SceneFile;

/// What `--json` writes.
#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
enum About {
    Model(SceneFile),
    Scene(SceneFile),
    Picture(PictureFile),
}

/// Tells what is in a file.
pub fn run(args: &InfoArgs, console: &mut Console) -> Result<(), Failure> {
    let file = &args.file;
    let json_file = args.json.as_ref().filter(|path| path.as_os_str() != "-");
    Files::new().reads("FILE", file).writes("--json", args.json.as_deref()).check()?;
    let about = if is_model(file) || file.as_os_str() == "-" || !is_picture(file) {
        // The notes are part of the table.
        let scene = read::silently(file, &args.read)?;
        let about = SceneFile::of(file, &scene);
        if is_model(file) { About::Model(about) } else { About::Scene(about) }
    } else {
        About::Picture(PictureFile::of(file)?)
    };
    let text = about.text();
    match (&args.json, json_file) {
        (Some(_), None) => {
            let json = serde_json::to_string_pretty(&about).context("cannot express the figures as JSON")?;
            console.say(&text);
            console::print(&(json + "\n"))
        }
        (_, path) => {
            path.map_or(Ok(()), |path| write_json(path, &about))?;
            if console.is_quiet() { Ok(()) } else { console::print(&text) }
        }
    }
}

impl About {
    fn text(&self) -> String {
        match self {
            About::Model(about) => format!("{}: model\n{}", about.file, about.text()),
            About::Scene(about) => format!("{}: scene\n{}", about.file, about.text()),
            About::Picture(about) => format!("{}: picture\n{}", about.file, about.text()),
        }
    }
}

/// `name` and text in two columns.
fn line(name: &str, text: &str) -> String {
    format!("{name:<9} {text}\n")
}

/// "3 spheres", or nothing of a kind that there is not.
fn some(count: usize, noun: &str) -> Option<String> {
    (count > 0).then(|| plural(count as u64, noun))
}

#[cfg(test)]
mod tests;

//! What is in a picture, and the command that makes it again.

use super::line;
use crate::cli::failure::Failure;
use crate::image::{Picture, linear_sha256, read_metadata};
use anyhow::Context;
use serde::Serialize;
use std::path::Path;

/// A picture.
#[derive(Serialize)]
pub(super) struct PictureFile {
    pub file: String,
    width: u32,
    height: u32,
    encoding: &'static str,
    /// SHA-256 over the linear f32 RGB rows as the file has them.
    linear_sha256: String,
    /// Keywords and texts of the file.
    metadata: Vec<(String, String)>,
    /// The command that makes it again; null if the metadata does not say.
    command: Option<String>,
}

impl PictureFile {
    pub(super) fn of(path: &Path) -> Result<PictureFile, Failure> {
        let picture = Picture::read(path).context("cannot tell what is in it")?;
        let file = path.display().to_string();
        let metadata = read_metadata(path);
        let command = command(&metadata, &file);
        Ok(PictureFile {
            width: picture.width,
            height: picture.height,
            encoding: picture.encoding,
            linear_sha256: linear_sha256(&picture.linear),
            metadata,
            command,
            file,
        })
    }

    pub(super) fn text(&self) -> String {
        let mut text = line("size", &format!("{}x{} pixels", self.width, self.height));
        text += &line("encoding", self.encoding);
        // What a file says is shown without what would move the terminal's cursor.
        let shown =
            |text: &str| -> String { text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect() };
        for (keyword, value) in &self.metadata {
            text += &line(&shown(keyword).to_lowercase(), &shown(value));
        }
        if let Some(command) = &self.command {
            text += &line("again", &shown(command));
        }
        text
    }
}

/// The options behind the metadata of a render; none where it does not say enough.
fn command(metadata: &[(String, String)], file: &str) -> Option<String> {
    let get = |keyword: &str| metadata.iter().find(|(k, _)| k == keyword).map(|(_, text)| text.as_str());
    let (scene, settings, seed) = (get("Scene")?, get("Settings")?, get("Seed")?);
    if !get("Software")?.starts_with(concat!(env!("CARGO_PKG_NAME"), " ")) || settings.contains("traced") {
        return None;
    }
    let asked = match get("Asked") {
        None => None,
        Some(asked) => Some(asked.strip_prefix("an error of ")?.split(':').next()?.to_owned()),
    };
    let mut words = vec!["whitted".into(), "render".into(), quoted(scene), "-o".into(), quoted(file)];
    for part in settings.split(", ") {
        let option = match part.split_once(' ')? {
            (size, "pixels") => ["--size", size],
            // Chosen for the error that was asked for.
            (_, rest) if rest.contains("per pixel") && asked.is_some() => continue,
            ("depth", _) if asked.is_some() => continue,
            (samples, "samples per pixel") => ["--samples", samples],
            ("depth", depth) => ["--depth", depth],
            ("sampler", sampler) if sampler != "owen" => ["--sampler", sampler],
            ("precision", precision) if precision != "robust" && asked.is_none() => {
                ["--precision", precision]
            }
            ("origin", origin) if origin != "bound" => ["--origin", origin],
            ("crop", crop) => ["--crop", crop],
            ("cutoff", cutoff) => ["--cutoff", cutoff],
            ("replicates", replicates) => ["--replicates", replicates],
            _ => continue,
        };
        words.extend(option.map(quoted));
    }
    if seed != "0" {
        words.extend(["--seed".into(), quoted(seed)]);
    }
    if let Some(error) = asked {
        words.extend(["--error".into(), quoted(&error)]);
    }
    let variables: Vec<String> =
        get("Variables").map_or(Some(Vec::new()), |text| serde_json::from_str(text).ok())?;
    for variable in variables {
        match variable.strip_prefix("frame=") {
            Some(frame) => words.extend(["--frame".into(), quoted(frame)]),
            None => words.extend(["-D".into(), quoted(&variable)]),
        }
    }
    Some(words.join(" "))
}

/// As a shell reads it.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./,:=+%@".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.into()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Metadata;
    use crate::report::Report;

    #[test]
    fn the_command_has_what_differs_from_the_defaults() {
        let mut report = Report::default();
        report.scene.file = "my scenes/a.toml".into();
        report.scene.variables = vec!["frame=7".into(), "name=it's".into()];
        let s = &mut report.settings;
        (s.width, s.height, s.samples, s.depth, s.seed) = (60, 50, 4, 3, 9);
        (s.sampler, s.precision, s.origin) = ("stratified".into(), "f64".into(), "bound".into());
        (s.crop, s.cutoff, s.replicates) = (Some([1, 2, 30, 40]), 0.01, 2);
        let of = |report: &Report| {
            let pairs: Vec<_> = Metadata::of(report, 1.0).iter().map(|(k, v)| (k.into(), v.into())).collect();
            command(&pairs, "a.png")
        };
        assert_eq!(
            of(&report).unwrap(),
            "whitted render 'my scenes/a.toml' -o a.png --size 60x50 --samples 4 --depth 3 --sampler stratified \
             --precision f64 --crop 1,2,30,40 --cutoff 0.01 --replicates 2 --seed 9 --frame 7 -D 'name=it'\\''s'"
        );
        report.asked.error = Some(0.02);
        report.asked.met = Some(true);
        let command = of(&report).unwrap();
        assert!(command.contains("--error 0.02") && !command.contains("--samples"), "{command}");
        // A time does not give the same picture twice.
        (report.asked.error, report.asked.time) = (None, Some(2.0));
        assert_eq!(of(&report), None);
    }
}

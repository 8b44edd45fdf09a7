//! What is in a picture, and the command that makes it again.

use super::line;
use crate::cli::failure::Failure;
use crate::image::{Picture, described, linear_sha256, read_metadata};
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

/// The options behind the metadata of a render; none where it does not say enough, or asks for a time, which does not
/// give the same picture twice.
fn command(metadata: &[(String, String)], file: &str) -> Option<String> {
    let report = described(metadata)?;
    let (scene, s, asked) = (&report.scene, &report.settings, report.asked.error);
    if report.asked.time.is_some() {
        return None;
    }
    let mut words = vec!["whitted".into(), "render".into(), quoted(&scene.file), "-o".into(), quoted(file)];
    let mut option = |name: &str, value: String| words.extend([name.to_owned(), quoted(&value)]);
    option("--size", format!("{}x{}", s.width, s.height));
    // Else chosen for the error that was asked for.
    if asked.is_none() {
        option("--samples", s.samples.to_string());
        option("--depth", s.depth.to_string());
    }
    if s.sampler != "owen" {
        option("--sampler", s.sampler.clone());
    }
    if s.precision != "robust" && asked.is_none() {
        option("--precision", s.precision.clone());
    }
    if s.origin != "bound" {
        option("--origin", s.origin.clone());
    }
    if let Some(crop) = s.crop {
        option("--crop", crop.map(|n| n.to_string()).join(","));
    }
    if s.cutoff > 0.0 && asked.is_none() {
        option("--cutoff", s.cutoff.to_string());
    }
    if s.replicates > 1 && asked.is_none() {
        option("--replicates", s.replicates.to_string());
    }
    if s.seed != 0 {
        option("--seed", s.seed.to_string());
    }
    if let Some(error) = asked {
        option("--error", error.to_string());
    }
    if let Some(up) = &scene.up {
        words.push(format!("--up={}", quoted(up)));
    }
    for variable in &scene.variables {
        match variable.strip_prefix("frame=") {
            Some(frame) => words.extend(["--frame".into(), quoted(frame)]),
            None => words.extend(["-D".into(), quoted(variable)]),
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

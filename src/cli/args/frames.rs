//! The frames of `whitted render`.

use super::RenderArgs;
use super::values::Output;
use clap::Args;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Frames of a moving scene.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Frames")]
pub struct FrameArgs {
    /// Render frame N: `${frame}` in the scene's text is N, and `####` in the names of files to write its digits
    #[arg(long, value_name = "N")]
    pub frame: Option<u32>,

    /// Render the frames from A to B, B included, one after another; every S-th with xS
    #[arg(long, value_name = "A..B[xS]", conflicts_with = "frame")]
    pub frames: Option<Frames>,

    /// Leave out frames whose image is there, unless it was interrupted
    #[arg(long)]
    pub skip_existing: bool,
}

impl FrameArgs {
    /// The frames asked for; none without an option.
    pub fn list(&self) -> Vec<u32> {
        match (self.frame, self.frames) {
            (Some(frame), _) => vec![frame],
            (_, Some(Frames { first, last, step })) => (first..=last).step_by(step as usize).collect(),
            _ => Vec::new(),
        }
    }
}

/// `A..B` or `A..BxS`: A, A + S, ... up to B.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frames {
    /// A.
    pub first: u32,
    /// B, at least A.
    pub last: u32,
    /// S, at least 1.
    pub step: u32,
}

impl FromStr for Frames {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (range, step) = text.split_once('x').unwrap_or((text, "1"));
        let numbers = range
            .split_once("..")
            .and_then(|(first, last)| Some((first.parse().ok()?, last.parse().ok()?, step.parse().ok()?)));
        match numbers {
            Some((first, last, step)) if first <= last && step > 0 => Ok(Frames { first, last, step }),
            _ => {
                Err("write the first and the last frame, such as 1..24, or every second of them, 1..24x2"
                    .into())
            }
        }
    }
}

/// `path` with each run of `#` as the digits of `frame`, at least as many as the run is long.
pub(crate) fn numbered(path: &Path, frame: u32) -> PathBuf {
    // Names that are not UTF-8 keep their bytes only if nothing is to be put in.
    let Some(name) = path.to_str().filter(|name| name.contains('#')) else { return path.to_owned() };
    let mut text = String::new();
    let mut rest = name;
    while let Some(at) = rest.find('#') {
        let width = rest[at..].len() - rest[at..].trim_start_matches('#').len();
        text += &rest[..at];
        text += &format!("{frame:0width$}");
        rest = &rest[at + width..];
    }
    (text + rest).into()
}

impl RenderArgs {
    /// The arguments of one frame: the variable `frame`, and names with its number.
    pub fn of_frame(&self, frame: u32) -> RenderArgs {
        let mut args = self.clone();
        args.read.variables.push(("frame".into(), frame.to_string()));
        let number = |path: &PathBuf| numbered(path, frame);
        if let Output::File(path, _) | Output::Share(path) = &mut args.output {
            *path = number(path);
        }
        args.report = args.report.as_ref().map(number);
        args.page = args.page.as_ref().map(number);
        args
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_hold_both_ends() {
        let list =
            |text: &str| FrameArgs { frames: Some(text.parse().unwrap()), ..FrameArgs::default() }.list();
        assert_eq!(list("1..4"), [1, 2, 3, 4]);
        assert_eq!(list("0..7x3"), [0, 3, 6]);
        assert_eq!(list("5..5"), [5]);
        for bad in ["", "5", "5..4", "1..4x0", "1..", "..4", "-1..4", "1...4", "1..4x", "1..4x-1"] {
            assert!(bad.parse::<Frames>().is_err(), "{bad}");
        }
    }

    #[test]
    fn runs_of_signs_become_digits() {
        let name = |path: &str, frame| numbered(Path::new(path), frame).display().to_string();
        assert_eq!(name("out/a_####.png", 7), "out/a_0007.png");
        assert_eq!(name("#/##_####", 123), "123/123_0123");
        assert_eq!(name("a.png", 7), "a.png");
    }
}

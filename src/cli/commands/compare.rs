//! `whitted compare`.

mod folders;
mod pair;
mod text;

use crate::atomic_file;
use crate::cli::args::{CompareArgs, Metric};
use crate::cli::console::{self, Console};
use crate::cli::delivery::write_json;
use crate::cli::failure::Failure;
use crate::cli::files::Files;
use crate::compare::metrics::pixel_error;
use crate::compare::statistical::Statistics;
use crate::image::heat::{self, Range};
use crate::image::{Metadata, Picture};
use crate::report::ProgramInfo;
use crate::units::number;
use anyhow::Context;
use pair::{Criteria, Figures, Judged, Pair};
use serde::Serialize;
use std::path::Path;

/// What `--json` writes.
#[derive(Debug, Serialize)]
struct Comparison {
    program: ProgramInfo,
    a: PictureInfo,
    b: PictureInfo,
    metrics: Figures,
    judged: Judged,
    #[serde(skip_serializing_if = "Option::is_none")]
    statistical: Option<Statistics>,
    #[serde(skip_serializing_if = "Option::is_none")]
    diff: Option<Diff>,
}

#[derive(Debug, Serialize)]
struct PictureInfo {
    file: String,
    width: u32,
    height: u32,
    encoding: &'static str,
}

impl PictureInfo {
    fn of(path: &Path, picture: &Picture) -> PictureInfo {
        let Picture { width, height, encoding, .. } = *picture;
        PictureInfo { file: path.display().to_string(), width, height, encoding }
    }
}

/// The false-colour picture.
#[derive(Debug, Serialize)]
struct Diff {
    file: String,
    shows: &'static str,
    /// Numbers that the ends of the colours stand for.
    scale: [f64; 2],
}

/// Compares two pictures, or two folders of pictures.
pub fn run(args: &CompareArgs, console: &mut Console) -> Result<(), Failure> {
    files(args)?.check()?;
    match [&args.a, &args.b].map(|path| path.is_dir()) {
        [true, true] => folders::run(args, console),
        [false, false] => pictures(args, console),
        [a_is_folder, _] => {
            let (folder, other) = if a_is_folder { (&args.a, &args.b) } else { (&args.b, &args.a) };
            Err(Failure::Usage(format!(
                "{} is a folder and {} is not: compare two pictures or two folders",
                folder.display(),
                other.display()
            )))
        }
    }
}

fn pictures(args: &CompareArgs, console: &mut Console) -> Result<(), Failure> {
    if args.output.is_some() {
        return Err(Failure::Usage("-o writes a page of two folders; use --diff for two pictures".into()));
    }
    let mut pair = Pair::of(&args.a, &args.b, &Criteria::of(args))?;
    let diff = match &args.diff {
        Some(path) => Some(draw(path, args, &mut pair)?),
        None => None,
    };
    let refusal = pair.refusal();
    let (a, b) = (PictureInfo::of(&args.a, &pair.a), PictureInfo::of(&args.b, &pair.b));
    let Pair { figures, judged, statistics, .. } = pair;
    let program = ProgramInfo::default();
    let comparison = Comparison { program, a, b, metrics: figures, judged, statistical: statistics, diff };
    tell(args, &text::comparison(&comparison), &comparison, console)?;
    refusal.map_or(Ok(()), |why| Err(Failure::AboveThreshold(why)))
}

/// Its files: two pictures, or all pictures of two folders.
fn files(args: &CompareArgs) -> Result<Files, Failure> {
    let mut files = Files::new();
    for side in [&args.a, &args.b] {
        if side.is_dir() {
            for name in folders::names(side)? {
                files = files.reads("the picture", &side.join(name));
            }
        } else {
            files = files.reads("the picture", side);
        }
    }
    let files = files.writes("--diff", args.diff.as_deref()).writes("-o", args.output.as_deref());
    Ok(files.writes("--json", args.json.as_deref()).prints())
}

/// Writes the difference in false colours.
fn draw(path: &Path, args: &CompareArgs, pair: &mut Pair) -> Result<Diff, Failure> {
    let errors = pair.a.linear.iter().zip(&pair.b.linear).map(|(a, b)| pixel_error(a, b));
    let (shows, values): (_, Vec<f64>) = match args.metric {
        _ if args.statistical => {
            ("|z| of 8x8 blocks, standard errors, worst channel", std::mem::take(&mut pair.scores))
        }
        Metric::Flip => ("LDR-FLIP", std::mem::take(&mut pair.flip)),
        Metric::Codes => ("8-bit codes, worst channel", errors.map(|(_, code)| code.into()).collect()),
        _ => ("linear error, worst channel", errors.map(|(error, _)| error).collect()),
    };
    let range = args.full_scale.map_or(Range::Auto, |top| Range::Given(0.0, top));
    let (low, high) = range.ends(&values);
    let painted = heat::paint(&values, pair.a.width, range, shows);
    let scale = format!("{shows}, from {} (black) to {} (pale yellow)", number(low), number(high));
    let metadata = Metadata::new([
        ("Software", concat!(env!("CARGO_PKG_NAME"), " ", env!("CARGO_PKG_VERSION"))),
        ("Description", &format!("{} less {}", args.a.display(), args.b.display())),
        ("Scale", &scale),
    ]);
    atomic_file::write(path, |out| painted.write(&metadata, out))
        .with_context(|| format!("cannot write {}", path.display()))?;
    Ok(Diff { file: path.display().to_string(), shows, scale: [low, high] })
}

/// Prints `text` and writes `record` as JSON, as `--json` and `-q` say.
fn tell(
    args: &CompareArgs,
    text: &str,
    record: &impl Serialize,
    console: &mut Console,
) -> Result<(), Failure> {
    match &args.json {
        Some(path) if path.as_os_str() == "-" => {
            let json = serde_json::to_string_pretty(record).context("cannot express the figures as JSON")?;
            console.say(text);
            console::print(&(json + "\n"))
        }
        other => {
            if let Some(path) = other {
                write_json(path, record)?;
            }
            if console.is_quiet() { Ok(()) } else { console::print(text) }
        }
    }
}

#[cfg(test)]
mod tests;

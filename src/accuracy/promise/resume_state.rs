//! What an interrupted `--error` or `--budget` leaves to the one that goes on with it.

use super::rounding::Rounded;
use super::truncation_choice::Cut;
use super::{Request, Target};
use crate::accuracy::allocate::Allocation;
use crate::accuracy::pixel_sums::Gathered;
use crate::render::{Begun, Mismatch, RenderError, Survey};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::io::{self, BufRead, ErrorKind, Write};

/// How far it was.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) enum Stage {
    /// `--budget`: the samples, of the first pixels or of all; then those in f64.
    Settings,
    /// `--error`: everything that was chosen, and the allocation without its samples.
    Error(Box<Chosen>),
}

/// What `--error` chose.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Chosen {
    pub(super) cut: Cut,
    /// No deeper cut is to be tried.
    pub(super) last: bool,
    /// In f64, though it was not asked for.
    pub(super) double: bool,
    pub(super) rounded: Option<Rounded>,
    pub(super) allocation: Allocation,
}

/// An interrupted render whose error was asked for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UnfinishedBounded {
    /// The request, as options.
    asked: String,
    /// Which render it was, and the seconds of all parts so far.
    pub begun: Begun,
    pub(super) stage: Stage,
    /// Of the samples, to notice a damaged file.
    sha256: String,
    #[serde(skip)]
    pub(super) images: Vec<Gathered>,
}

/// What a file of this kind begins with.
const HEAD: &[u8] = b"{\"asked\":";

/// True if `header` is that of a [`UnfinishedBounded`].
pub(crate) fn is_kept(header: &[u8]) -> bool {
    header.starts_with(HEAD)
}

fn options(request: &Request) -> String {
    let what = match request.target {
        Target::Settings => "--budget".to_owned(),
        Target::Error(error) => format!("--error {error}"),
        Target::Time { seconds, .. } => format!("--time {seconds}"),
    };
    let kept = |is: bool, name: &str| if is { format!(", {name} given") } else { String::new() };
    format!(
        "{what} --confidence {}{}{}",
        request.confidence,
        kept(request.keep_depth, "--depth"),
        kept(request.keep_precision, "--precision")
    )
}

impl UnfinishedBounded {
    pub(super) fn new(
        request: &Request,
        begun: Begun,
        stage: Stage,
        images: Vec<Gathered>,
    ) -> UnfinishedBounded {
        let sha256 = digest(&bytes(&images));
        UnfinishedBounded { asked: options(request), begun, stage, sha256, images }
    }

    /// # Errors
    /// If it is of another request: says which.
    pub(super) fn check(&self, request: &Request) -> Result<(), Mismatch> {
        let asked = options(request);
        if self.asked == asked {
            return Ok(());
        }
        Err(Mismatch(format!("it belongs to a render with {}, this one has {asked}", self.asked)))
    }

    /// The earlier stage with its samples, counted by `survey`, if this is the same render as `now`.
    pub(super) fn taken_up(
        mut self,
        now: &Begun,
        survey: &mut Survey,
    ) -> Result<(Stage, Vec<Gathered>), RenderError> {
        self.begun.check(now)?;
        if let Stage::Error(chosen) = &mut self.stage {
            let fits = self.images.pop().is_some_and(|image| chosen.allocation.put_gathered(image));
            if !fits {
                return Err(Mismatch("samples are missing".into()).into());
            }
        }
        survey.count(&self.begun);
        Ok((self.stage, self.images))
    }

    /// Writes a line of JSON, then the samples as little-endian numbers.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        serde_json::to_writer(&mut *out, self)?;
        out.write_all(b"\n")?;
        out.write_all(&bytes(&self.images))
    }

    /// Reads what [`UnfinishedBounded::write`] wrote.
    ///
    /// # Errors
    /// If reading fails, or it is of another kind or version, or the samples are not those that were written.
    pub fn read(from: &mut dyn BufRead) -> io::Result<UnfinishedBounded> {
        let damaged = |what: &str| io::Error::new(ErrorKind::InvalidData, what.to_owned());
        let mut header = Vec::new();
        from.read_until(b'\n', &mut header)?;
        if !is_kept(&header) {
            return Err(damaged("it belongs to a render without --error and --budget"));
        }
        let mut kept: UnfinishedBounded = serde_json::from_slice(&header)?;
        let mut body = Vec::new();
        from.read_to_end(&mut body)?;
        let changed = || damaged("the file is damaged: wrong checksum");
        if digest(&body) != kept.sha256 {
            return Err(changed());
        }
        let mut rest = body.as_slice();
        while !rest.is_empty() {
            kept.images.push(Gathered::take(&mut rest).ok_or_else(changed)?);
        }
        Ok(kept)
    }
}

fn bytes(images: &[Gathered]) -> Vec<u8> {
    let mut all = Vec::new();
    images.iter().for_each(|image| image.put(&mut all));
    all
}

fn digest(bytes: &[u8]) -> String {
    format!("{:x}", Sha256::digest(bytes))
}

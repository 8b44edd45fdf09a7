//! What an interrupted `--error` or `--budget` leaves to the one that goes on with it.

use super::rounding::RoundingEstimate;
use super::truncation_choice::TruncationChoice;
use super::{Request, Target};
use crate::accuracy::allocate::Allocation;
use crate::accuracy::pixel_sums::PixelSums;
use crate::accuracy::unseen::Caps;
use crate::render::{Kind, Mismatch, Payload};
use crate::report::SettingsInfo;
use serde::{Deserialize, Serialize};
use std::io::{self, Write};

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
    pub(super) cut: TruncationChoice,
    /// No deeper cut is to be tried.
    pub(super) last: bool,
    /// In f64, though it was not asked for.
    pub(super) double: bool,
    pub(super) rounded: Option<RoundingEstimate>,
    pub(super) allocation: Allocation,
}

/// The samples of an image whose error is stated or asked for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Bounded {
    stage: Stage,
    #[serde(skip)]
    images: Vec<PixelSums>,
}

impl Bounded {
    pub(super) fn new(stage: Stage, images: Vec<PixelSums>) -> Bounded {
        Bounded { stage, images }
    }

    /// The samples again.
    pub(super) fn into_images(self) -> Vec<PixelSums> {
        self.images
    }

    /// The samples of `--budget`: in the settings' precision, then in f64.
    pub(super) fn into_budget(self) -> Result<Vec<PixelSums>, Mismatch> {
        match self.stage {
            Stage::Settings => Ok(self.images),
            Stage::Error(_) => Err(Mismatch("it holds no samples of --budget".into())),
        }
    }

    /// What `--error` chose, with its samples.
    pub(super) fn into_chosen(mut self, caps: Caps) -> Result<Chosen, Mismatch> {
        if let (Stage::Error(mut chosen), Some(image)) = (self.stage, self.images.pop())
            && chosen.allocation.put_gathered(image, caps)
        {
            return Ok(*chosen);
        }
        Err(Mismatch("it holds no samples of --error".into()))
    }
}

impl Payload for Bounded {
    const KIND: Kind = Kind::Bounded;

    fn put(&self, to: &mut dyn Write) -> io::Result<()> {
        for image in &self.images {
            let mut bytes = Vec::new();
            image.put(&mut bytes);
            to.write_all(&bytes)?;
        }
        Ok(())
    }

    fn take(&mut self, mut from: &[u8], settings: &SettingsInfo) -> Option<()> {
        let [x0, y0, x1, y1] = settings.region();
        let (width, height) = (x1.checked_sub(x0)?, y1.checked_sub(y0)?);
        let pixels = width as usize * height as usize;
        while !from.is_empty() {
            let image = PixelSums::take(&mut from)?;
            if (image.width, image.samples.len(), image.replicates)
                != (width, pixels, settings.replicates as usize)
            {
                return None;
            }
            self.images.push(image);
        }
        Some(())
    }
}

/// A request as options of the command line.
pub(super) fn options(request: &Request) -> String {
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

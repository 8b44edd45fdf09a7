//! What an interrupted `--error` or `--budget` leaves to the one that goes on with it.

use super::rounding::RoundingEstimate;
use super::truncation_choice::TruncationChoice;
use super::{Request, Target, Task};
use crate::accuracy::allocate::Allocation;
use crate::accuracy::pixel_sums::PixelSums;
use crate::accuracy::unseen::Caps;
use crate::render::{Identity, Kind, Mismatch, Payload, Survey};
use crate::report::{SettingsInfo, TimeInfo};
use serde::{Deserialize, Serialize};
use std::io::{self, Write};

/// How far it was.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) enum Stage {
    /// `--budget`: the samples, of the first pixels or of all; then those in f64.
    Settings,
    /// `--error`: everything that was chosen, and the allocation without its samples.
    Error(Box<Chosen>),
    /// `--time`: the same.
    Time(Box<Timed>),
}

/// What `--time` chose, as far as it was.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Timed {
    pub(super) cut: Option<TruncationChoice>,
    pub(super) rounded: Option<RoundingEstimate>,
    /// Rays a second.
    pub(super) pace: f64,
    pub(super) allocation: Allocation,
}

/// The render of which states are kept.
pub(super) struct Begun<'a> {
    pub(super) identity: &'a Identity,
    /// What earlier parts took.
    pub(super) before: &'a TimeInfo,
}

impl Task<'_> {
    /// Keeps the state of a render that goes on, and gives its samples back.
    pub(super) fn keep(&mut self, survey: &Survey, kept: Bounded, begun: &Begun<'_>) -> Vec<PixelSums> {
        let mut time = begun.before.clone();
        time.add(&self.took.so_far());
        survey.keep(&mut self.observer, time, begun.identity, kept).images
    }
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

    /// The samples of `--budget`: in the settings' precision, then in f64.
    pub(super) fn into_budget(self) -> Result<Vec<PixelSums>, Mismatch> {
        match self.stage {
            Stage::Settings => Ok(self.images),
            Stage::Error(_) | Stage::Time(_) => Err(Mismatch("it holds no samples of --budget".into())),
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

impl Bounded {
    /// What `--time` chose, with its samples.
    pub(super) fn into_timed(mut self, caps: Caps) -> Result<Timed, Mismatch> {
        if let (Stage::Time(mut timed), Some(image)) = (self.stage, self.images.pop())
            && timed.allocation.put_gathered(image, caps)
            && (0.0..f64::INFINITY).contains(&timed.pace)
        {
            return Ok(*timed);
        }
        Err(Mismatch("it holds no samples of --time".into()))
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

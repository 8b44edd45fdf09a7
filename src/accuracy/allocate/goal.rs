//! What is asked of an adaptive render, and how it begins.

use crate::accuracy::unseen::{Cap, Caps, Known, Unseen};
use serde::{Deserialize, Serialize};

/// Fewest samples of every pixel: a pixel of one is compared with its neighbour.
const LEAST_PILOT: u32 = 1;

/// Most samples of the pilot: what is asked for is judged after it.
const MOST_PILOT: u32 = 256;

/// Share of the squared target that may be unseen after the pilot.
const PILOT_UNSEEN: f64 = 0.5;

/// Share of the pixels that may hold more than is reckoned with there: they get their samples later.
const PILOT_BRIGHTER: f64 = 0.25;

/// What is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Goal {
    /// Greatest RMSE; `None` to go on while there is budget.
    pub target: Option<f64>,
    /// With this confidence.
    pub confidence: f64,
    /// Samples of every pixel in the first round.
    pub first: u32,
    /// Samples of every pixel before any gets more than others: `first` doubled some times.
    pub pilot: u32,
    /// Most samples of a pixel.
    pub most: u32,
}

impl Goal {
    /// A goal whose pilot leaves at most `PILOT_UNSEEN` of the target to what no sample met in pixels that hold nothing
    /// brighter than white; `most` permitting.
    pub fn for_target(target: f64, confidence: f64, pixels: usize, caps: &Caps, most: u32) -> Goal {
        let mut pilot = LEAST_PILOT;
        let allowed = PILOT_UNSEEN * target * target * pixels as f64;
        let base = Cap { radiance: caps.base(PILOT_BRIGHTER), ..Cap::WHITE };
        let unseen = |samples| {
            let mut one = Unseen::default();
            one.add(samples, base, Known::NOTHING);
            one.squares(confidence)
        };
        while pilot <= most.min(MOST_PILOT) / 2 && unseen(pilot) > allowed {
            pilot *= 2;
        }
        Goal { target: Some(target), confidence, first: pilot, pilot, most: most.max(pilot) }
    }
}

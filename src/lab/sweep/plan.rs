//! What a sweep is asked for, and who watches it.

use super::point::Point;
use crate::render::Observer;
use crate::scene::Scene;
use crate::settings::Settings;
use std::path::PathBuf;

/// What to sweep.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The scene as read from its file.
    pub scene: Scene,
    /// Settings that no axis varies: size and scheduling.
    pub base: Settings,
    /// Names of the axes, in the order given.
    pub axes: Vec<String>,
    /// The grid: all combinations of the axes' values.
    pub points: Vec<Point>,
    /// Output folder.
    pub folder: PathBuf,
    /// Timed renders of each point, after a warm-up.
    pub repeats: u32,
    /// Upper limit on the truth's samples per pixel.
    pub truth_samples: u32,
    /// RMSE values for which the fastest point is reported.
    pub errors: Vec<f64>,
    /// The command line, shown on the page.
    pub command: String,
    /// Trace the truth with the oracle on the CPU even if the device supports f64.
    pub oracle: bool,
    /// Ignore rows and truth of an earlier run in the same folder.
    pub fresh: bool,
}

/// Receives the progress of a sweep.
pub trait Watch {
    /// Returns an observer for one piece of work; it is dropped when the work ends.
    fn begin(&mut self, what: &str) -> Box<dyn Observer>;
    /// Reports a finished piece of work in one line.
    fn say(&mut self, line: &str);
}

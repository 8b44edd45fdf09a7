//! The precision of a render: the one asked for, or the one that the scene needs on the device at hand.

use crate::prepare::near::Near;
use crate::settings::{Precision, Settings};

/// What a choice of precision depends on besides the scene.
pub(super) struct Chosen<'a> {
    /// Faults of the device's f32.
    pub(super) single: &'a [String],
    /// The device has f64, and it has no faults.
    pub(super) sound_double: bool,
}

impl Chosen<'_> {
    /// `asked` with its precision settled, and what the user should know of it. `near` is of a scene of two scales that
    /// f32 is not enough for.
    pub(super) fn precision(&self, asked: &Settings, near: Option<&Near>) -> (Settings, Vec<String>) {
        let double = || Settings { precision: Precision::Double, ..asked.clone() };
        let single = || match asked.precision {
            Precision::Auto => Settings { precision: Precision::Robust, ..asked.clone() },
            _ => asked.clone(),
        };
        if asked.precision == Precision::Double {
            return (asked.clone(), Vec::new());
        }
        if asked.precision != Precision::Fast && !self.single.is_empty() {
            let why = format!("the f32 arithmetic of this device is unreliable: {}", self.single.join("; "));
            return match self.sound_double {
                true => (double(), vec![format!("rendered in f64 because {why}")]),
                false => (single(), vec![format!("error bounds may not hold: {why}")]),
            };
        }
        let Some(near) = near else {
            return (single(), Vec::new());
        };
        let why = near.words();
        match (asked.precision, self.sound_double) {
            (Precision::Auto, true) => (double(), vec![format!("rendered in f64 because {why}")]),
            (Precision::Auto, false) => (
                single(),
                vec![format!("the image may be wrong: {why}, and this device has no sound f64; render on a device that has")],
            ),
            (precision, _) => (
                single(),
                vec![format!("the image may be wrong at --precision {}: {why}; --precision f64 holds both", precision.name())],
            ),
        }
    }
}

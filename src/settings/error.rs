//! What is wrong with settings, and what they must be instead.

use super::{Origin, Settings};
use crate::scene::{MAX_DEPTH, MAX_SAMPLES, MAX_SIDE};

/// Invocations that a workgroup may have.
const WORKGROUPS: [u32; 4] = [32, 64, 128, 256];

/// A setting outside its range.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SettingsError {
    /// Width, height, pixels.
    #[error("{0}x{1} pixels: width and height must be from 1 to {MAX_SIDE}")]
    Size(u32, u32),
    /// Samples per pixel.
    #[error("{0} samples a pixel: there must be from 1 to {MAX_SAMPLES}")]
    Samples(u32),
    /// Rays in the longest path.
    #[error("depth {0}: it must be from 1 to {MAX_DEPTH}")]
    Depth(u32),
    /// Least throughput of a ray.
    #[error("cutoff {0}: it must be at least 0 and below 1")]
    Cutoff(f32),
    /// Distance from the surface to a secondary ray's origin, metres.
    #[error("origin fixed:{0}: the distance must be a number of at least 0")]
    Origin(f64),
    /// x0, y0, x1, y1.
    #[error("crop {0:?}: it must be x0 < x1, y0 < y1 within the image")]
    Crop([u32; 4]),
    /// Replicates, samples.
    #[error(
        "{0} replicates of {1} samples: a bound needs at least 2 replicates, in a number that divides the samples"
    )]
    Replicates(u32, u32),
    /// Invocations per workgroup.
    #[error("workgroups of {0}: there must be 32, 64, 128 or 256 invocations")]
    Workgroup(u32),
    /// A part of the schedule: its name.
    #[error("{0} 0: it must be at least 1")]
    Schedule(&'static str),
    /// Confidence of an error bound.
    #[error("confidence {0}: it must be above 0 and below 1")]
    Confidence(f64),
    /// Error asked for.
    #[error("an error of {0}: it must be above 0")]
    Error(f64),
    /// Time asked for, seconds.
    #[error("a time of {0} s: it must be above 0")]
    Time(f64),
}

impl Settings {
    /// Checks every range.
    ///
    /// # Errors
    /// The first setting that is outside its range.
    pub fn check(&self) -> Result<(), SettingsError> {
        let schedule = &self.schedule;
        let side = |n: u32| (1..=MAX_SIDE).contains(&n);
        let fail = |ok: bool, error: SettingsError| if ok { Ok(()) } else { Err(error) };
        fail(side(self.width) && side(self.height), SettingsError::Size(self.width, self.height))?;
        fail((1..=MAX_SAMPLES).contains(&self.samples), SettingsError::Samples(self.samples))?;
        fail((1..=MAX_DEPTH).contains(&self.depth), SettingsError::Depth(self.depth))?;
        fail((0.0..1.0).contains(&self.cutoff), SettingsError::Cutoff(self.cutoff))?;
        if let Origin::Fixed(distance) = self.origin {
            fail(distance >= 0.0 && distance.is_finite(), SettingsError::Origin(distance))?;
        }
        let crop = self.region();
        let [x0, y0, x1, y1] = crop;
        fail(x0 < x1 && y0 < y1 && x1 <= self.width && y1 <= self.height, SettingsError::Crop(crop))?;
        if let Some(workgroup) = schedule.workgroup {
            fail(WORKGROUPS.contains(&workgroup), SettingsError::Workgroup(workgroup))?;
        }
        let parts = [
            ("tile-pixels", schedule.tile_pixels),
            ("batch-samples", schedule.batch_samples),
            ("capacity", schedule.capacity),
        ];
        let zero = parts.into_iter().find(|(_, value)| *value == Some(0));
        zero.map_or(Ok(()), |(name, _)| Err(SettingsError::Schedule(name)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::procedural::shapes;
    use crate::settings::Schedule;

    #[test]
    fn each_range_is_checked() {
        let good = Settings::of(&shapes::room());
        assert_eq!(good.check(), Ok(()));
        let s = || good.clone();
        let schedule = |schedule: Schedule| Settings { schedule, ..s() };
        let outside = [s().width + 1, 4, s().width + 2, 5];
        let bad = [
            (Settings { width: 0, ..s() }, SettingsError::Size(0, good.height)),
            (Settings { height: 65_536, ..s() }, SettingsError::Size(good.width, 65_536)),
            (Settings { samples: 0, ..s() }, SettingsError::Samples(0)),
            (Settings { depth: 0, ..s() }, SettingsError::Depth(0)),
            (Settings { depth: 1025, ..s() }, SettingsError::Depth(1025)),
            (Settings { cutoff: 1.0, ..s() }, SettingsError::Cutoff(1.0)),
            (Settings { origin: Origin::Fixed(-1.0), ..s() }, SettingsError::Origin(-1.0)),
            (Settings { crop: Some([3, 4, 3, 9]), ..s() }, SettingsError::Crop([3, 4, 3, 9])),
            (Settings { crop: Some(outside), ..s() }, SettingsError::Crop(outside)),
            (schedule(Schedule { workgroup: Some(48), ..Schedule::default() }), SettingsError::Workgroup(48)),
            (
                schedule(Schedule { batch_samples: Some(0), ..Schedule::default() }),
                SettingsError::Schedule("batch-samples"),
            ),
        ];
        for (settings, error) in bad {
            assert_eq!(settings.check(), Err(error));
        }
        assert!(Settings { cutoff: f32::NAN, ..s() }.check().is_err());
    }
}

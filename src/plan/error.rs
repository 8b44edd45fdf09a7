//! Why no plan exists.

use crate::units;
use std::fmt;

/// Why no plan exists; says what would fit.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PlanError {
    /// The scene's primitives take more than the device has.
    #[error("{primitives} primitives need {shortage}; about {fit} would fit")]
    SceneTooLarge {
        /// Triangles and spheres of the scene.
        primitives: usize,
        /// What is short.
        shortage: Shortage,
        /// Primitives of this scene's kind that would fit, estimated.
        fit: u64,
    },
    /// The image takes more than the host has.
    #[error(
        "an image of {}x{} pixels needs {} of the host's memory beside the scene, and {} are free; {}x{} pixels would \
         fit, and so would parts of it with --crop",
        size[0],
        size[1],
        units::bytes(*bytes),
        units::bytes(*free),
        fit[0],
        fit[1]
    )]
    ImageTooLarge {
        /// Width and height, pixels.
        size: [u32; 2],
        /// Bytes needed.
        bytes: u64,
        /// Bytes that this process can still have.
        free: u64,
        /// Width and height of the same shape that would fit.
        fit: [u32; 2],
    },
    /// A queue for one sample at a time takes more than the device has.
    #[error("even a single ray at a time needs {shortage}; reduce --depth")]
    RayTooLarge {
        /// What is short.
        shortage: Shortage,
    },
}

/// Memory that a plan needs and a device does not have.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shortage {
    /// The buffer that is larger than the device can bind; `None` where the sum of all buffers is too large.
    pub buffer: Option<&'static str>,
    /// Bytes needed.
    pub bytes: u64,
    /// Bytes of the largest binding, or three quarters of the device's memory.
    pub limit: u64,
}

impl fmt::Display for Shortage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (bytes, limit) = (units::bytes(self.bytes), units::bytes(self.limit));
        match self.buffer {
            Some(name) => {
                write!(f, "{bytes} for `{name}`, but a buffer on this device can have at most {limit}")
            }
            None => write!(f, "{bytes}, but three quarters of this device's memory are {limit}"),
        }
    }
}

//! Why there is no image.

use super::Mismatch;
use crate::plan::PlanError;
use crate::settings::SettingsError;
use crate::vk::VkError;

/// Why there is no image. The text of a variant does not repeat that of its source.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// No Vulkan, no usable device, or not the one asked for.
    #[error(transparent)]
    NoDevice(VkError),
    /// A setting is outside its range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Double precision is asked of a device without it.
    #[error("`{device}` has no double precision (shaderFloat64); take --precision robust or another device")]
    NoDouble {
        /// Name of the device.
        device: String,
    },
    /// The device stopped answering.
    #[error(transparent)]
    DeviceLost(VkError),
    /// An interrupt ended the wait for a driver; the process is about to end.
    #[error(transparent)]
    Interrupted(VkError),
    /// The device has less free memory than the plan needs.
    #[error(transparent)]
    OutOfMemory(VkError),
    /// The scene or the settings do not fit this device; says what would.
    #[error(transparent)]
    DoesNotFit(#[from] PlanError),
    /// One sample has more rays alive at one depth than the planned queue holds.
    #[error(
        "one sample{} has more than {capacity} rays alive at one depth, more than the queue holds; \
         reduce --depth",
        of_pixel(pixel)
    )]
    TooManyRays {
        /// Column and row of the sample's pixel, if it is known.
        pixel: Option<[u32; 2]>,
        /// Rays that the queue holds.
        capacity: u32,
    },
    /// The earlier part belongs to another render.
    #[error(transparent)]
    Mismatch(#[from] Mismatch),
    /// Any other failed Vulkan call.
    #[error(transparent)]
    Vulkan(VkError),
}

impl RenderError {
    /// True if a smaller scene, depth or image may succeed on this device.
    pub fn does_not_fit(&self) -> bool {
        matches!(
            self,
            RenderError::OutOfMemory(_) | RenderError::DoesNotFit(_) | RenderError::TooManyRays { .. }
        )
    }
}

impl From<VkError> for RenderError {
    fn from(error: VkError) -> Self {
        match error {
            VkError::NoLoader(_) | VkError::NoDevice(_) => RenderError::NoDevice(error),
            VkError::Lost { .. } => RenderError::DeviceLost(error),
            VkError::Interrupted { .. } => RenderError::Interrupted(error),
            VkError::Memory { .. } => RenderError::OutOfMemory(error),
            VkError::TooLong { .. } | VkError::Call { .. } => RenderError::Vulkan(error),
        }
    }
}

fn of_pixel(pixel: &Option<[u32; 2]>) -> String {
    pixel.map_or(String::new(), |[x, y]| format!(" of pixel ({x}, {y})"))
}

//! What can go wrong below, with the call and the object it happened to.

use super::instance::INSTALL_HINT;
use ash::vk;

/// A failed Vulkan call, or a missing device.
#[derive(Debug, thiserror::Error)]
pub enum VkError {
    /// This machine has no Vulkan loader.
    #[error("no Vulkan loader: {INSTALL_HINT}")]
    NoLoader(#[source] ash::LoadingError),
    /// No driver, no usable device, or not the one asked for.
    #[error("{0}")]
    NoDevice(String),
    /// A call failed.
    #[error("{call} on {object}")]
    Call {
        /// The Vulkan command.
        call: &'static str,
        /// What it was for.
        object: String,
        /// What the driver answered.
        #[source]
        result: vk::Result,
    },
    /// The device stopped answering.
    #[error(
        "the device was lost in or right after the pass `{pass}`; a driver's watchdog ends long submits: try --batch-samples 1 or a smaller --tile-pixels"
    )]
    Lost {
        /// The last pass that was begun.
        pass: String,
    },
    /// The user's interrupt ended the wait for a driver.
    #[error("interrupted while the driver was at {at}")]
    Interrupted {
        /// What it was at.
        at: String,
    },
    /// More was to be written to a buffer than it holds.
    #[error("{bytes} bytes do not go into `{name}`, which has {room}")]
    TooLong {
        /// Buffer.
        name: String,
        /// Bytes to write.
        bytes: u64,
        /// Bytes of the buffer.
        room: u64,
    },
    /// The memory allocator refused.
    #[error("cannot allocate {bytes} bytes for `{name}`")]
    Memory {
        /// Buffer.
        name: String,
        /// Its size.
        bytes: u64,
        /// The allocator's reason.
        source: gpu_allocator::AllocationError,
    },
}

/// Names the call and the object of a failed Vulkan result.
pub(super) fn call(call: &'static str, object: impl Into<String>) -> impl FnOnce(vk::Result) -> VkError {
    move |result| VkError::Call { call, object: object.into(), result }
}

//! The Vulkan side: the only module with `unsafe`, and the only one that names `ash`.
//!
//! Four objects by lifetime: [`Device`] (the process), [`Pipelines`] (a kernel variant), [`Buffers`]
//! (a plan) and [`Recorder`] (a submit).
#![allow(unsafe_code)]

mod buffer;
mod candidate;
mod choice;
mod debug;
mod device;
mod driver_files;
pub mod environment;
mod error;
mod executable;
mod instance;
mod kernel;
mod list;
mod recorder;
mod watch;

pub use buffer::{Buffers, Made};
pub use device::Device;
pub use error::VkError;
pub use kernel::Pipelines;
pub use list::{DeviceSummary, Devices, list};
pub use recorder::{DISPATCHES_MAX, Dispatch, Recorder, Timed};
pub use watch::{Watch, end, is_abandoned, watch};

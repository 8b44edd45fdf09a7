//! Everything that host and kernels share: structs, constants, buffers with their binding numbers, specialisation
//! constants. Each is declared once, here; `build.rs` includes this module, writes `abi.glsl` from it for the
//! kernels, and checks the compiled SPIR-V against it.
//!
//! Layout is `scalar` (GL_EXT_scalar_block_layout): fields of 4 bytes, no padding, so `repr(C)` and
//! GLSL agree.

#[macro_use]
mod layout;
mod buffers;
mod constants;
mod device_structs;
mod host_structs;
mod specialisation;

pub use buffers::*;
pub use constants::*;
pub use layout::GpuStruct;
pub use single::*;
pub use specialisation::*;

/// Shared structs of the single-precision kernels.
pub mod single {
    use super::layout::{GpuStruct, concat};

    pub use super::device_structs::single::*;
    pub use super::host_structs::single::*;

    /// All shared structs with their layouts, in declaration order.
    pub const STRUCTS: &[GpuStruct] = &concat::<{ HOST.len() + DEVICE.len() }>(HOST, DEVICE);
}

/// The same of the double-precision kernels.
pub mod double {
    use super::layout::{GpuStruct, concat};

    pub use super::device_structs::double::*;
    pub use super::host_structs::double::*;

    /// All shared structs with their layouts, in declaration order.
    pub const STRUCTS: &[GpuStruct] = &concat::<{ HOST.len() + DEVICE.len() }>(HOST, DEVICE);
}

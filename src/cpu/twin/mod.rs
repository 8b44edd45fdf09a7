//! The kernels on the CPU: one file per kernel and per library file of the same name, with the same
//! buffers in the same order, operation by operation in the kernels' arithmetic. Where a device
//! rounds as IEEE 754 says, twin and kernel agree to the bit.

pub mod gather;
pub mod generate;
pub mod intersect;
pub mod lib;
pub mod memory;
pub mod resolve;
pub mod scan;
pub mod shade;
pub mod shadow;
pub mod spawn;

mod frame;

pub use frame::{Counts, render};
pub use memory::Memory;

//! The twins in double precision: the same files.

#[path = "batches.rs"]
pub mod batches;
#[path = "fused_depth.rs"]
pub mod fused_depth;
#[path = "gather.rs"]
pub mod gather;
#[path = "generate.rs"]
pub mod generate;
#[path = "intersect.rs"]
pub mod intersect;
#[path = "lib/mod.rs"]
pub mod lib;
#[path = "light.rs"]
pub mod light;
#[path = "memory.rs"]
pub mod memory;
#[path = "place.rs"]
pub mod place;
#[path = "resolve.rs"]
pub mod resolve;
#[path = "run.rs"]
mod run;
#[path = "scan.rs"]
pub mod scan;
#[path = "shade.rs"]
pub mod shade;
#[path = "shadow.rs"]
pub mod shadow;
#[path = "spawn.rs"]
pub mod spawn;
#[path = "walk.rs"]
pub mod walk;
#[path = "real_f64.rs"]
pub mod real;

/// Structs of the double-precision kernels.
pub mod structs {
    pub use crate::kernel::abi::double::*;
    // Structs of words alone are one type for both precisions.
    pub use crate::kernel::abi::{Push, Queue};
}
pub use batches::render;
pub use memory::Memory;

use crate::settings::Precision;

const PRECISION: Precision = Precision::Double;

/// Host structs as these kernels see them.
fn from_host<T: Copy>(host: &[T]) -> Vec<T> {
    host.to_vec()
}

//! The twins in single precision.

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
#[path = "real_f32.rs"]
pub mod real;
#[path = "words.rs"]
mod words;

pub use crate::kernel::abi::single as structs;
pub use batches::render;
pub use memory::Memory;
pub use words::POISON;

use crate::settings::Precision;

const PRECISION: Precision = Precision::Robust;

/// Host structs as these kernels see them: each number rounded once.
fn from_host<W, N: for<'w> From<&'w W>>(host: &[W]) -> Vec<N> {
    host.iter().map(N::from).collect()
}

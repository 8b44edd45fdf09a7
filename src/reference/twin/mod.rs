//! The kernels on the CPU: one file per kernel and per library file of the same name (one for the
//! folder `glsl/lib/traverse`), with the same buffers in the same order, operation by operation in
//! the kernels' arithmetic. Where a device rounds as IEEE 754 says, twin and kernel agree to the bit.
//!
//! Like the kernels, the files are compiled once with `real` = f32 and once with `real` = f64.
// `!(x > 0.0)` says what happens to NaN, and the constants are exact powers of two, as in the kernels.
#![allow(clippy::duplicate_mod, clippy::neg_cmp_op_on_partial_ord, clippy::excessive_precision)]

pub mod double;
pub mod single;

use crate::kernel::abi;
use crate::plan::Plan;
use crate::prepare::Packed;
use crate::report::test_counts::KindTests;
use crate::scene::Scene;
use crate::settings::{Precision, Settings};

/// Rays and events that a render counted.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Counts {
    /// Per depth: rays traced, reflection and refraction rays among them, shadow rays.
    pub depths: Vec<[u64; 4]>,
    /// By `abi::COUNTER_…`.
    pub counters: [u64; abi::COUNTERS as usize],
    /// Tests of each depth and kind of ray; none if they are not counted.
    pub tests: Vec<KindTests>,
}

/// The linear image and the counts of a scene under a plan. `None` if one sample of a pixel has more
/// rays at one depth than the plan's queue holds.
pub fn render(
    packed: &Packed,
    scene: &Scene,
    settings: &Settings,
    plan: &Plan,
) -> Option<(Vec<[f32; 3]>, Counts)> {
    match settings.precision {
        Precision::Double => double::render(packed, scene, settings, plan),
        Precision::Fast | Precision::Auto | Precision::Robust => {
            single::render(packed, scene, settings, plan)
        }
    }
}

//! The plan of a scene on a device, made before anything is allocated: specialisation, queue
//! capacity, tile and batch, bytes.

mod brute_force;
mod build;
pub mod dispatches;
mod driver;
mod error;
pub mod explain;
mod fit;
pub mod host_memory;
mod limits;
pub mod memory_traffic;
pub mod passes;
mod planned_scene;
pub mod predicted_time;
mod sizes;
pub mod tiles;

pub use brute_force::{BRUTE_FORCE_MAX, brute_force_max, pack_for};
pub use driver::Driver;
pub use error::{PlanError, Shortage};
pub(crate) use fit::HEAP_EIGHTHS;
pub use limits::{Limits, Switched, TEXEL_BYTES};
pub use planned_scene::{PlannedScene, Purpose};
pub use sizes::WALKS;
pub use sizes::element_bytes;

use crate::kernel::abi::Specialisation;
use crate::kernel::table::Kernel;
use crate::prepare::Packed;
use crate::prepare::max_depth::MaxDepth;
use crate::settings::Settings;
use build::Input;
use dispatches::dispatches;

/// A plan: kernel variant and sizes.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Kernel variant.
    pub specialisation: Specialisation,
    /// Rays that fit a queue.
    pub capacity: u32,
    /// Pixels of a tile, at most.
    pub tile_pixels: u32,
    /// Samples per pixel traced together, at most.
    pub batch_samples: u32,
    /// Lights per `shadow` pass.
    pub lights_per_pass: u32,
    /// Greatest depth of the scene's rays.
    pub max_depth: MaxDepth,
    /// Depth of the last passes; of a survey, without cutoff.
    pub last_depth: u32,
    /// Bytes of each buffer, in binding order.
    pub buffer_bytes: Vec<u64>,
    /// The same for [`Plan::in_parts`].
    pub bytes_in_parts: Vec<u64>,
    /// Walks take as many dispatches as they need.
    pub parts: bool,
    /// Names of the features that the scene uses.
    pub features: Vec<&'static str>,
}

impl Plan {
    /// Plans the image of `packed` under `settings`.
    ///
    /// # Errors
    /// If the scene does not fit the device; says what would.
    pub fn new(packed: &Packed, settings: &Settings, limits: &Limits) -> Result<Plan, PlanError> {
        Plan::build(Input { packed, settings, limits, survey: false })
    }

    /// True if the rays of a subgroup traverse the hierarchy together, over compressed nodes.
    pub fn walks_in_packets(&self) -> bool {
        self.specialisation.use_bvh != 0 && self.specialisation.lanes != 0
    }

    /// How depths are done.
    pub fn way(&self) -> passes::Way {
        match (self.parts, self.specialisation.fused) {
            (true, _) => passes::Way::Parts,
            (false, 0) => passes::Way::Split,
            (false, _) => passes::Way::Fused,
        }
    }

    /// The plan for batches in which a walk does not end in one dispatch: the same queues, kernels that go on.
    #[must_use]
    pub fn in_parts(&self) -> Plan {
        let mut plan = self.clone();
        plan.specialisation.fused = 0;
        plan.buffer_bytes.clone_from(&self.bytes_in_parts);
        Plan { parts: true, ..plan }
    }

    /// The kernels that a batch runs, in the order of the pass table.
    pub fn kernels(&self) -> Vec<Kernel> {
        let runs: Vec<Kernel> = dispatches(self, self.last_depth).map(|s| s.pass.kernel).collect();
        passes::all().map(|p| p.kernel).filter(|k| runs.contains(k)).collect()
    }

    /// Sum of the buffers' bytes.
    pub fn bytes(&self) -> u64 {
        self.buffer_bytes.iter().sum()
    }
}

#[cfg(test)]
mod tests;

//! The limits of a device, and what they allow whatever the scene.

use super::Driver;
use crate::kernel::abi;
use crate::kernel::table::Kernel;
use crate::prepare::bvh::Forms;
use crate::settings::forced_features::Feature;
use crate::settings::{Precision, Settings};

/// Bytes of a texel: four words.
pub const TEXEL_BYTES: u64 = 16;

/// Invocations per workgroup, unless a schedule says otherwise.
const DEFAULT_WORKGROUP: u32 = 64;

/// The limits of a device that a plan depends on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of one storage-buffer binding.
    pub storage_range: u64,
    /// Bytes of the heap that buffers come from.
    pub heap: u64,
    /// Invocations per workgroup.
    pub workgroup_invocations: u32,
    /// Texels of a texel buffer.
    pub texel_elements: u32,
    /// Invocations of a subgroup, if compute kernels may shuffle values among them; else 0.
    pub shuffle_lanes: u32,
    /// Storage buffers that one kernel may have.
    pub storage_buffers: u32,
    /// What was measured of the driver.
    pub driver: Driver,
}

impl Limits {
    /// Limits of lavapipe 22.3 with vectors of 8 lanes, for plans without a device, as the twins take them.
    pub const LAVAPIPE: Limits = Limits {
        storage_range: 1 << 27,
        heap: 1 << 31,
        workgroup_invocations: 1024,
        texel_elements: 1 << 27,
        shuffle_lanes: 8,
        storage_buffers: 32,
        driver: Driver::Lavapipe,
    };

    /// The forms of a hierarchy's nodes that a plan for such a device may need: rays that traverse together read
    /// compressed nodes. Where a vector of a few lanes is the whole machine, what each lane loads and stores by
    /// itself is the cost, and the rays of eight pixels meet much the same nodes: they traverse together, if the driver's
    /// compiler copes. A GPU's lanes load side by side, and 32 or 64 rays have less in common.
    pub fn forms(&self, settings: &Settings) -> Forms {
        let lone = settings.schedule.forced_features.has(Feature::LoneRays);
        if lone || !may_join(settings, self) {
            Forms::Nodes
        } else if TEXEL_BYTES * u64::from(self.texel_elements) >= self.storage_range {
            // What texels do not reach fits no binding either.
            Forms::Compressed
        } else {
            Forms::Both
        }
    }
}

/// Choices that follow from a device's limits, for scenes of a usual size (docs/design/gpu.md).
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct Switched {
    /// Scene and queues are read as texels, not as storage buffers.
    pub texels: bool,
    /// The rays of a subgroup traverse the hierarchy together.
    pub packets: bool,
    /// Renders of many samples take one kernel for the stages of a depth.
    pub fused: bool,
}

impl Switched {
    /// Choices for a device, in single precision.
    pub fn of(limits: &Limits) -> Switched {
        let workgroup = DEFAULT_WORKGROUP.min(limits.workgroup_invocations);
        let texels = limits.driver.gathers_texels();
        let packets = texels && limits.driver.joins_lanes() && is_full(workgroup, limits);
        Switched { texels, packets, fused: packets && binds_all(limits) }
    }
}

/// True if one kernel can bind all buffers that the stages of a depth read and write.
pub(super) fn binds_all(limits: &Limits) -> bool {
    let code = Kernel::FusedDepth.code();
    limits.storage_buffers >= (code.reads | code.writes).count_ones()
}

/// Invocations per workgroup.
pub(super) fn workgroup(settings: &Settings, limits: &Limits) -> u32 {
    settings
        .schedule
        .workgroup
        .unwrap_or(DEFAULT_WORKGROUP)
        .min(limits.workgroup_invocations)
        .min(abi::WORKGROUP_MAX)
}

/// True if subgroups are full and of a size that the kernels' shuffles support.
fn is_full(workgroup: u32, limits: &Limits) -> bool {
    matches!(limits.shuffle_lanes, 4 | 8) && workgroup.is_multiple_of(limits.shuffle_lanes)
}

/// True if the lanes of a subgroup can work together on a scene that fits texel views.
pub(super) fn may_join(settings: &Settings, limits: &Limits) -> bool {
    limits.driver.joins_lanes()
        && may_read_texels(settings, limits)
        && is_full(workgroup(settings, limits), limits)
}

/// True if kernels read through texel views wherever a buffer fits its view. Views have no f64.
pub(super) fn may_read_texels(settings: &Settings, limits: &Limits) -> bool {
    limits.driver.gathers_texels()
        && settings.precision != Precision::Double
        && !settings.schedule.forced_features.has(Feature::Storage)
}

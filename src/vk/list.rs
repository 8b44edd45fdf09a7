//! `whitted devices`: what is there, and whether it can be used.

use super::candidate::{Candidate, candidates};
use super::choice::{advantage, choose};
use super::error::VkError;
use super::instance::Instance;
use crate::settings::DeviceChoice;
use serde::Serialize;

/// One physical device.
#[derive(Debug, Clone, Serialize)]
pub struct DeviceSummary {
    /// Number for `--device`.
    pub index: usize,
    /// True for the one that is taken if none is asked for.
    pub default: bool,
    /// What the one that is taken has before this one; null for that one, and where this cannot be used.
    pub behind: Option<String>,
    /// As the driver names it.
    pub name: String,
    /// `cpu`, `discrete`, `integrated`, `virtual` or `other`.
    #[serde(rename = "type")]
    pub kind: String,
    /// Driver name and version text.
    pub driver: String,
    /// Vulkan version.
    pub api: String,
    /// 32 hexadecimal digits.
    pub uuid: String,
    /// Bytes of one storage-buffer binding.
    pub storage_range: u64,
    /// Bytes of the largest device-local heap.
    pub heap: u64,
    /// Invocations per workgroup.
    pub workgroup_invocations: u32,
    /// Invocations per subgroup.
    pub subgroup_size: u32,
    /// Bytes of push constants.
    pub push_constants: u32,
    /// Storage buffers one kernel may bind.
    pub storage_buffers: u32,
    /// Valid bits of a timestamp; 0 = passes cannot be timed one by one.
    pub timestamp_bits: u32,
    /// Nanoseconds per timestamp tick.
    pub timestamp_period: f32,
    /// Double precision in kernels.
    pub float64: bool,
    /// Why it cannot be used; null if it can.
    pub unusable: Option<String>,
}

/// Devices, and drivers that are not there.
#[derive(Debug, Clone)]
pub struct Devices {
    /// In the order that `--device N` counts.
    pub listed: Vec<DeviceSummary>,
    /// What the user should know of drivers that could not be loaded.
    pub notes: Vec<String>,
}

/// All Vulkan devices, in the order that `--device N` counts.
pub fn list() -> Result<Devices, VkError> {
    let instance = Instance::new(false)?;
    let all = candidates(&instance)?;
    let best = choose(&all, &DeviceChoice::Best, &[]).ok();
    let behind = |c: &Candidate| {
        let other = best.as_ref().filter(|b| b.handle != c.handle && c.lacks().is_none());
        other.map(|b| advantage(b, c))
    };
    let listed = all
        .into_iter()
        .enumerate()
        .map(|(index, c)| {
            let limits = &c.properties.limits;
            DeviceSummary {
                index,
                default: best.as_ref().is_some_and(|b| b.handle == c.handle),
                behind: behind(&c),
                name: c.name.clone(),
                kind: c.kind().into(),
                driver: c.driver.clone(),
                api: c.api(),
                uuid: c.uuid.iter().map(|b| format!("{b:02x}")).collect(),
                storage_range: u64::from(limits.max_storage_buffer_range),
                heap: c.heap,
                workgroup_invocations: c.limits().workgroup_invocations,
                subgroup_size: c.subgroup_size,
                push_constants: limits.max_push_constants_size,
                storage_buffers: limits.max_per_stage_descriptor_storage_buffers,
                timestamp_bits: c.timestamp_bits,
                timestamp_period: limits.timestamp_period,
                float64: c.float64,
                unusable: c.lacks(),
            }
        })
        .collect();
    Ok(Devices { listed, notes: instance.notes.clone() })
}

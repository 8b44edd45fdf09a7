//! What a physical device is and can.

use super::error::{VkError, call};
use super::instance::Instance;
use crate::plan::{Driver, Limits};
use ash::vk;
use std::ffi::CStr;

/// Storage buffers that a device must bind at once: those of the widest split kernel. The fused depth binds more, and
/// is used only where the device allows it.
const STORAGE_BUFFERS_PER_STAGE: u32 = 16;

/// Memory that absent hardware is taken to have, bytes.
const SUPPOSED_HEAP: u64 = 8 << 30;

/// What a physical device is and can, as far as it matters here.
#[derive(Clone)]
pub(super) struct Candidate {
    pub(super) handle: vk::PhysicalDevice,
    pub(super) properties: vk::PhysicalDeviceProperties,
    pub(super) subgroup_size: u32,
    pub(super) shuffles: bool,
    /// Name and version text.
    pub(super) driver: String,
    /// What was measured of it.
    pub(super) measured: Driver,
    pub(super) uuid: [u8; 16],
    pub(super) heap: u64,
    /// Bytes of one allocation at most.
    pub(super) allocation: u64,
    pub(super) queue_family: Option<u32>,
    pub(super) timestamp_bits: u32,
    pub(super) scalar_layout: bool,
    pub(super) float64: bool,
    pub(super) name: String,
}

impl Candidate {
    fn new(instance: &ash::Instance, handle: vk::PhysicalDevice) -> Candidate {
        let mut driver = vk::PhysicalDeviceDriverProperties::default();
        let mut ids = vk::PhysicalDeviceIDProperties::default();
        let mut subgroup = vk::PhysicalDeviceSubgroupProperties::default();
        let mut memory_limits = vk::PhysicalDeviceMaintenance3Properties::default();
        let mut properties = vk::PhysicalDeviceProperties2::default()
            .push_next(&mut memory_limits)
            .push_next(&mut driver)
            .push_next(&mut ids)
            .push_next(&mut subgroup);
        // SAFETY: `handle` came from this instance; the chain lives through the call.
        unsafe { instance.get_physical_device_properties2(handle, &mut properties) };
        let core = properties.properties;
        let allocation = memory_limits.max_memory_allocation_size;
        let mut scalar = vk::PhysicalDeviceScalarBlockLayoutFeatures::default();
        let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut scalar);
        // SAFETY: as above.
        unsafe { instance.get_physical_device_features2(handle, &mut features) };
        let float64 = features.features.shader_float64 == vk::TRUE;
        // SAFETY: `handle` came from this instance.
        let memory = unsafe { instance.get_physical_device_memory_properties(handle) };
        let heap = memory.memory_heaps[..memory.memory_heap_count as usize]
            .iter()
            .filter(|h| h.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL))
            .map(|h| h.size)
            .max()
            .unwrap_or(0);
        // SAFETY: `handle` came from this instance.
        let families = unsafe { instance.get_physical_device_queue_family_properties(handle) };
        let queue_family =
            families.iter().position(|f| f.queue_flags.contains(vk::QueueFlags::COMPUTE)).map(|i| i as u32);
        let text =
            |s: Result<&CStr, _>| s.map(|s: &CStr| s.to_string_lossy().into_owned()).unwrap_or_default();
        Candidate {
            handle,
            properties: core,
            subgroup_size: subgroup.subgroup_size,
            shuffles: subgroup.supported_stages.contains(vk::ShaderStageFlags::COMPUTE)
                && subgroup.supported_operations.contains(vk::SubgroupFeatureFlags::SHUFFLE),
            measured: measured(driver.driver_id, core.device_type),
            driver: format!(
                "{} {}",
                text(driver.driver_name_as_c_str()),
                text(driver.driver_info_as_c_str())
            )
            // Names and versions come padded, or not at all.
            .split_whitespace()
            .collect::<Vec<_>>()
            .join(" "),
            uuid: ids.device_uuid,
            heap,
            allocation,
            queue_family,
            timestamp_bits: queue_family.map_or(0, |i| families[i as usize].timestamp_valid_bits),
            scalar_layout: scalar.scalar_block_layout == vk::TRUE,
            float64,
            name: text(core.device_name_as_c_str()),
        }
    }

    /// Gives hardware that is absent, and so has no memory, some to plan with.
    pub(super) fn suppose_memory(&mut self) {
        if self.heap == 0 {
            self.heap = SUPPOSED_HEAP;
        }
    }

    /// True if the driver tells what it makes of kernels.
    pub(super) fn explains_code(&self, instance: &ash::Instance) -> bool {
        // SAFETY: the handle came from this instance.
        let extensions = unsafe { instance.enumerate_device_extension_properties(self.handle) };
        let name = ash::khr::pipeline_executable_properties::NAME;
        let has = |e: &vk::ExtensionProperties| e.extension_name_as_c_str() == Ok(name);
        if !extensions.is_ok_and(|all| all.iter().any(has)) {
            return false;
        }
        let mut explained = vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default();
        let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut explained);
        // SAFETY: as above; the chain lives through the call.
        unsafe { instance.get_physical_device_features2(self.handle, &mut features) };
        explained.pipeline_executable_info == vk::TRUE
    }

    /// Why this device cannot be used, if so.
    pub(super) fn lacks(&self) -> Option<String> {
        let limits = &self.properties.limits;
        if self.properties.api_version < vk::API_VERSION_1_2 {
            Some("it has no Vulkan 1.2".into())
        } else if self.queue_family.is_none() {
            Some("it has no compute queue".into())
        } else if self.heap == 0 {
            Some("it has no memory".into())
        } else if !self.scalar_layout {
            Some("it does not support scalarBlockLayout".into())
        } else if limits.max_per_stage_descriptor_storage_buffers < STORAGE_BUFFERS_PER_STAGE {
            Some(format!(
                "it binds {} storage buffers at once, {STORAGE_BUFFERS_PER_STAGE} are needed",
                limits.max_per_stage_descriptor_storage_buffers
            ))
        } else {
            None
        }
    }

    pub(super) fn kind(&self) -> &'static str {
        match self.properties.device_type {
            vk::PhysicalDeviceType::CPU => "cpu",
            vk::PhysicalDeviceType::DISCRETE_GPU => "discrete",
            vk::PhysicalDeviceType::INTEGRATED_GPU => "integrated",
            vk::PhysicalDeviceType::VIRTUAL_GPU => "virtual",
            _ => "other",
        }
    }

    pub(super) fn api(&self) -> String {
        let v = self.properties.api_version;
        format!("{}.{}.{}", vk::api_version_major(v), vk::api_version_minor(v), vk::api_version_patch(v))
    }

    pub(super) fn limits(&self) -> Limits {
        let limits = &self.properties.limits;
        Limits {
            // No buffer is larger than an allocation.
            storage_range: u64::from(limits.max_storage_buffer_range).min(self.allocation),
            heap: self.heap,
            workgroup_invocations: limits
                .max_compute_work_group_invocations
                .min(limits.max_compute_work_group_size[0]),
            texel_elements: limits.max_texel_buffer_elements,
            shuffle_lanes: if self.shuffles { self.subgroup_size } else { 0 },
            storage_buffers: limits
                .max_per_stage_descriptor_storage_buffers
                .min(limits.max_descriptor_set_storage_buffers),
            driver: self.measured,
        }
    }
}

/// The measurements that hold for a driver.
fn measured(driver: vk::DriverId, device: vk::PhysicalDeviceType) -> Driver {
    match (driver, device) {
        (vk::DriverId::MESA_LLVMPIPE, _) => Driver::Lavapipe,
        (vk::DriverId::GOOGLE_SWIFTSHADER, _) => Driver::SwiftShader,
        (_, vk::PhysicalDeviceType::CPU) => Driver::OtherCpu,
        _ => Driver::Gpu,
    }
}

/// All physical devices, in the loader's order.
pub(super) fn candidates(instance: &Instance) -> Result<Vec<Candidate>, VkError> {
    // SAFETY: the instance is alive.
    let handles = unsafe { instance.raw.enumerate_physical_devices() }
        .map_err(call("vkEnumeratePhysicalDevices", "instance"))?;
    Ok(handles.into_iter().map(|h| Candidate::new(&instance.raw, h)).collect())
}

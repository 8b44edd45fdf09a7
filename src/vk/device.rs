//! Loader, instance, choice of device, features: all negotiation with the driver is here.

use super::debug::Messenger;
use super::error::{VkError, call};
use crate::cache_folder;
use crate::plan::Limits;
use crate::report::DeviceInfo;
use crate::settings::DeviceChoice;
use ash::vk;
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};
use std::ffi::{CStr, c_char};
use std::mem::ManuallyDrop;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

const VALIDATION_LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";
/// Storage buffers that a device must bind at once: those of the widest split kernel. The fused depth binds more, and
/// is used only where the device allows it.
const STORAGE_BUFFERS_PER_STAGE: u32 = 16;

/// How to get Vulkan where there is none.
pub(super) const INSTALL_HINT: &str = "install a Vulkan driver (Debian and Ubuntu: `apt-get install libvulkan1 mesa-vulkan-drivers` \
     brings the loader and the software device lavapipe)";

/// A loaded Vulkan instance.
pub(super) struct Instance {
    // Keeps the loader open.
    _entry: ash::Entry,
    pub(super) raw: ash::Instance,
    messenger: Option<Messenger>,
}

impl Instance {
    /// Loads Vulkan 1.2; with `validate`, under the validation layer with synchronisation validation.
    pub(super) fn new(validate: bool) -> Result<Instance, VkError> {
        // SAFETY: loads the system's Vulkan loader; its initialisers are trusted like any driver.
        let entry = unsafe { ash::Entry::load() }.map_err(VkError::NoLoader)?;
        let application =
            vk::ApplicationInfo::default().application_name(c"whitted").api_version(vk::API_VERSION_1_2);
        let mut layers: Vec<*const c_char> = Vec::new();
        let mut extensions: Vec<*const c_char> = Vec::new();
        if validate {
            // SAFETY: no preconditions beyond a loaded entry.
            let present = unsafe { entry.enumerate_instance_layer_properties() }
                .map_err(call("vkEnumerateInstanceLayerProperties", "loader"))?
                .iter()
                .any(|l| l.layer_name_as_c_str() == Ok(VALIDATION_LAYER));
            if !present {
                return Err(VkError::NoDevice(
                    "--validate needs the Khronos validation layer (Debian and Ubuntu: `apt-get install vulkan-validationlayers`)".into(),
                ));
            }
            layers.push(VALIDATION_LAYER.as_ptr());
            extensions.push(ash::ext::debug_utils::NAME.as_ptr());
        }
        let enabled = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
        let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
        let mut info = vk::InstanceCreateInfo::default()
            .application_info(&application)
            .enabled_layer_names(&layers)
            .enabled_extension_names(&extensions);
        if validate {
            info = info.push_next(&mut features);
        }
        // SAFETY: all pointers in `info` live through the call.
        let raw = unsafe { entry.create_instance(&info, None) }.map_err(|result| match result {
            vk::Result::ERROR_INCOMPATIBLE_DRIVER => {
                VkError::NoDevice(format!("the Vulkan loader found no driver: {INSTALL_HINT}"))
            }
            result => call("vkCreateInstance", "loader")(result),
        })?;
        let messenger = match validate.then(|| Messenger::new(&entry, &raw)).transpose() {
            Ok(messenger) => messenger,
            Err(error) => {
                // SAFETY: the instance has no children yet.
                unsafe { raw.destroy_instance(None) };
                return Err(error);
            }
        };
        Ok(Instance { _entry: entry, raw, messenger })
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        if let Some(messenger) = &self.messenger {
            messenger.destroy();
        }
        // SAFETY: the device, its only child, holds the instance and has been destroyed before.
        unsafe { self.raw.destroy_instance(None) };
    }
}

/// What a physical device is and can, as far as it matters here.
#[derive(Clone)]
pub(super) struct Candidate {
    pub(super) handle: vk::PhysicalDevice,
    pub(super) properties: vk::PhysicalDeviceProperties,
    pub(super) subgroup_size: u32,
    pub(super) shuffles: bool,
    pub(super) driver: String,
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

    /// Why this device cannot be used, if so.
    pub(super) fn lacks(&self) -> Option<String> {
        let limits = &self.properties.limits;
        if self.properties.api_version < vk::API_VERSION_1_2 {
            Some("it has no Vulkan 1.2".into())
        } else if self.queue_family.is_none() {
            Some("it has no compute queue".into())
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
            is_cpu: self.properties.device_type == vk::PhysicalDeviceType::CPU,
        }
    }
}

/// All physical devices, in the loader's order.
pub(super) fn candidates(instance: &Instance) -> Result<Vec<Candidate>, VkError> {
    // SAFETY: the instance is alive.
    let handles = unsafe { instance.raw.enumerate_physical_devices() }
        .map_err(call("vkEnumeratePhysicalDevices", "instance"))?;
    Ok(handles.into_iter().map(|h| Candidate::new(&instance.raw, h)).collect())
}

pub(super) fn choose(all: Vec<Candidate>, choice: &DeviceChoice) -> Result<Candidate, VkError> {
    if all.is_empty() {
        return Err(VkError::NoDevice(format!("Vulkan is here, but no device: {INSTALL_HINT}")));
    }
    let names =
        all.iter().enumerate().map(|(i, c)| format!("{i}: {}", c.name)).collect::<Vec<_>>().join("; ");
    let none = |what: String| VkError::NoDevice(format!("{what}; there are {names} (see `whitted devices`)"));
    let found = match choice {
        DeviceChoice::Best => {
            // Other devices may be numbered differently from run to run; types may not.
            let rank = |c: &Candidate| match c.kind() {
                "discrete" => 0,
                "integrated" => 1,
                "virtual" => 2,
                "cpu" => 3,
                _ => 4,
            };
            all.iter().filter(|c| c.lacks().is_none()).min_by_key(|c| rank(c)).cloned()
        }
        DeviceChoice::Index(i) => all.get(*i).cloned(),
        DeviceChoice::Cpu => all.iter().find(|c| c.kind() == "cpu").cloned(),
        DeviceChoice::Uuid(uuid) => all.iter().find(|c| c.uuid == *uuid).cloned(),
        DeviceChoice::Name(name) => {
            let name = name.to_lowercase();
            all.iter().find(|c| c.name.to_lowercase().contains(&name)).cloned()
        }
    };
    let found = found.ok_or_else(|| {
        none(match choice {
            DeviceChoice::Best => "no device can be used".into(),
            DeviceChoice::Index(i) => format!("there is no device {i}"),
            DeviceChoice::Cpu => "there is no software device".into(),
            DeviceChoice::Uuid(_) => "there is no device with that UUID".into(),
            DeviceChoice::Name(name) => format!("no device's name contains `{name}`"),
        })
    })?;
    match found.lacks() {
        Some(why) => Err(none(format!("`{}` cannot be used: {why}", found.name))),
        None => Ok(found),
    }
}

/// A logical device with one compute queue, an allocator and a pipeline cache.
pub struct Device {
    // Dropped by hand, in this order, before the device.
    allocator: ManuallyDrop<Mutex<Allocator>>,
    pub(super) raw: ash::Device,
    pub(super) queue: vk::Queue,
    pub(super) queue_family: u32,
    pub(super) cache: vk::PipelineCache,
    cache_file: Option<PathBuf>,
    pub(super) chosen: Candidate,
    instance: Instance,
}

impl Device {
    /// Opens the chosen device.
    pub fn new(choice: &DeviceChoice, validate: bool) -> Result<Device, VkError> {
        let instance = Instance::new(validate)?;
        let chosen = choose(candidates(&instance)?, choice)?;
        let queue_family = chosen.queue_family.ok_or_else(|| VkError::NoDevice("no compute queue".into()))?;
        let priorities = [1.0];
        let queues = [vk::DeviceQueueCreateInfo::default()
            .queue_family_index(queue_family)
            .queue_priorities(&priorities)];
        let mut scalar = vk::PhysicalDeviceScalarBlockLayoutFeatures::default().scalar_block_layout(true);
        let features = vk::PhysicalDeviceFeatures::default().shader_float64(chosen.float64);
        let info = vk::DeviceCreateInfo::default()
            .queue_create_infos(&queues)
            .enabled_features(&features)
            .push_next(&mut scalar);
        // SAFETY: the physical device came from this instance; `info` lives through the call.
        let raw = unsafe { instance.raw.create_device(chosen.handle, &info, None) }
            .map_err(call("vkCreateDevice", chosen.name.as_str()))?;
        // SAFETY: the family was asked for one queue just now.
        let queue = unsafe { raw.get_device_queue(queue_family, 0) };
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.raw.clone(),
            device: raw.clone(),
            physical_device: chosen.handle,
            debug_settings: gpu_allocator::AllocatorDebugSettings::default(),
            buffer_device_address: false,
            // Plans know their sizes: small blocks, since lavapipe's heap is 2 GiB.
            allocation_sizes: gpu_allocator::AllocationSizes::new(8 << 20, 8 << 20),
        });
        let allocator = match allocator {
            Ok(allocator) => ManuallyDrop::new(Mutex::new(allocator)),
            Err(source) => {
                // SAFETY: nothing was made from the device yet.
                unsafe { raw.destroy_device(None) };
                return Err(VkError::Memory { name: "allocator".into(), bytes: 0, source });
            }
        };
        let cache_file = cache_file(&chosen, "pipelines");
        let key = cache_key(&chosen);
        let stored = cache_file.as_ref().and_then(|f| cache_folder::read(f, &key)).unwrap_or_default();
        let mut device = Device {
            allocator,
            raw,
            queue,
            queue_family,
            cache: vk::PipelineCache::null(),
            cache_file,
            chosen,
            instance,
        };
        // SAFETY: the data is as this driver gave it, which its seal and its key confirm.
        device.cache = unsafe {
            device
                .raw
                .create_pipeline_cache(&vk::PipelineCacheCreateInfo::default().initial_data(&stored), None)
        }
        .map_err(call("vkCreatePipelineCache", "device"))?;
        Ok(device)
    }

    /// The memory allocator.
    pub(super) fn allocator(&self) -> MutexGuard<'_, Allocator> {
        self.allocator.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Debug labels, where the layer that reads them is on.
    pub(super) fn labels(&self) -> Option<ash::ext::debug_utils::Device> {
        let on = self.instance.messenger.is_some();
        on.then(|| ash::ext::debug_utils::Device::new(&self.instance.raw, &self.raw))
    }

    /// Limits that plans depend on.
    pub fn limits(&self) -> Limits {
        self.chosen.limits()
    }

    /// True if kernels may compute in f64.
    pub fn has_double(&self) -> bool {
        self.chosen.float64
    }

    /// Who it is.
    pub fn info(&self) -> DeviceInfo {
        DeviceInfo {
            name: self.chosen.name.clone(),
            kind: self.chosen.kind().into(),
            driver: self.chosen.driver.clone(),
            api: self.chosen.api(),
        }
    }

    /// Warnings and errors of the validation layer so far; empty without `validate`.
    pub fn validation_messages(&self) -> Vec<String> {
        self.instance.messenger.as_ref().map(Messenger::messages).unwrap_or_default()
    }

    /// A file of the user's cache folder for facts about this device and driver, by kind.
    pub fn cache_file(&self, kind: &str) -> Option<PathBuf> {
        cache_file(&self.chosen, kind)
    }

    /// Keeps compiled pipelines for the next process. Failing to is no failure of the render.
    pub fn store_pipeline_cache(&self) {
        let Some(file) = &self.cache_file else { return };
        // SAFETY: the cache belongs to this device.
        let Ok(data) = (unsafe { self.raw.get_pipeline_cache_data(self.cache) }) else { return };
        cache_folder::write(file, &cache_key(&self.chosen), &data);
    }
}

/// `KIND-UUID-VERSION` in the cache folder. Some drivers keep one UUID for ever, so the driver's version is
/// part of the name as well.
fn cache_file(chosen: &Candidate, kind: &str) -> Option<PathBuf> {
    let folder = cache_folder::path()?;
    let uuid: String = chosen.properties.pipeline_cache_uuid.iter().map(|b| format!("{b:02x}")).collect();
    Some(folder.join(format!(
        "{kind}-{uuid}-{:x}-{}",
        chosen.properties.driver_version,
        env!("CARGO_PKG_VERSION")
    )))
}

/// What compiled pipelines belong to: device and driver.
fn cache_key(chosen: &Candidate) -> Vec<u8> {
    let p = &chosen.properties;
    let numbers = [p.vendor_id, p.device_id, p.driver_version, p.api_version];
    [&p.pipeline_cache_uuid[..], bytemuck::bytes_of(&numbers)].concat()
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: everything made from the device borrows it, so all of it is gone; the allocator
        // goes first, as its blocks belong to the device.
        unsafe { ManuallyDrop::drop(&mut self.allocator) };
        // SAFETY: as above; a null cache is allowed.
        unsafe { self.raw.destroy_pipeline_cache(self.cache, None) };
        // SAFETY: as above.
        unsafe { self.raw.destroy_device(None) };
    }
}

//! A device that is open: queue, allocator, pipeline cache.

use super::candidate::{Candidate, candidates};
use super::choice::choose;
use super::debug::Messenger;
use super::error::{VkError, call};
use super::instance::Instance;
use super::watch::is_abandoned;
use crate::host::cache_folder;
use crate::plan::Limits;
use crate::report::DeviceInfo;
use crate::settings::DeviceChoice;
use ash::khr::pipeline_executable_properties;
use ash::vk;
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};
use std::ffi::c_char;
use std::mem::ManuallyDrop;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

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
    /// The driver's answers about compiled kernels, where they were asked for.
    pub(super) executables: Option<pipeline_executable_properties::Device>,
    instance: Instance,
}

impl Device {
    /// Opens the chosen device.
    pub fn new(choice: &DeviceChoice, validate: bool) -> Result<Device, VkError> {
        Device::open(choice, validate, false)
    }

    /// Opens the chosen device to ask what its driver compiles ([`super::Pipelines::executables`]), not to run it: the
    /// hardware may be absent.
    pub fn inspecting(choice: &DeviceChoice) -> Result<Device, VkError> {
        Device::open(choice, false, true)
    }

    fn open(choice: &DeviceChoice, validate: bool, inspects: bool) -> Result<Device, VkError> {
        let instance = Instance::new(validate)?;
        let mut all = candidates(&instance)?;
        if inspects {
            all.iter_mut().for_each(Candidate::suppose_memory);
        }
        let chosen = choose(&all, choice, &instance.notes)?;
        let extensions: &[*const c_char] =
            if inspects { &[pipeline_executable_properties::NAME.as_ptr()] } else { &[] };
        if inspects && !chosen.explains_code(&instance.raw) {
            return Err(VkError::NoDevice(format!(
                "the driver of `{}` ({}) does not tell what it compiles: it has no VK_KHR_pipeline_executable_properties",
                chosen.name, chosen.driver
            )));
        }
        let queue_family = chosen.queue_family.ok_or_else(|| VkError::NoDevice("no compute queue".into()))?;
        let priorities = [1.0];
        let queues = [vk::DeviceQueueCreateInfo::default()
            .queue_family_index(queue_family)
            .queue_priorities(&priorities)];
        let mut scalar = vk::PhysicalDeviceScalarBlockLayoutFeatures::default().scalar_block_layout(true);
        let features = vk::PhysicalDeviceFeatures::default().shader_float64(chosen.float64);
        let mut explained = vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default()
            .pipeline_executable_info(true);
        let mut info = vk::DeviceCreateInfo::default()
            .enabled_extension_names(extensions)
            .queue_create_infos(&queues)
            .enabled_features(&features)
            .push_next(&mut scalar);
        if inspects {
            info = info.push_next(&mut explained);
        }
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
        // Code from a cache may come without what is to be told of it.
        let cache_file = if inspects { None } else { cache_file(&chosen, "pipelines") };
        let key = cache_key(&chosen);
        let stored = cache_file.as_ref().and_then(|f| cache_folder::read(f, &key)).unwrap_or_default();
        let executables = inspects.then(|| pipeline_executable_properties::Device::new(&instance.raw, &raw));
        let mut device = Device {
            allocator,
            raw,
            queue,
            queue_family,
            cache: vk::PipelineCache::null(),
            cache_file,
            chosen,
            executables,
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

    /// What the user should know of this machine's drivers.
    pub fn notes(&self) -> &[String] {
        &self.instance.notes
    }

    /// Keeps compiled pipelines for the next process. Failing to is no failure of the render.
    pub fn store_pipeline_cache(&self) {
        let Some(file) = &self.cache_file else { return };
        // SAFETY: the cache belongs to this device.
        let Ok(data) = (unsafe { self.raw.get_pipeline_cache_data(self.cache) }) else { return };
        cache_folder::write(file, &cache_key(&self.chosen), &data);
    }
}

/// `KIND-UUID-VERSION-LANES-PROGRAM` in the cache folder. Some drivers keep one UUID for ever, so the driver's version is
/// part of the name as well; some compile for vectors of a width that the environment sets.
fn cache_file(chosen: &Candidate, kind: &str) -> Option<PathBuf> {
    let folder = cache_folder::path()?;
    let uuid: String = chosen.properties.pipeline_cache_uuid.iter().map(|b| format!("{b:02x}")).collect();
    Some(folder.join(format!(
        "{kind}-{uuid}-{:x}-{}-{}",
        chosen.properties.driver_version,
        chosen.subgroup_size,
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
        if is_abandoned() {
            return;
        }
        // SAFETY: everything made from the device borrows it, so all of it is gone; the allocator
        // goes first, as its blocks belong to the device.
        unsafe { ManuallyDrop::drop(&mut self.allocator) };
        // SAFETY: as above; a null cache is allowed.
        unsafe { self.raw.destroy_pipeline_cache(self.cache, None) };
        // SAFETY: as above.
        unsafe { self.raw.destroy_device(None) };
    }
}

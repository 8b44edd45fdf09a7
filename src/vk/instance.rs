//! Loader and instance.

use super::debug::Messenger;
use super::environment;
use super::error::{VkError, call};
use super::watch::is_abandoned;
use crate::host::memory;
use ash::vk;
use std::ffi::{CStr, c_char};

const VALIDATION_LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";
/// How to get Vulkan where there is none.
pub(super) const INSTALL_HINT: &str = "install a Vulkan driver (Debian and Ubuntu: `apt-get install libvulkan1 mesa-vulkan-drivers` \
     brings the loader and the software device lavapipe)";

/// Address space without which no driver is loaded, bytes. A driver maps libraries and stacks of some hundred MiB: lavapipe
/// starts with 1 GiB. With 0.15 to 0.7 GiB it fails, with 0.1 it may end the process.
const LEAST_ADDRESS_SPACE: u64 = 256 << 20;

/// A loaded Vulkan instance.
pub(super) struct Instance {
    // Keeps the loader open.
    _entry: ash::Entry,
    pub(super) raw: ash::Instance,
    pub(super) messenger: Option<Messenger>,
    /// What the user should know of drivers that are not there.
    pub(super) notes: Vec<String>,
}

impl Instance {
    /// Loads Vulkan 1.2; with `validate`, under the validation layer with synchronisation validation.
    pub(super) fn new(validate: bool) -> Result<Instance, VkError> {
        environment::prepare();
        let notes = environment::notes().to_vec();
        if let Some(left) = memory::address_space().filter(|left| *left < LEAST_ADDRESS_SPACE) {
            return Err(VkError::NoDevice(format!(
                "no driver can be loaded: the limits of this process leave {} MiB of address space and data, a driver takes 1 GiB (`ulimit -v`, `ulimit -d`)",
                left >> 20
            )));
        }
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
            // Files that are no drivers may be the reason.
            result if result == vk::Result::ERROR_INCOMPATIBLE_DRIVER || !notes.is_empty() => {
                let also = notes.iter().map(|note| format!("\n  {note}")).collect::<String>();
                VkError::NoDevice(format!(
                    "the Vulkan loader found no driver ({result}): {INSTALL_HINT}; with VK_LOADER_DEBUG=error,warn set it says more{also}"
                ))
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
        Ok(Instance { _entry: entry, raw, messenger, notes })
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        if is_abandoned() {
            return;
        }
        if let Some(messenger) = &self.messenger {
            messenger.destroy();
        }
        // SAFETY: the device, its only child, holds the instance and has been destroyed before.
        unsafe { self.raw.destroy_instance(None) };
    }
}

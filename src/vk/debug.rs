//! Validation messages: counted and kept, never printed from the callback, which must not panic.

use super::error::{VkError, call};
use ash::vk;
use std::borrow::Cow;
use std::ffi::{CStr, c_void};
use std::sync::{Mutex, PoisonError};

/// Messages of this process's instance.
#[derive(Debug, Default)]
pub(super) struct Messages(Mutex<Vec<String>>);

impl Messages {
    pub(super) fn all(&self) -> Vec<String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn push(&self, message: String) {
        let mut list = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        // A broken render repeats one message per dispatch; the first hundred tell all.
        if list.len() < 100 {
            list.push(message);
        }
    }
}

/// The messenger and the messages it writes to; dropped after the instance's children.
pub(super) struct Messenger {
    loader: ash::ext::debug_utils::Instance,
    handle: vk::DebugUtilsMessengerEXT,
    messages: Box<Messages>,
}

unsafe extern "system" fn on_message(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user: *mut c_void,
) -> vk::Bool32 {
    if !data.is_null() && !user.is_null() {
        // SAFETY: the loader hands over a valid callback struct for the time of this call.
        let message = unsafe { (*data).p_message };
        if !message.is_null() {
            // SAFETY: p_message is a NUL-terminated string owned by the layer.
            let text: Cow<'_, str> = unsafe { CStr::from_ptr(message) }.to_string_lossy();
            // SAFETY: `user` is the boxed Messages, which outlives the messenger that holds it.
            unsafe { &*user.cast::<Messages>() }.push(text.into_owned());
        }
    }
    vk::FALSE
}

impl Messenger {
    /// Listens to warnings and errors.
    pub(super) fn new(entry: &ash::Entry, instance: &ash::Instance) -> Result<Messenger, VkError> {
        let messages = Box::<Messages>::default();
        let loader = ash::ext::debug_utils::Instance::new(entry, instance);
        let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(
                vk::DebugUtilsMessageSeverityFlagsEXT::WARNING | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR,
            )
            .message_type(vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION)
            .pfn_user_callback(Some(on_message))
            .user_data(std::ptr::from_ref::<Messages>(&messages).cast_mut().cast());
        // SAFETY: the create info lives through the call; `messages` is boxed, so its address stays.
        let handle = unsafe { loader.create_debug_utils_messenger(&info, None) }
            .map_err(call("vkCreateDebugUtilsMessengerEXT", "instance"))?;
        Ok(Messenger { loader, handle, messages })
    }

    pub(super) fn messages(&self) -> Vec<String> {
        self.messages.all()
    }

    /// Stops listening. Call before the instance goes.
    pub(super) fn destroy(&self) {
        // SAFETY: called once, from Device's drop, while the instance is alive.
        unsafe { self.loader.destroy_debug_utils_messenger(self.handle, None) };
    }
}

//! What a driver says of the code that it compiled (VK_KHR_pipeline_executable_properties).

use super::error::{VkError, call};
use super::kernel::Pipelines;
use crate::kernel::table::Kernel;
use crate::report::compiled::{Executable, Figure, Text, Value};
use ash::vk;
use std::ffi::{CStr, c_char};

/// The name in a fixed array of characters.
fn text(chars: &[c_char]) -> String {
    let bytes: Vec<u8> = chars.iter().map(|c| *c as u8).collect();
    CStr::from_bytes_until_nul(&bytes).map_or_else(|_| String::new(), |s| s.to_string_lossy().into_owned())
}

impl Pipelines {
    /// What the driver says of `kernel`, with its texts (intermediate code, machine code) if `texts`. The device is
    /// opened by [`super::Device::inspecting`].
    pub fn executables(&self, kernel: Kernel, texts: bool) -> Result<Vec<Executable>, VkError> {
        let Some(asked) = &self.device().executables else { return Ok(Vec::new()) };
        let pipeline = self.get(kernel).handle;
        let info = vk::PipelineInfoKHR::default().pipeline(pipeline);
        // SAFETY: the pipeline is alive, and was built to be asked.
        let found = unsafe { asked.get_pipeline_executable_properties(&info) }
            .map_err(call("vkGetPipelineExecutablePropertiesKHR", kernel.name()))?;
        let mut all = Vec::new();
        for (index, properties) in found.iter().enumerate() {
            let info =
                vk::PipelineExecutableInfoKHR::default().pipeline(pipeline).executable_index(index as u32);
            // SAFETY: as above; the index is one of those found.
            let figures = unsafe { asked.get_pipeline_executable_statistics(&info) }
                .map_err(call("vkGetPipelineExecutableStatisticsKHR", kernel.name()))?;
            all.push(Executable {
                name: text(&properties.name),
                subgroup: properties.subgroup_size,
                figures: figures.iter().filter_map(figure).collect(),
                texts: if texts { self.texts(kernel, &info)? } else { Vec::new() },
            });
        }
        Ok(all)
    }

    fn texts(&self, kernel: Kernel, info: &vk::PipelineExecutableInfoKHR<'_>) -> Result<Vec<Text>, VkError> {
        let Some(asked) = &self.device().executables else { return Ok(Vec::new()) };
        let what = "vkGetPipelineExecutableInternalRepresentationsKHR";
        // SAFETY: the pipeline is alive; without room the driver only tells the sizes.
        let mut found = unsafe { asked.get_pipeline_executable_internal_representations(info) }
            .map_err(call(what, kernel.name()))?;
        let mut rooms: Vec<Vec<u8>> = found.iter().map(|f| vec![0; f.data_size]).collect();
        for (found, room) in found.iter_mut().zip(&mut rooms) {
            found.p_data = room.as_mut_ptr().cast();
        }
        let mut count = found.len() as u32;
        let get = asked.fp().get_pipeline_executable_internal_representations_khr;
        // SAFETY: `found` has `count` entries, each with as many bytes of room as it says.
        unsafe { get(asked.device(), info, &mut count, found.as_mut_ptr()) }
            .result()
            .map_err(call(what, kernel.name()))?;
        let texts = found.iter().zip(rooms).filter(|(found, _)| found.is_text == vk::TRUE);
        Ok(texts
            .map(|(found, room)| Text {
                name: text(&found.name),
                // Ends in NUL.
                text: String::from_utf8_lossy(&room).trim_end_matches('\0').into(),
            })
            .collect())
    }
}

/// A statistic; `None` if it is of no kind that there is.
fn figure(of: &vk::PipelineExecutableStatisticKHR<'_>) -> Option<Figure> {
    type Format = vk::PipelineExecutableStatisticFormatKHR;
    // SAFETY: the driver has set the member that the format names.
    let value = unsafe {
        match of.format {
            Format::BOOL32 => Value::Truth(of.value.b32 == vk::TRUE),
            Format::INT64 => Value::Signed(of.value.i64),
            Format::UINT64 => Value::Whole(of.value.u64),
            Format::FLOAT64 => Value::Real(of.value.f64),
            _ => return None,
        }
    };
    Some(Figure { name: text(&of.name), meaning: text(&of.description), value })
}

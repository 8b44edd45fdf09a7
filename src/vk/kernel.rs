//! Pipelines: every kernel of the pass table under one specialisation, with its layouts.

use super::device::Device;
use super::error::{VkError, call};
use super::watch::{self, Wait};
use crate::kernel::abi::{BUFFERS, Push, Specialisation, TEXELS_AT};
use crate::kernel::table::{Kernel, KernelCode, KernelSet};
use ash::vk;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::mpsc::{self, RecvTimeoutError};

/// One kernel, ready to bind.
#[derive(Clone, Copy)]
pub(super) struct Pipeline {
    pub(super) handle: vk::Pipeline,
    pub(super) layout: vk::PipelineLayout,
    pub(super) set_layout: vk::DescriptorSetLayout,
}

/// Kernels under one specialisation.
pub struct Pipelines {
    device: Rc<Device>,
    pipelines: BTreeMap<Kernel, Pipeline>,
    set: KernelSet,
    double: bool,
}

/// Buffers a kernel touches, in binding order.
pub(super) fn bound(kernel: Kernel) -> impl Iterator<Item = crate::kernel::abi::Buf> {
    let used = kernel.code().reads | kernel.code().writes;
    BUFFERS.iter().map(|(_, _, b)| *b).filter(move |b| used >> *b as u32 & 1 == 1)
}

/// Buffers a kernel may also read as texels, in binding order; none in double precision.
pub(super) fn viewed(code: &KernelCode, double: bool) -> impl Iterator<Item = crate::kernel::abi::Buf> {
    let used = if double { 0 } else { code.texels };
    BUFFERS.iter().map(|(_, _, b)| *b).filter(move |b| used >> *b as u32 & 1 == 1)
}

impl Pipelines {
    /// Builds a pipeline for each of `kernels`, compiled as in `set`; `double` needs a device with double precision.
    pub fn new(
        device: &Rc<Device>,
        set: KernelSet,
        kernels: impl Iterator<Item = Kernel>,
        specialisation: &Specialisation,
        double: bool,
    ) -> Result<Pipelines, VkError> {
        let mut all = Pipelines { device: Rc::clone(device), pipelines: BTreeMap::new(), set, double };
        let form = match (double, specialisation.lanes != 0) {
            (true, _) => Form::Double,
            (false, true) => Form::Packet,
            (false, false) => Form::Single,
        };
        let maker = Maker {
            raw: device.raw.clone(),
            cache: device.cache,
            values: set.values(specialisation),
            form,
            asked: device.executables.is_some(),
        };
        // Drivers take long over a kernel, and each is on its own.
        let mut kernels: Vec<Kernel> = kernels.collect();
        kernels.sort_by_key(|k| std::cmp::Reverse(k.code().single.0.len()));
        let (sender, receiver) = mpsc::channel();
        rayon::spawn(move || {
            kernels.into_par_iter().with_max_len(1).for_each_with(sender, |sender, kernel| {
                // Nobody listens any more where the user has interrupted.
                let _ = sender.send((kernel, None));
                let _ = sender.send((kernel, Some(maker.build(set.code(kernel)))));
            });
        });
        all.receive(&receiver)?;
        device.store_pipeline_cache();
        Ok(all)
    }

    /// Waits for all pipelines that are built.
    fn receive(&mut self, built: &mpsc::Receiver<News>) -> Result<(), VkError> {
        let (mut wait, mut under_way, mut failed) = (Wait::new(), Vec::<Kernel>::new(), None);
        loop {
            match built.recv_timeout(watch::LOOK) {
                Ok((kernel, None)) => under_way.push(kernel),
                Ok((kernel, Some(result))) => {
                    under_way.retain(|k| *k != kernel);
                    match result {
                        Ok(pipeline) => drop(self.pipelines.insert(kernel, pipeline)),
                        Err(error) => failed = Some(error),
                    }
                }
                Err(RecvTimeoutError::Disconnected) => return failed.map_or(Ok(()), Err),
                Err(RecvTimeoutError::Timeout) => {}
            }
            if !wait.goes_on(|| compiling(&under_way)) {
                return Err(VkError::Interrupted { at: compiling(&under_way) });
            }
        }
    }

    /// The set that they were built from.
    pub fn set(&self) -> &KernelSet {
        &self.set
    }

    pub(super) fn device(&self) -> &Device {
        &self.device
    }

    /// Whether they compute in double precision.
    pub fn double(&self) -> bool {
        self.double
    }

    pub(super) fn kernels(&self) -> impl Iterator<Item = (Kernel, Pipeline)> {
        self.pipelines.iter().map(|(k, p)| (*k, *p))
    }

    pub(super) fn get(&self, kernel: Kernel) -> Pipeline {
        *self.pipelines.get(&kernel).expect("a recorder is used with the pipelines it was made for")
    }
}

/// A kernel that is begun, or what became of it.
type News = (Kernel, Option<Result<Pipeline, VkError>>);

fn compiling(kernels: &[Kernel]) -> String {
    let names: Vec<String> = kernels.iter().map(|k| format!("`{}`", k.name())).collect();
    format!("compiling {}", names.join(" and "))
}

/// Which of a kernel's compiled forms.
#[derive(Debug, Clone, Copy)]
enum Form {
    Single,
    Double,
    Packet,
}

/// What a pipeline is made of, apart from its kernel; shared by threads (a pipeline cache may be).
struct Maker {
    raw: ash::Device,
    cache: vk::PipelineCache,
    values: Vec<(u32, u32)>,
    form: Form,
    /// The driver will be asked what it made.
    asked: bool,
}

impl Maker {
    fn build(&self, code: &KernelCode) -> Result<Pipeline, VkError> {
        let used = code.reads | code.writes;
        let storage = (0..BUFFERS.len() as u32).filter(|b| used >> b & 1 == 1).map(|b| {
            vk::DescriptorSetLayoutBinding::default()
                .binding(b)
                .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
                .descriptor_count(1)
                .stage_flags(vk::ShaderStageFlags::COMPUTE)
        });
        let texels = viewed(code, matches!(self.form, Form::Double)).map(|buffer| {
            vk::DescriptorSetLayoutBinding::default()
                .binding(TEXELS_AT + buffer as u32)
                .descriptor_type(vk::DescriptorType::UNIFORM_TEXEL_BUFFER)
                .descriptor_count(1)
                .stage_flags(vk::ShaderStageFlags::COMPUTE)
        });
        let bindings: Vec<_> = storage.chain(texels).collect();
        let mut made = Pipeline {
            handle: vk::Pipeline::null(),
            layout: vk::PipelineLayout::null(),
            set_layout: vk::DescriptorSetLayout::null(),
        };
        let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
        // SAFETY: `info` lives through the call.
        made.set_layout = unsafe { self.raw.create_descriptor_set_layout(&info, None) }
            .map_err(call("vkCreateDescriptorSetLayout", code.name))?;
        let result = self.finish(code, &mut made);
        if let Err(error) = result {
            destroy(&self.raw, &made);
            return Err(error);
        }
        Ok(made)
    }

    fn finish(&self, code: &KernelCode, made: &mut Pipeline) -> Result<(), VkError> {
        let sets = [made.set_layout];
        let pushes = [vk::PushConstantRange::default()
            .stage_flags(vk::ShaderStageFlags::COMPUTE)
            .size(size_of::<Push>() as u32)];
        let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&sets).push_constant_ranges(&pushes);
        // SAFETY: `info` lives through the call.
        made.layout = unsafe { self.raw.create_pipeline_layout(&info, None) }
            .map_err(call("vkCreatePipelineLayout", code.name))?;
        let words = match self.form {
            Form::Single => code.single,
            Form::Double => code.double,
            Form::Packet => code.packet,
        }
        .words();
        let info = vk::ShaderModuleCreateInfo::default().code(&words);
        // SAFETY: the module was compiled and checked at build time.
        let module = unsafe { self.raw.create_shader_module(&info, None) }
            .map_err(call("vkCreateShaderModule", code.name))?;
        let entries: Vec<_> = (self.values.iter().enumerate())
            .map(|(i, (id, _))| {
                vk::SpecializationMapEntry::default().constant_id(*id).offset(4 * i as u32).size(4)
            })
            .collect();
        let values: Vec<u32> = self.values.iter().map(|(_, value)| *value).collect();
        let specialisation =
            vk::SpecializationInfo::default().map_entries(&entries).data(bytemuck::cast_slice(&values));
        let stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(module)
            .name(c"main")
            .specialization_info(&specialisation);
        let mut flags = vk::PipelineCreateFlags::empty();
        if self.asked {
            flags |= vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR
                | vk::PipelineCreateFlags::CAPTURE_INTERNAL_REPRESENTATIONS_KHR;
        }
        let infos = [vk::ComputePipelineCreateInfo::default().flags(flags).stage(stage).layout(made.layout)];
        // SAFETY: all handles are this device's; the chain lives through the call.
        let built = unsafe { self.raw.create_compute_pipelines(self.cache, &infos, None) };
        // SAFETY: a pipeline does not need its module once built.
        unsafe { self.raw.destroy_shader_module(module, None) };
        made.handle = built.map_err(|(_, result)| call("vkCreateComputePipelines", code.name)(result))?[0];
        Ok(())
    }
}

fn destroy(raw: &ash::Device, pipeline: &Pipeline) {
    // SAFETY: the recorder waits for its submits, so no command uses these any more; null is allowed.
    unsafe { raw.destroy_pipeline(pipeline.handle, None) };
    // SAFETY: as above.
    unsafe { raw.destroy_pipeline_layout(pipeline.layout, None) };
    // SAFETY: as above.
    unsafe { raw.destroy_descriptor_set_layout(pipeline.set_layout, None) };
}

impl Drop for Pipelines {
    fn drop(&mut self) {
        if watch::is_abandoned() {
            return;
        }
        for pipeline in self.pipelines.values() {
            destroy(&self.device.raw, pipeline);
        }
    }
}

//! One submit: commands in order, every dispatch between two timestamps with a barrier closing it.

use super::buffer::{Buffers, Made};
use super::device::Device;
use super::error::{VkError, call};
use super::kernel::{Pipelines, bound, viewed};
use super::watch::{self, Wait};
use crate::kernel::abi::{BUFFERS, Buf, GROUPS_PER_ROW, Push, TEXELS_AT};
use crate::kernel::table::{KERNELS, Kernel};
use crate::plan::passes::{Pass, Size, at_depth};
use ash::vk;
use std::collections::BTreeMap;
use std::rc::Rc;
use std::time::Instant;

/// Dispatches of one submit that have a timestamp each, and one to begin with. A submit of one batch at
/// a great depth may have more: those beyond share the rest of its time.
pub const DISPATCHES_MAX: usize = 4095;
/// Words that one vkCmdUpdateBuffer takes at most: 64 KiB.
const UPDATE_WORDS: usize = 16_384;

/// One dispatch of a pass.
#[derive(Debug, Clone, Copy)]
pub struct Dispatch {
    /// Row of the pass table.
    pub pass: &'static Pass,
    /// Depth of the rays, from 1; 0 outside the per-depth loop.
    pub depth: u32,
    /// Its push constants.
    pub push: Push,
    /// Items, where the host knows them.
    pub items: u32,
}

/// A dispatch and its device time.
#[derive(Debug, Clone, Copy)]
pub struct Timed {
    /// What ran.
    pub kernel: Kernel,
    /// At which depth.
    pub depth: u32,
    /// Device seconds from the recorder's first timestamp to the end of the dispatch before it (of the
    /// first in a submit: to its own start); None without a timestamp of its own.
    pub begin: Option<f64>,
    /// Seconds from the end of the one before it to its own closing barrier.
    pub seconds: f64,
}

/// Records and submits; reused from submit to submit.
pub struct Recorder {
    device: Rc<Device>,
    pool: vk::CommandPool,
    commands: vk::CommandBuffer,
    fence: vk::Fence,
    queries: vk::QueryPool,
    descriptors: vk::DescriptorPool,
    /// Sets by kernel, for odd and even depths.
    sets: BTreeMap<Kernel, [vk::DescriptorSet; 2]>,
    labels: Option<ash::ext::debug_utils::Device>,
    workgroup: u32,
    recorded: Vec<(Kernel, u32)>,
    /// True once a submit has ended: its kernels are compiled, as they may be at the first dispatch alone.
    ran: bool,
    /// The first timestamp of all.
    epoch: Option<u64>,
    /// Before the last submit and after its fence.
    submitted: Option<[Instant; 2]>,
}

/// That a buffer has room for what is to be written to it: the device would write past its end.
fn fits(buffers: &Buffers, buffer: Buf, bytes: usize) -> Result<(), VkError> {
    let room = buffers.bytes(buffer);
    match bytes as u64 {
        bytes if bytes > room => {
            Err(VkError::TooLong { name: BUFFERS[buffer as usize].0.into(), bytes, room })
        }
        _ => Ok(()),
    }
}

impl Recorder {
    /// A recorder for `pipelines` on `buffers`.
    pub fn new(
        device: &Rc<Device>,
        pipelines: &Pipelines,
        buffers: &Buffers,
        workgroup: u32,
    ) -> Result<Recorder, VkError> {
        let mut recorder = Recorder {
            device: Rc::clone(device),
            pool: vk::CommandPool::null(),
            commands: vk::CommandBuffer::null(),
            fence: vk::Fence::null(),
            queries: vk::QueryPool::null(),
            descriptors: vk::DescriptorPool::null(),
            sets: BTreeMap::new(),
            labels: device.labels(),
            workgroup,
            recorded: Vec::new(),
            ran: false,
            epoch: None,
            submitted: None,
        };
        recorder.create(pipelines, buffers)?;
        Ok(recorder)
    }

    fn create(&mut self, pipelines: &Pipelines, buffers: &Buffers) -> Result<(), VkError> {
        let raw = &self.device.raw;
        let info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(self.device.queue_family)
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER);
        // SAFETY: `info` lives through the call; the family is the device's.
        self.pool =
            unsafe { raw.create_command_pool(&info, None) }.map_err(call("vkCreateCommandPool", "frame"))?;
        let info = vk::CommandBufferAllocateInfo::default().command_pool(self.pool).command_buffer_count(1);
        // SAFETY: the pool was made just now.
        self.commands = unsafe { raw.allocate_command_buffers(&info) }
            .map_err(call("vkAllocateCommandBuffers", "frame"))?[0];
        // SAFETY: no preconditions.
        self.fence = unsafe { raw.create_fence(&vk::FenceCreateInfo::default(), None) }
            .map_err(call("vkCreateFence", "frame"))?;
        if self.device.chosen.timestamp_bits > 0 {
            let info = vk::QueryPoolCreateInfo::default()
                .query_type(vk::QueryType::TIMESTAMP)
                .query_count(DISPATCHES_MAX as u32 + 1);
            // SAFETY: `info` lives through the call.
            self.queries = unsafe { raw.create_query_pool(&info, None) }
                .map_err(call("vkCreateQueryPool", "timestamps"))?;
        }
        let per_parity: usize = KERNELS.iter().map(|k| (k.reads | k.writes).count_ones() as usize).sum();
        let views: usize = KERNELS.iter().map(|k| k.texels.count_ones() as usize).sum();
        let size = |ty, count: usize| vk::DescriptorPoolSize { ty, descriptor_count: 2 * count as u32 };
        let sizes = [
            size(vk::DescriptorType::STORAGE_BUFFER, per_parity),
            size(vk::DescriptorType::UNIFORM_TEXEL_BUFFER, views),
        ];
        let info =
            vk::DescriptorPoolCreateInfo::default().max_sets(2 * KERNELS.len() as u32).pool_sizes(&sizes);
        // SAFETY: `info` lives through the call.
        self.descriptors = unsafe { raw.create_descriptor_pool(&info, None) }
            .map_err(call("vkCreateDescriptorPool", "frame"))?;
        for (kernel, pipeline) in pipelines.kernels() {
            let layouts = [pipeline.set_layout; 2];
            let info = vk::DescriptorSetAllocateInfo::default()
                .descriptor_pool(self.descriptors)
                .set_layouts(&layouts);
            // SAFETY: the pool was sized for all of them.
            let sets = unsafe { raw.allocate_descriptor_sets(&info) }
                .map_err(call("vkAllocateDescriptorSets", kernel.name()))?;
            self.sets.insert(kernel, [sets[0], sets[1]]);
            for (parity, set) in sets.iter().enumerate() {
                for buffer in bound(kernel) {
                    let target = at_depth(buffer, parity as u32 + 1);
                    let range = [vk::DescriptorBufferInfo {
                        buffer: buffers.handle(target),
                        offset: 0,
                        // What is longer is read as texels alone (`plan`).
                        range: buffers.bytes(target).min(self.device.limits().storage_range),
                    }];
                    let write = [vk::WriteDescriptorSet::default()
                        .dst_set(*set)
                        .dst_binding(buffer as u32)
                        .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
                        .buffer_info(&range)];
                    // SAFETY: set and buffer are alive and not in use.
                    unsafe { raw.update_descriptor_sets(&write, &[]) };
                }
                for buffer in viewed(kernel.code(), pipelines.double()) {
                    let view = [buffers.view(at_depth(buffer, parity as u32 + 1))];
                    let write = [vk::WriteDescriptorSet::default()
                        .dst_set(*set)
                        .dst_binding(TEXELS_AT + buffer as u32)
                        .descriptor_type(vk::DescriptorType::UNIFORM_TEXEL_BUFFER)
                        .texel_buffer_view(&view)];
                    // SAFETY: set and view are alive and not in use.
                    unsafe { raw.update_descriptor_sets(&write, &[]) };
                }
            }
        }
        Ok(())
    }

    /// The same for buffers that have been made longer since; its times go on from the same beginning.
    pub fn renewed(&self, pipelines: &Pipelines, buffers: &Buffers) -> Result<Recorder, VkError> {
        let mut recorder = Recorder::new(&self.device, pipelines, buffers, self.workgroup)?;
        recorder.epoch = self.epoch;
        Ok(recorder)
    }

    /// Begins a submit.
    pub fn begin(&mut self) -> Result<(), VkError> {
        self.recorded.clear();
        let raw = &self.device.raw;
        let info = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the last submit was waited for.
        unsafe { raw.begin_command_buffer(self.commands, &info) }
            .map_err(call("vkBeginCommandBuffer", "frame"))?;
        if self.queries != vk::QueryPool::null() {
            // SAFETY: recording; all queries are in range and unused.
            unsafe { raw.cmd_reset_query_pool(self.commands, self.queries, 0, DISPATCHES_MAX as u32 + 1) };
        }
        Ok(())
    }

    /// Makes it so that all writes by earlier shaders and copies finish and can be read by later
    /// shaders, copies, indirect dispatches and the host.
    fn barrier(&self) {
        let stages = vk::PipelineStageFlags::COMPUTE_SHADER | vk::PipelineStageFlags::TRANSFER;
        let written = vk::AccessFlags::SHADER_WRITE | vk::AccessFlags::TRANSFER_WRITE;
        let used = written
            | vk::AccessFlags::SHADER_READ
            | vk::AccessFlags::TRANSFER_READ
            | vk::AccessFlags::INDIRECT_COMMAND_READ
            | vk::AccessFlags::HOST_READ;
        let barrier = [vk::MemoryBarrier::default().src_access_mask(written).dst_access_mask(used)];
        let to = stages | vk::PipelineStageFlags::DRAW_INDIRECT | vk::PipelineStageFlags::HOST;
        // SAFETY: recording, outside a render pass.
        unsafe {
            self.device.raw.cmd_pipeline_barrier(
                self.commands,
                stages,
                to,
                vk::DependencyFlags::empty(),
                &barrier,
                &[],
                &[],
            );
        }
    }

    fn timestamp(&self, index: usize) {
        if self.queries != vk::QueryPool::null() && index <= DISPATCHES_MAX {
            // SAFETY: recording; the pool has DISPATCHES_MAX + 1 queries.
            unsafe {
                self.device.raw.cmd_write_timestamp(
                    self.commands,
                    vk::PipelineStageFlags::COMPUTE_SHADER,
                    self.queries,
                    index as u32,
                );
            }
        }
    }

    /// Fills a buffer with a word.
    pub fn fill(&mut self, buffers: &Buffers, buffer: Buf, word: u32) {
        // SAFETY: recording; the whole buffer.
        unsafe {
            self.device.raw.cmd_fill_buffer(self.commands, buffers.handle(buffer), 0, vk::WHOLE_SIZE, word);
        }
        self.barrier();
    }

    /// Writes `words` at the start of a buffer. They are copied into the command buffer, so a few at a time.
    ///
    /// # Errors
    /// If the buffer is shorter.
    pub fn update(&mut self, buffers: &Buffers, buffer: Buf, words: &[u32]) -> Result<(), VkError> {
        fits(buffers, buffer, size_of_val(words))?;
        let handle = buffers.handle(buffer);
        for (i, part) in words.chunks(UPDATE_WORDS).enumerate() {
            let offset = 4 * (i * UPDATE_WORDS) as u64;
            // SAFETY: recording; at most 64 KiB in whole words, within the buffer as checked above.
            unsafe {
                self.device.raw.cmd_update_buffer(self.commands, handle, offset, bytemuck::cast_slice(part));
            }
        }
        self.barrier();
        Ok(())
    }

    /// Dispatches of this submit so far.
    pub fn dispatches(&self) -> usize {
        self.recorded.len()
    }

    /// Records one dispatch of a pass.
    pub fn dispatch(&mut self, pipelines: &Pipelines, buffers: &Buffers, d: &Dispatch) {
        let index = self.recorded.len();
        if index == 0 {
            self.timestamp(0);
        }
        let kernel = d.pass.kernel;
        let raw = &self.device.raw;
        let pipeline = pipelines.get(kernel);
        let set = self.sets[&kernel][(d.depth.max(1) as usize - 1) % 2];
        if let Some(labels) = &self.labels {
            let name = std::ffi::CString::new(format!("{} {}", kernel.name(), d.depth)).unwrap_or_default();
            let label = vk::DebugUtilsLabelEXT::default().label_name(&name);
            // SAFETY: recording; the label is copied.
            unsafe { labels.cmd_begin_debug_utils_label(self.commands, &label) };
        }
        // SAFETY: recording; four bytes of a four-byte buffer.
        unsafe { raw.cmd_fill_buffer(self.commands, buffers.marker(), 0, 4, index as u32) };
        // SAFETY: recording; pipeline and set were made for each other.
        unsafe { raw.cmd_bind_pipeline(self.commands, vk::PipelineBindPoint::COMPUTE, pipeline.handle) };
        // SAFETY: as above.
        unsafe {
            raw.cmd_bind_descriptor_sets(
                self.commands,
                vk::PipelineBindPoint::COMPUTE,
                pipeline.layout,
                0,
                &[set],
                &[],
            );
        }
        let stage = vk::ShaderStageFlags::COMPUTE;
        // SAFETY: recording; the range is the layout's.
        unsafe {
            raw.cmd_push_constants(self.commands, pipeline.layout, stage, 0, bytemuck::bytes_of(&d.push))
        };
        match d.pass.size {
            Size::One => self.groups(1),
            Size::Samples | Size::Pixels | Size::Walks => self.groups(d.items.div_ceil(self.workgroup)),
            Size::Rays => {
                let queue = buffers.handle(at_depth(Buf::Queue, d.depth));
                // SAFETY: recording; Queue starts with a VkDispatchIndirectCommand.
                unsafe { raw.cmd_dispatch_indirect(self.commands, queue, 0) };
            }
        }
        if pipelines.set().has_barrier_after(kernel) {
            self.barrier();
        }
        if let Some(labels) = &self.labels {
            // SAFETY: closes the label begun above.
            unsafe { labels.cmd_end_debug_utils_label(self.commands) };
        }
        self.recorded.push((kernel, d.depth));
        self.timestamp(index + 1);
    }

    fn groups(&self, groups: u32) {
        let (x, y) = (groups.min(GROUPS_PER_ROW), groups.div_ceil(GROUPS_PER_ROW));
        // SAFETY: recording; rows keep each axis within the least limit Vulkan promises.
        unsafe { self.device.raw.cmd_dispatch(self.commands, x, y, 1) };
    }

    /// Copies a region of a buffer to staging.
    fn copy_out(&self, buffers: &Buffers, buffer: Buf, region: vk::BufferCopy) {
        let (from, to) = (buffers.handle(buffer), buffers.staging());
        // SAFETY: recording; plans size staging for every read, so the region lies within both buffers.
        unsafe { self.device.raw.cmd_copy_buffer(self.commands, from, to, &[region]) };
        self.barrier();
    }

    /// Copies the start of a buffer to staging at `offset`.
    pub fn download(&mut self, buffers: &Buffers, buffer: Buf, bytes: u64, offset: u64) {
        self.copy_out(buffers, buffer, vk::BufferCopy { src_offset: 0, dst_offset: offset, size: bytes });
    }

    /// Submits, waits, and says how long each dispatch took. Without timestamps the wall time of
    /// the submit is shared out evenly.
    pub fn submit(&mut self, buffers: &Buffers) -> Result<Vec<Timed>, VkError> {
        if watch::is_abandoned() {
            return Err(VkError::Interrupted { at: "earlier work".into() });
        }
        let raw = &self.device.raw;
        let lost = |result, recorded: &[(Kernel, u32)]| match result {
            vk::Result::ERROR_DEVICE_LOST => VkError::Lost {
                pass: recorded
                    .get(buffers.last_marker() as usize)
                    .map_or("none".into(), |(k, d)| format!("{} at depth {d}", k.name())),
            },
            other => call("vkQueueSubmit", "frame")(other),
        };
        // SAFETY: recording.
        unsafe { raw.end_command_buffer(self.commands) }.map_err(call("vkEndCommandBuffer", "frame"))?;
        let commands = [self.commands];
        let submits = [vk::SubmitInfo::default().command_buffers(&commands)];
        let start = Instant::now();
        // SAFETY: the fence is unsignalled, the command buffer ended.
        unsafe { raw.queue_submit(self.device.queue, &submits, self.fence) }
            .map_err(|r| lost(r, &self.recorded))?;
        self.wait(buffers, &|r| lost(r, &self.recorded))?;
        self.ran |= !self.recorded.is_empty();
        let end = Instant::now();
        self.submitted = Some([start, end]);
        let wall = (end - start).as_secs_f64();
        // SAFETY: signalled, no submit pending.
        unsafe { raw.reset_fences(&[self.fence]) }.map_err(call("vkResetFences", "frame"))?;
        let count = self.recorded.len();
        let mut seconds = vec![wall / count.max(1) as f64; count];
        let mut begins = vec![None; count];
        if self.queries != vk::QueryPool::null() && count > 0 {
            let timed = count.min(DISPATCHES_MAX);
            let mut ticks = vec![0u64; timed + 1];
            let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
            // SAFETY: queries 0..=timed were written by the submit.
            unsafe { raw.get_query_pool_results(self.queries, 0, &mut ticks, flags) }
                .map_err(call("vkGetQueryPoolResults", "timestamps"))?;
            let bits = self.device.chosen.timestamp_bits;
            let mask = if bits >= 64 { u64::MAX } else { (1 << bits) - 1 };
            let period = f64::from(self.device.chosen.properties.limits.timestamp_period) * 1e-9;
            for (s, pair) in seconds.iter_mut().zip(ticks.windows(2)) {
                *s = (pair[1].wrapping_sub(pair[0]) & mask) as f64 * period;
            }
            let epoch = *self.epoch.get_or_insert(ticks[0]);
            for (begin, tick) in begins.iter_mut().zip(&ticks[..timed]) {
                *begin = Some((tick.wrapping_sub(epoch) & mask) as f64 * period);
            }
            let measured: f64 = seconds[..timed].iter().sum();
            let rest = (wall - measured).max(0.0) / (count - timed).max(1) as f64;
            seconds[timed..].fill(rest);
        }
        Ok(self
            .recorded
            .iter()
            .zip(begins.into_iter().zip(seconds))
            .map(|((kernel, depth), (begin, seconds))| Timed {
                kernel: *kernel,
                depth: *depth,
                begin,
                seconds,
            })
            .collect())
    }

    /// Waits for the fence of the submit under way. What runs to its end soon is worth waiting for, also after an
    /// interrupt; what compiles is not.
    fn wait(&self, buffers: &Buffers, failed: &dyn Fn(vk::Result) -> VkError) -> Result<(), VkError> {
        let raw = &self.device.raw;
        let look = watch::LOOK.as_nanos() as u64;
        let mut wait = Wait::new();
        let at = || {
            "compiling ".to_owned()
                + &match self.recorded.get(buffers.last_marker() as usize) {
                    Some((kernel, 0)) => format!("`{}`", kernel.name()),
                    Some((kernel, depth)) => format!("`{}` at depth {depth}", kernel.name()),
                    None => "a copy".into(),
                }
        };
        loop {
            // SAFETY: the fence belongs to the submit under way.
            match unsafe { raw.wait_for_fences(&[self.fence], true, look) } {
                Ok(()) => return Ok(()),
                Err(vk::Result::TIMEOUT) if self.ran || wait.goes_on(at) => {}
                Err(vk::Result::TIMEOUT) => return Err(VkError::Interrupted { at: at() }),
                Err(result) => return Err(failed(result)),
            }
        }
    }

    /// Host times just before the last submit and just after its end was seen.
    pub fn submitted(&self) -> Option<[Instant; 2]> {
        self.submitted
    }

    /// All bytes of a buffer, through staging, waiting.
    pub fn read(&mut self, buffers: &mut Buffers, buffer: Buf) -> Result<Vec<u8>, VkError> {
        let total = buffers.bytes(buffer);
        let piece = buffers.staging_bytes().len().max(1) as u64;
        let mut all = Vec::with_capacity(total as usize);
        while (all.len() as u64) < total {
            let (begin, size) = (all.len() as u64, piece.min(total - all.len() as u64));
            self.begin()?;
            self.copy_out(buffers, buffer, vk::BufferCopy { src_offset: begin, dst_offset: 0, size });
            self.submit(buffers)?;
            all.extend_from_slice(&buffers.staging_bytes()[..size as usize]);
        }
        Ok(all)
    }

    /// Copies host bytes to the start of a buffer, through staging, waiting.
    ///
    /// # Errors
    /// As [`Recorder::upload_made`].
    pub fn upload(&mut self, buffers: &mut Buffers, buffer: Buf, bytes: &[u8]) -> Result<(), VkError> {
        let copy = |from: usize, out: &mut [u8]| out.copy_from_slice(&bytes[from..][..out.len()]);
        fits(buffers, buffer, bytes.len())?;
        self.stage(buffers, buffer, Made { bytes: bytes.len(), element: 1 }, &copy)
    }

    /// Has `make` write what goes to the start of a buffer: at its place where the host reaches that, else
    /// to staging, piece by piece, waiting. It is given the first byte of the piece. Between submits.
    ///
    /// # Errors
    /// If the buffer has fewer bytes, or the device fails.
    pub fn upload_made(
        &mut self,
        buffers: &mut Buffers,
        buffer: Buf,
        shape: Made,
        make: &dyn Fn(usize, &mut [u8]),
    ) -> Result<(), VkError> {
        fits(buffers, buffer, shape.bytes)?;
        // No submit is under way, and the next one sees what the host wrote before it.
        if let Some(place) = buffers.direct(buffer).and_then(|all| all.get_mut(..shape.bytes)) {
            make(0, place);
            return Ok(());
        }
        self.stage(buffers, buffer, shape, make)
    }

    fn stage(
        &mut self,
        buffers: &mut Buffers,
        buffer: Buf,
        shape: Made,
        make: &dyn Fn(usize, &mut [u8]),
    ) -> Result<(), VkError> {
        let room = buffers.staging_bytes().len() / shape.element * shape.element;
        let mut from = 0;
        while from < shape.bytes {
            let size = room.min(shape.bytes - from);
            make(from, &mut buffers.staging_bytes()[..size]);
            self.begin()?;
            let region = [vk::BufferCopy { src_offset: 0, dst_offset: from as u64, size: size as u64 }];
            // SAFETY: recording; the plan sized the buffer for these bytes.
            unsafe {
                self.device.raw.cmd_copy_buffer(
                    self.commands,
                    buffers.staging(),
                    buffers.handle(buffer),
                    &region,
                );
            }
            self.barrier();
            self.submit(buffers)?;
            from += size;
        }
        Ok(())
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        if watch::is_abandoned() {
            return;
        }
        let raw = &self.device.raw;
        // SAFETY: submits are waited for, except after an error: then this waits, or the device is
        // lost and nothing runs.
        let _ = unsafe { raw.device_wait_idle() };
        // SAFETY: idle; null handles are allowed.
        unsafe { raw.destroy_descriptor_pool(self.descriptors, None) };
        // SAFETY: as above.
        unsafe { raw.destroy_query_pool(self.queries, None) };
        // SAFETY: as above.
        unsafe { raw.destroy_fence(self.fence, None) };
        // SAFETY: as above.
        unsafe { raw.destroy_command_pool(self.pool, None) };
    }
}

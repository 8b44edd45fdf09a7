//! The buffers of a plan: one device-local storage buffer per `Buf`, and one staging buffer through
//! which the host writes and reads.

use super::device::Device;
use super::error::{VkError, call};
use super::watch::is_abandoned;
use crate::kernel::abi::BUFFERS;
use crate::kernel::table::KERNELS;
use crate::plan::TEXEL_BYTES;
use crate::plan::passes::at_depth;
use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};
use std::rc::Rc;

/// One buffer with its memory.
struct Slot {
    handle: vk::Buffer,
    allocation: Option<Allocation>,
    bytes: u64,
    /// As texels, for buffers that some kernel reads so.
    view: vk::BufferView,
}

/// Bytes that are made when they are wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Made {
    /// In all.
    pub bytes: usize,
    /// Of an element; they are made whole.
    pub element: usize,
}

/// All buffers of a plan, allocated once.
pub struct Buffers {
    device: Rc<Device>,
    slots: Vec<Slot>,
    staging: Slot,
    marker: Slot,
}

/// Bytes of the staging buffer at least; larger uploads go in pieces of it.
const STAGING_LEAST: u64 = 1 << 20;

impl Buffers {
    /// Allocates buffers of `bytes`, in binding order; `readback` is the largest single read.
    pub fn new(device: &Rc<Device>, bytes: &[u64], readback: u64) -> Result<Buffers, VkError> {
        let staging = allocate(device, "staging", readback.max(STAGING_LEAST), MemoryLocation::GpuToCpu)?;
        let marker = allocate(device, "marker", 4, MemoryLocation::GpuToCpu)?;
        let mut buffers =
            Buffers { device: Rc::clone(device), slots: Vec::with_capacity(bytes.len()), staging, marker };
        for ((name, ..), bytes) in BUFFERS.iter().zip(bytes) {
            buffers.slots.push(allocate(device, name, *bytes, MemoryLocation::GpuOnly)?);
        }
        let viewed = KERNELS.iter().fold(0u64, |bits, k| bits | k.texels);
        for (name, _, buffer) in BUFFERS {
            // At even depths the queues have changed places.
            if [1, 2].iter().any(|depth| viewed >> at_depth(*buffer, *depth) as u32 & 1 == 1) {
                let slot = &mut buffers.slots[*buffer as usize];
                slot.view = view(device, name, slot)?;
            }
        }
        Ok(buffers)
    }

    /// Makes those longer that are shorter than `bytes`, in binding order; what they held is lost. No submit may be under
    /// way, and recorders made before must be renewed.
    pub fn lengthen(&mut self, bytes: &[u64]) -> Result<(), VkError> {
        for (slot, ((name, ..), bytes)) in self.slots.iter_mut().zip(BUFFERS.iter().zip(bytes)) {
            if *bytes <= slot.bytes {
                continue;
            }
            let mut longer = allocate(&self.device, name, *bytes, MemoryLocation::GpuOnly)?;
            if slot.view != vk::BufferView::null() {
                match view(&self.device, name, &longer) {
                    Ok(made) => longer.view = made,
                    Err(error) => {
                        release(&self.device, &mut longer);
                        return Err(error);
                    }
                }
            }
            release(&self.device, slot);
            *slot = longer;
        }
        Ok(())
    }

    pub(super) fn handle(&self, buffer: crate::kernel::abi::Buf) -> vk::Buffer {
        self.slots[buffer as usize].handle
    }

    pub(super) fn view(&self, buffer: crate::kernel::abi::Buf) -> vk::BufferView {
        self.slots[buffer as usize].view
    }

    /// Bytes of a buffer.
    pub fn bytes(&self, buffer: crate::kernel::abi::Buf) -> u64 {
        self.slots[buffer as usize].bytes
    }

    /// A buffer's own memory, where the host sees it and what it writes needs no flush: that of software
    /// and integrated devices, and of cards that show all of theirs.
    pub(super) fn direct(&mut self, buffer: crate::kernel::abi::Buf) -> Option<&mut [u8]> {
        let slot = &mut self.slots[buffer as usize];
        let seen = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
        let allocation = slot.allocation.as_mut().filter(|a| a.memory_properties().contains(seen))?;
        allocation.mapped_slice_mut()
    }

    /// Bytes of memory that all of them took, staging included.
    pub fn taken(&self) -> u64 {
        let slots = self.slots.iter().chain([&self.staging, &self.marker]);
        slots.filter_map(|s| s.allocation.as_ref()).map(Allocation::size).sum()
    }

    pub(super) fn staging(&self) -> vk::Buffer {
        self.staging.handle
    }

    pub(super) fn marker(&self) -> vk::Buffer {
        self.marker.handle
    }

    /// Number of the pass that was begun last.
    pub(super) fn last_marker(&self) -> u32 {
        let bytes = self.marker.allocation.as_ref().and_then(|a| a.mapped_slice());
        bytes.and_then(|b| b.first_chunk()).map_or(0, |b| u32::from_le_bytes(*b))
    }

    /// The staging memory, as the host sees it.
    pub fn staging_bytes(&mut self) -> &mut [u8] {
        self.staging.allocation.as_mut().and_then(|a| a.mapped_slice_mut()).unwrap_or_default()
    }
}

fn allocate(device: &Device, name: &str, bytes: u64, location: MemoryLocation) -> Result<Slot, VkError> {
    let usage = vk::BufferUsageFlags::STORAGE_BUFFER
        | vk::BufferUsageFlags::UNIFORM_TEXEL_BUFFER
        | vk::BufferUsageFlags::INDIRECT_BUFFER
        | vk::BufferUsageFlags::TRANSFER_SRC
        | vk::BufferUsageFlags::TRANSFER_DST;
    // A texel view needs a whole texel.
    let padded = bytes.max(TEXEL_BYTES);
    let info = vk::BufferCreateInfo::default().size(padded).usage(usage);
    // SAFETY: the device is alive; size is not zero (plans round up to one element).
    let handle = unsafe { device.raw.create_buffer(&info, None) }.map_err(call("vkCreateBuffer", name))?;
    let mut slot = Slot { handle, allocation: None, bytes, view: vk::BufferView::null() };
    // SAFETY: the buffer was made by this device.
    let requirements = unsafe { device.raw.get_buffer_memory_requirements(handle) };
    let bound = device
        .allocator()
        .allocate(&AllocationCreateDesc {
            name,
            requirements,
            location,
            linear: true,
            allocation_scheme: AllocationScheme::GpuAllocatorManaged,
        })
        .map_err(|source| VkError::Memory { name: name.into(), bytes, source })
        .and_then(|allocation| {
            // SAFETY: memory and offset come from the allocator for exactly this buffer.
            let bound =
                unsafe { device.raw.bind_buffer_memory(handle, allocation.memory(), allocation.offset()) };
            slot.allocation = Some(allocation);
            bound.map_err(call("vkBindBufferMemory", name))
        });
    match bound {
        Ok(()) => Ok(slot),
        Err(error) => {
            release(device, &mut slot);
            Err(error)
        }
    }
}

/// A view in texels of four words, of as much as the device allows: where that is not all, no kernel
/// is told to read it (`plan`), but one that could must have it bound.
fn view(device: &Device, name: &str, slot: &Slot) -> Result<vk::BufferView, VkError> {
    let texels = (slot.bytes / TEXEL_BYTES).min(u64::from(device.limits().texel_elements));
    let info = vk::BufferViewCreateInfo::default()
        .buffer(slot.handle)
        .format(vk::Format::R32G32B32A32_UINT)
        .range(texels.max(1) * TEXEL_BYTES);
    // SAFETY: the buffer has its memory, and at least a texel of it (`allocate`).
    unsafe { device.raw.create_buffer_view(&info, None) }.map_err(call("vkCreateBufferView", name))
}

fn release(device: &Device, slot: &mut Slot) {
    // SAFETY: the recorder waits for its submits; null is allowed.
    unsafe { device.raw.destroy_buffer_view(slot.view, None) };
    // SAFETY: the recorder waits for its submits, so no command uses the buffer any more.
    unsafe { device.raw.destroy_buffer(slot.handle, None) };
    if let Some(allocation) = slot.allocation.take() {
        // An error here means a broken allocator; there is nothing left to do with the memory.
        drop(device.allocator().free(allocation));
    }
}

impl Drop for Buffers {
    fn drop(&mut self) {
        if is_abandoned() {
            return;
        }
        for slot in self.slots.iter_mut().chain([&mut self.staging, &mut self.marker]) {
            release(&self.device, slot);
        }
    }
}

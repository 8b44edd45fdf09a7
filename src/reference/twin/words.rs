//! The buffers as the words that a device sees; only of single precision, whose structs have no padding.

use super::memory::Memory;
use crate::kernel::abi::{BUFFERS, Buf};
use bytemuck::{cast_slice, cast_slice_mut};

/// What an unwritten word holds: a quiet NaN, so that reading one shows.
pub const POISON: u32 = 0x7fc0_0000;

impl Memory {
    /// Buffers of these lengths, poisoned throughout.
    pub fn poisoned(length: impl Fn(Buf) -> usize) -> Memory {
        let mut memory = Memory::of_lengths(length);
        BUFFERS.iter().for_each(|(_, _, buffer)| memory.words_mut(*buffer).fill(POISON));
        memory
    }

    /// The bytes of a buffer.
    pub fn bytes(&self, buffer: Buf) -> &[u8] {
        match buffer {
            Buf::Camera => cast_slice(&self.camera),
            Buf::Triangles => cast_slice(&self.triangles),
            Buf::FlatNormals => cast_slice(&self.flat_normals),
            Buf::CornerNormals => cast_slice(&self.corner_normals),
            Buf::Spheres => cast_slice(&self.spheres),
            Buf::ExtendedSpheres => cast_slice(&self.extended_spheres),
            Buf::Nodes => cast_slice(&self.nodes),
            Buf::CompressedNodes => cast_slice(&self.compressed_nodes),
            Buf::Materials => cast_slice(&self.materials),
            Buf::Lights => cast_slice(&self.lights),
            Buf::SolidIors => cast_slice(&self.solid_iors),
            Buf::SolidPriorities => cast_slice(&self.solid_priorities),
            Buf::EyeMedia => cast_slice(&self.eye_media),
            Buf::Pixels => cast_slice(&self.pixels),
            Buf::Rays => cast_slice(&self.rays),
            Buf::NextRays => cast_slice(&self.next_rays),
            Buf::Media => cast_slice(&self.media),
            Buf::NextMedia => cast_slice(&self.next_media),
            Buf::Queue => cast_slice(&self.queue),
            Buf::NextQueue => cast_slice(&self.next_queue),
            Buf::Hits => cast_slice(&self.hits),
            Buf::Surfaces => cast_slice(&self.surfaces),
            Buf::ChildCounts => cast_slice(&self.child_counts),
            Buf::ChildMasks => cast_slice(&self.child_masks),
            Buf::Offsets => cast_slice(&self.offsets),
            Buf::Contributions => cast_slice(&self.contributions),
            Buf::RayIndices => cast_slice(&self.ray_indices),
            Buf::SampleRadiance => cast_slice(&self.sample_radiance),
            Buf::Paths => cast_slice(&self.paths),
            Buf::Walks => cast_slice(&self.walks),
            Buf::Film => cast_slice(&self.film),
            Buf::Marks => cast_slice(&self.marks),
            Buf::DepthCounts => cast_slice(&self.depth_counts),
            Buf::Counters => cast_slice(&self.counters),
            Buf::SelfTest => cast_slice(&self.self_test),
        }
    }

    /// The words of a buffer.
    pub fn words_mut(&mut self, buffer: Buf) -> &mut [u32] {
        match buffer {
            Buf::Camera => cast_slice_mut(&mut self.camera),
            Buf::Triangles => cast_slice_mut(&mut self.triangles),
            Buf::FlatNormals => cast_slice_mut(&mut self.flat_normals),
            Buf::CornerNormals => cast_slice_mut(&mut self.corner_normals),
            Buf::Spheres => cast_slice_mut(&mut self.spheres),
            Buf::ExtendedSpheres => cast_slice_mut(&mut self.extended_spheres),
            Buf::Nodes => cast_slice_mut(&mut self.nodes),
            Buf::CompressedNodes => cast_slice_mut(&mut self.compressed_nodes),
            Buf::Materials => cast_slice_mut(&mut self.materials),
            Buf::Lights => cast_slice_mut(&mut self.lights),
            Buf::SolidIors => cast_slice_mut(&mut self.solid_iors),
            Buf::SolidPriorities => cast_slice_mut(&mut self.solid_priorities),
            Buf::EyeMedia => cast_slice_mut(&mut self.eye_media),
            Buf::Pixels => cast_slice_mut(&mut self.pixels),
            Buf::Rays => cast_slice_mut(&mut self.rays),
            Buf::NextRays => cast_slice_mut(&mut self.next_rays),
            Buf::Media => cast_slice_mut(&mut self.media),
            Buf::NextMedia => cast_slice_mut(&mut self.next_media),
            Buf::Queue => cast_slice_mut(&mut self.queue),
            Buf::NextQueue => cast_slice_mut(&mut self.next_queue),
            Buf::Hits => cast_slice_mut(&mut self.hits),
            Buf::Surfaces => cast_slice_mut(&mut self.surfaces),
            Buf::ChildCounts => cast_slice_mut(&mut self.child_counts),
            Buf::ChildMasks => cast_slice_mut(&mut self.child_masks),
            Buf::Offsets => cast_slice_mut(&mut self.offsets),
            Buf::Contributions => cast_slice_mut(&mut self.contributions),
            Buf::RayIndices => cast_slice_mut(&mut self.ray_indices),
            Buf::SampleRadiance => cast_slice_mut(&mut self.sample_radiance),
            Buf::Paths => cast_slice_mut(&mut self.paths),
            Buf::Walks => cast_slice_mut(&mut self.walks),
            Buf::Film => cast_slice_mut(&mut self.film),
            Buf::Marks => cast_slice_mut(&mut self.marks),
            Buf::DepthCounts => cast_slice_mut(&mut self.depth_counts),
            Buf::Counters => cast_slice_mut(&mut self.counters),
            Buf::SelfTest => cast_slice_mut(&mut self.self_test),
        }
    }
}

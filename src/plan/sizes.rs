//! Lengths of queues, tiles and buffers for a batch of a given size.

use super::Plan;
use super::build::{Choice, Input};
use crate::kernel::abi::{self, Buf, GpuStruct};
use crate::settings::Precision;

/// Queue entries per sample of a batch where rays branch. Not a bound: a fuller queue is detected
/// before it is written, and the tile is traced again in smaller batches.
const BRANCHING_ROOM: u32 = 4;
/// Least number of queue entries where rays branch: the rays of one sample that `gather` can add up
/// (LOOP_CAP), rounded up.
const BRANCHING_LEAST: u32 = 1 << 16;

/// Rays whose walks go on together, dispatch by dispatch (`Way::Parts`): enough to fill a device, at 272 bytes each.
pub const WALKS: u32 = 1 << 14;

/// Numbers that determine the lengths of several buffers.
struct Lengths {
    /// Walks that go on from dispatch to dispatch.
    walks: u64,
    choice: Choice,
    /// Rays that fit a queue.
    capacity: u64,
    /// Places for rays in `rays` and `next_rays`.
    places: u64,
    /// Workgroups of a full queue, plus one.
    groups: u64,
    /// Child masks of a workgroup.
    masks: u64,
    /// Pixels of the tile.
    tile: u64,
    /// Samples of the batch, over all pixels.
    batch: u64,
}

impl Plan {
    /// Sizes queues, tile and buffers for batches of `batch` samples.
    pub(super) fn size_for(&mut self, input: Input<'_>, batch: u32, choice: Choice) {
        let [x0, y0, x1, y1] = input.settings.region();
        self.capacity = self.capacity_for(input, batch);
        // Whole rows if a row fits.
        let width = x1 - x0;
        let rows = (batch / width).clamp(1, y1 - y0);
        self.tile_pixels = (rows * width).min(batch);
        self.buffer_bytes = self.bytes_for(input, &self.lengths(input, batch, choice));
    }

    /// Sizes buffers for the same batches in parts: those of split kernels, and room for walks.
    pub(super) fn size_in_parts(&mut self, input: Input<'_>, batch: u32, choice: Choice) {
        let mut lengths = self.lengths(input, batch, Choice { fused: false, ..choice });
        lengths.walks = WALKS.into();
        let split = self.bytes_for(input, &lengths);
        self.bytes_in_parts = split.iter().zip(&self.buffer_bytes).map(|(a, b)| *a.max(b)).collect();
    }

    fn bytes_for(&self, input: Input<'_>, lengths: &Lengths) -> Vec<u64> {
        abi::BUFFERS
            .iter()
            .map(|(_, element, buffer)| {
                // Vulkan has no empty buffers.
                let count = self.elements(*buffer, input, lengths).max(1);
                count * element_bytes(element, input.settings.precision)
            })
            .collect()
    }

    /// Rays that fit a queue.
    fn capacity_for(&self, input: Input<'_>, batch: u32) -> u32 {
        if !input.packed.branching {
            return batch;
        }
        // A small image has few samples, but each of them may branch as far as in a large one.
        let growth = 1u32.checked_shl(self.last_depth - 1).unwrap_or(u32::MAX);
        let least = BRANCHING_LEAST.min(batch.saturating_mul(growth));
        batch.saturating_mul(BRANCHING_ROOM.min(growth)).max(least)
    }

    fn lengths(&self, input: Input<'_>, batch: u32, choice: Choice) -> Lengths {
        let (workgroup, capacity) = (self.specialisation.workgroup, u64::from(self.capacity));
        // `fused_depth` writes the two children of a ray to places of their own.
        let apart = choice.fused && self.last_depth > 1 && input.packed.branching;
        Lengths {
            walks: 0,
            choice,
            capacity,
            places: if apart { 2 * capacity } else { capacity },
            groups: capacity.div_ceil(u64::from(workgroup)) + 1,
            masks: u64::from(workgroup / input.limits.shuffle_lanes.max(1)),
            tile: u64::from(self.tile_pixels),
            batch: u64::from(batch),
        }
    }

    /// Elements of a buffer; 0 for one that the scene leaves empty.
    fn elements(&self, buffer: Buf, input: Input<'_>, lengths: &Lengths) -> u64 {
        let Input { packed, settings, .. } = input;
        let Lengths { choice: Choice { fused, joined }, capacity, places, groups, masks, tile, batch, walks } =
            *lengths;
        let (deep, media) = (self.last_depth > 1, u64::from(packed.media_capacity));
        let survey = self.specialisation.survey != 0;
        match buffer {
            Buf::Camera | Buf::Queue | Buf::NextQueue => 1,
            Buf::Triangles => packed.triangles.len() as u64,
            Buf::FlatNormals => packed.flat_normals.len() as u64,
            Buf::CornerNormals => packed.corner_normals.len() as u64,
            Buf::Spheres => packed.spheres.len() as u64,
            Buf::ExtendedSpheres => packed.extended_spheres.len() as u64,
            Buf::Nodes if joined => 1,
            Buf::Nodes => packed.nodes.len() as u64,
            Buf::CompressedNodes if joined => packed.compressed_nodes.as_flattened().len() as u64,
            Buf::CompressedNodes => 1,
            Buf::Materials => packed.materials.len() as u64,
            Buf::Lights => packed.lights.len() as u64,
            Buf::SolidIors => packed.solid_iors.len() as u64,
            Buf::SolidPriorities => packed.solid_priorities.len() as u64,
            Buf::EyeMedia => media,
            Buf::NextRays | Buf::NextMedia if !deep => 1,
            Buf::Rays | Buf::NextRays => places,
            Buf::Hits | Buf::Surfaces if fused => 1,
            Buf::Hits | Buf::Surfaces => capacity,
            Buf::RayIndices if fused && deep => capacity,
            Buf::RayIndices => 1,
            Buf::Contributions if packed.branching && deep => capacity,
            Buf::Contributions if packed.lights.len() as u32 > self.lights_per_pass => capacity,
            Buf::Contributions => 1,
            Buf::Media | Buf::NextMedia => places * media,
            Buf::ChildMasks if fused => groups * masks,
            Buf::ChildCounts if fused => 1,
            Buf::ChildMasks => 1,
            Buf::ChildCounts | Buf::Offsets => groups,
            Buf::SampleRadiance => batch,
            Buf::Walks => walks * u64::from(abi::WALK_WORDS),
            Buf::Film => tile * u64::from(self.specialisation.film_sums()),
            Buf::Paths if survey => batch,
            Buf::Pixels | Buf::Marks if survey => tile,
            Buf::Paths | Buf::Pixels | Buf::Marks => 1,
            Buf::DepthCounts => u64::from(settings.depth) + 1,
            Buf::Counters => {
                let of_tests = abi::TEST_WORDS * abi::RAY_KINDS * self.specialisation.counting;
                u64::from(abi::COUNTERS) + u64::from(of_tests) * u64::from(settings.depth)
            }
            Buf::SelfTest => 1,
        }
    }
}

/// Bytes of a buffer's element by its GLSL name.
pub fn element_bytes(element: &str, precision: Precision) -> u64 {
    let structs = if precision == Precision::Double { abi::double::STRUCTS } else { abi::single::STRUCTS };
    let of_struct = |s: &&GpuStruct| s.name == element;
    match (element, structs.iter().find(of_struct)) {
        (_, Some(s)) => s.size as u64,
        ("vec3", None) => 12,
        ("real", None) if precision == Precision::Double => 8,
        _ => 4,
    }
}

//! Whether a plan fits the device, and if not, how large a scene would.

use super::limits::may_read_texels;
use super::{Limits, Plan, PlanError, Shortage, TEXEL_BYTES};
use crate::kernel::abi::{BUFFERS, Buf};
use crate::kernel::table::KERNELS;
use crate::prepare::Packed;
use crate::settings::Settings;

/// Share of the heap that a plan may take, in eighths.
pub(crate) const HEAP_EIGHTHS: u64 = 6;

/// Buffers that grow with a scene's primitives.
const OF_PRIMITIVES: [Buf; 7] = [
    Buf::Triangles,
    Buf::FlatNormals,
    Buf::CornerNormals,
    Buf::Spheres,
    Buf::ExtendedSpheres,
    Buf::Nodes,
    Buf::CompressedNodes,
];

/// True for a buffer that no kernel writes and that each kernel which reads it can read as texels.
fn is_texels_alone(buffer: Buf) -> bool {
    let bit = 1u64 << buffer as u32;
    KERNELS.iter().all(|k| k.writes & bit == 0 && (k.reads & bit == 0 || k.texels & bit != 0))
}

impl Plan {
    /// Greatest number of bytes of a buffer on the device. A buffer that is only read as texels need not fit a
    /// storage binding: its descriptor ends where the device's range does.
    fn most(&self, buffer: Buf, limits: &Limits) -> u64 {
        match self.specialisation.texels != 0 && is_texels_alone(buffer) {
            true => (TEXEL_BYTES * u64::from(limits.texel_elements)).max(limits.storage_range),
            false => limits.storage_range,
        }
    }

    /// True if every buffer fits a binding and all of them their share of the heap.
    pub(super) fn fits(&self, limits: &Limits) -> bool {
        let bound =
            |(_, _, buffer): &(_, _, Buf)| self.buffer_bytes[*buffer as usize] <= self.most(*buffer, limits);
        BUFFERS.iter().all(bound) && self.bytes() <= limits.heap / 8 * HEAP_EIGHTHS
    }

    /// Says what is too large, and how many primitives of the scene's kind would fit.
    pub(super) fn too_large(mut self, packed: &Packed, settings: &Settings, limits: &Limits) -> PlanError {
        // What fits may be read as texels even where all of this may not.
        self.specialisation.texels = u32::from(may_read_texels(settings, limits));
        let count = packed.primitive_count();
        let of = |buffer: Buf| self.buffer_bytes[buffer as usize];
        let scene: u64 = OF_PRIMITIVES.iter().map(|b| of(*b)).sum();
        let heap = limits.heap / 8 * HEAP_EIGHTHS;
        let rest = self.bytes() - scene;
        // What is in the way, the share of it that the device has.
        let bindings = BUFFERS
            .iter()
            .map(|(_, _, buffer)| (*buffer, self.most(*buffer, limits) as f64 / of(*buffer) as f64))
            .min_by(|a, b| a.1.total_cmp(&b.1));
        let of_heap = heap.saturating_sub(rest) as f64 / scene as f64;
        let (shortage, share, of_scene) = match bindings {
            Some((buffer, share)) if share < 1.0 => (
                Shortage {
                    buffer: Some(BUFFERS[buffer as usize].0),
                    bytes: of(buffer),
                    limit: self.most(buffer, limits),
                },
                share.min(of_heap),
                OF_PRIMITIVES.contains(&buffer),
            ),
            _ => (Shortage { buffer: None, bytes: self.bytes(), limit: heap }, of_heap, rest < heap),
        };
        // A thousandth less, as lengths are rounded up to whole elements.
        let fit = (count as f64 * share * 0.999).floor();
        match of_scene && fit >= 1.0 {
            true => PlanError::SceneTooLarge { primitives: count, shortage, fit: fit as u64 },
            false => PlanError::RayTooLarge { shortage },
        }
    }
}

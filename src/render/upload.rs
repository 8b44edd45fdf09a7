//! Everything that goes to the device once, as the kernels of a precision want it.

use crate::kernel::abi::{self, Buf};
use crate::prepare::Packed;
use crate::settings::Precision;
use crate::vk::Made;
use bytemuck::Pod;
use rayon::prelude::*;

/// Elements that one thread makes at a time.
const CHUNK: usize = 1 << 13;

/// Writes whole elements from one on, by its number.
type Make<'a> = Box<dyn Fn(usize, &mut [u8]) + Sync + 'a>;

/// What goes to one buffer. Its bytes are made where they are wanted: the numbers of a large scene are not
/// held a second time.
pub(super) struct Upload<'a> {
    pub(super) buffer: Buf,
    pub(super) shape: Made,
    make: Make<'a>,
}

impl<'a> Upload<'a> {
    /// Host structs: f64 as they are, or each number rounded to f32.
    fn new<W: Pod + Sync, N: Pod + for<'w> From<&'w W>>(
        buffer: Buf,
        wide: &'a [W],
        double: bool,
    ) -> Upload<'a> {
        if double {
            return Upload::plain(buffer, wide);
        }
        let element = size_of::<N>();
        let make = move |first: usize, out: &mut [u8]| {
            for (wide, bytes) in wide[first..].iter().zip(out.chunks_exact_mut(element)) {
                bytes.copy_from_slice(bytemuck::bytes_of(&N::from(wide)));
            }
        };
        Upload { buffer, shape: Made { bytes: element * wide.len(), element }, make: Box::new(make) }
    }

    /// Elements as they are.
    fn plain<T: Pod + Sync>(buffer: Buf, elements: &'a [T]) -> Upload<'a> {
        let (bytes, element): (&[u8], usize) = (bytemuck::cast_slice(elements), size_of::<T>());
        let make = move |first: usize, out: &mut [u8]| {
            out.copy_from_slice(&bytes[first * element..][..out.len()]);
        };
        Upload { buffer, shape: Made { bytes: bytes.len(), element }, make: Box::new(make) }
    }

    /// Fills `out` with the bytes from byte `from` on; both whole elements.
    pub(super) fn fill(&self, from: usize, out: &mut [u8]) {
        let first = from / self.shape.element;
        out.par_chunks_mut(CHUNK * self.shape.element)
            .enumerate()
            .for_each(|(i, part)| (self.make)(first + i * CHUNK, part));
    }

    /// All bytes, in pieces.
    pub(super) fn pieces(&self, mut take: impl FnMut(&[u8])) {
        let mut piece = vec![0; self.shape.bytes.min(CHUNK * self.shape.element)];
        let mut from = 0;
        while from < self.shape.bytes {
            let size = piece.len().min(self.shape.bytes - from);
            self.fill(from, &mut piece[..size]);
            take(&piece[..size]);
            from += size;
        }
    }
}

/// The scene's buffers.
pub(super) fn uploads<'a>(
    packed: &'a Packed,
    camera: &'a [abi::double::Camera; 1],
    precision: Precision,
) -> [Upload<'a>; 13] {
    let double = precision == Precision::Double;
    [
        Upload::new::<_, abi::single::Camera>(Buf::Camera, camera.as_slice(), double),
        Upload::new::<_, abi::single::Triangle>(Buf::Triangles, &packed.triangles, double),
        Upload::new::<_, abi::single::FlatNormal>(Buf::FlatNormals, &packed.flat_normals, double),
        Upload::new::<_, abi::single::CornerNormals>(Buf::CornerNormals, &packed.corner_normals, double),
        Upload::new::<_, abi::single::Sphere>(Buf::Spheres, &packed.spheres, double),
        Upload::new::<_, abi::single::ExtendedSphere>(Buf::ExtendedSpheres, &packed.extended_spheres, double),
        Upload::new::<_, abi::single::Node>(Buf::Nodes, &packed.nodes, double),
        Upload::plain(Buf::CompressedNodes, packed.compressed_nodes.as_flattened()),
        Upload::new::<_, abi::single::Material>(Buf::Materials, &packed.materials, double),
        Upload::new::<_, abi::single::Light>(Buf::Lights, &packed.lights, double),
        Upload::plain(Buf::SolidIors, &packed.solid_iors),
        Upload::plain(Buf::SolidPriorities, &packed.solid_priorities),
        Upload::plain(Buf::EyeMedia, &packed.eye_media),
    ]
}

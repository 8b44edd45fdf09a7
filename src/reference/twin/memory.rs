//! The buffers of a plan in host memory.

use super::real::Real;
use super::structs::{
    Camera, Contribution, CornerNormals, DepthCount, ExtendedSphere, Film, FlatNormal, Hit, Light, Mark,
    Material, Node, Path, Queue, Ray, Sphere, Surface, Triangle,
};
use super::{PRECISION, from_host};
use crate::kernel::abi::double::Camera as HostCamera;
use crate::kernel::abi::{BUFFERS, Buf};
use crate::prepare::Packed;

macro_rules! memory {
    ($($field:ident / $variant:ident: $element:ty;)*) => {
        /// Every buffer of the passes, under its kernel name.
        #[derive(Debug, Clone)]
        pub struct Memory {
            $(
                #[doc = concat!("Buffer `", stringify!($field), "`.")]
                pub $field: Vec<$element>,
            )*
        }

        impl Memory {
            /// Buffers of these lengths, all zero.
            pub fn of_lengths(length: impl Fn(Buf) -> usize) -> Memory {
                Memory { $($field: vec![<$element>::default(); length(Buf::$variant)],)* }
            }
        }
    };
}

memory! {
    camera / Camera: Camera;
    triangles / Triangles: Triangle;
    flat_normals / FlatNormals: FlatNormal;
    corner_normals / CornerNormals: CornerNormals;
    spheres / Spheres: Sphere;
    extended_spheres / ExtendedSpheres: ExtendedSphere;
    nodes / Nodes: Node;
    compressed_nodes / CompressedNodes: crate::kernel::abi::single::CompressedChild;
    materials / Materials: Material;
    lights / Lights: Light;
    solid_iors / SolidIors: f32;
    solid_priorities / SolidPriorities: i32;
    eye_media / EyeMedia: u32;
    pixels / Pixels: u32;
    rays / Rays: Ray;
    next_rays / NextRays: Ray;
    media / Media: u32;
    next_media / NextMedia: u32;
    queue / Queue: Queue;
    next_queue / NextQueue: Queue;
    hits / Hits: Hit;
    surfaces / Surfaces: Surface;
    child_counts / ChildCounts: u32;
    child_masks / ChildMasks: u32;
    offsets / Offsets: u32;
    ray_indices / RayIndices: u32;
    contributions / Contributions: Contribution;
    sample_radiance / SampleRadiance: [f32; 3];
    paths / Paths: Path;
    walks / Walks: u32;
    film / Film: Film;
    marks / Marks: Mark;
    depth_counts / DepthCounts: DepthCount;
    counters / Counters: u32;
    self_test / SelfTest: Real;
}

impl Memory {
    /// Buffers of `bytes` each, in binding order, with the scene and `camera` in place.
    pub fn new(bytes: &[u64], packed: &Packed, camera: &HostCamera) -> Memory {
        let element = |b: Buf| crate::plan::element_bytes(BUFFERS[b as usize].1, PRECISION);
        let mut memory = Memory::of_lengths(|b| (bytes[b as usize] / element(b)) as usize);
        memory.camera = from_host(std::slice::from_ref(camera));
        memory.triangles = from_host(&packed.triangles);
        memory.flat_normals = from_host(&packed.flat_normals);
        memory.corner_normals = from_host(&packed.corner_normals);
        memory.spheres = from_host(&packed.spheres);
        memory.extended_spheres = from_host(&packed.extended_spheres);
        memory.nodes = from_host(&packed.nodes);
        memory.compressed_nodes = packed.compressed_nodes.as_flattened().to_vec();
        memory.materials = from_host(&packed.materials);
        memory.lights = from_host(&packed.lights);
        memory.solid_iors.clone_from(&packed.solid_iors);
        memory.solid_priorities.clone_from(&packed.solid_priorities);
        memory.eye_media.clone_from(&packed.eye_media);
        memory
    }

    /// Exchanges the queues of this depth and the next.
    pub fn next_depth(&mut self) {
        std::mem::swap(&mut self.rays, &mut self.next_rays);
        std::mem::swap(&mut self.media, &mut self.next_media);
        std::mem::swap(&mut self.queue, &mut self.next_queue);
    }
}

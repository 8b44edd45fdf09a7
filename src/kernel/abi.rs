//! Everything that host and kernels share: structs, constants, binding numbers. Each is said once,
//! here; `build.rs` includes this file, writes `abi.glsl` from it for the kernels, and checks the
//! compiled SPIR-V against it.
//!
//! Layout is `scalar` (GL_EXT_scalar_block_layout): fields of 4 bytes, no padding, so `repr(C)` and
//! GLSL agree.

/// A struct known to both sides, its GLSL text, and the offsets that the SPIR-V must show.
#[derive(Debug, Clone, Copy)]
pub struct GpuStruct {
    /// Name on both sides.
    pub name: &'static str,
    /// GLSL declaration.
    pub glsl: &'static str,
    /// Bytes.
    pub size: usize,
    /// Field names and their byte offsets.
    pub fields: &'static [(&'static str, usize)],
}

macro_rules! rust_type {
    (real, $real:ty) => {
        $real
    };
    (real3, $real:ty) => {
        [$real; 3]
    };
    (vec3, $real:ty) => {
        [f32; 3]
    };
    (float, $real:ty) => {
        f32
    };
    (uint, $real:ty) => {
        u32
    };
}

macro_rules! rounded {
    (real, $value:expr) => {
        $value as f32
    };
    (real3, $value:expr) => {
        $value.map(|x| x as f32)
    };
    ($other:ident, $value:expr) => {
        $value
    };
}

macro_rules! table {
    ($real:ty; $($name:ident { $($field:ident: $ty:ident,)* })*) => {
        /// All shared structs with their layouts, in declaration order.
        pub const STRUCTS: &[super::GpuStruct] = &[$(super::GpuStruct {
            name: stringify!($name),
            glsl: concat!("struct ", stringify!($name), " {\n",
                $("    ", stringify!($ty), " ", stringify!($field), ";\n",)* "};\n"),
            size: size_of::<$name>(),
            fields: &[$((stringify!($field), core::mem::offset_of!($name, $field)),)*],
        },)*];
    };
}

/// Declares structs whose `real` fields are f32 in [`single`] and f64 in [`double`]. `host` structs
/// are filled by the host in f64 and rounded to f32 once; the others live on the device alone.
macro_rules! gpu_structs {
    (
        host { $($(#[$meta:meta])* struct $name:ident { $($(#[$field_meta:meta])* $field:ident: $ty:ident,)* })* }
        device { $($(#[$dmeta:meta])* struct $dname:ident { $($(#[$dfield_meta:meta])* $dfield:ident: $dty:ident,)* })* }
    ) => {
        /// Shared structs of the single-precision kernels.
        pub mod single {
            use bytemuck::{Pod, Zeroable};
            $(
                $(#[$meta])*
                #[repr(C)]
                #[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
                pub struct $name { $($(#[$field_meta])* pub $field: rust_type!($ty, f32),)* }
                impl From<&super::double::$name> for $name {
                    fn from(wide: &super::double::$name) -> Self {
                        $name { $($field: rounded!($ty, wide.$field),)* }
                    }
                }
            )*
            $(
                $(#[$dmeta])*
                #[repr(C)]
                #[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
                pub struct $dname { $($(#[$dfield_meta])* pub $dfield: rust_type!($dty, f32),)* }
            )*
            table! { f32; $($name { $($field: $ty,)* })* $($dname { $($dfield: $dty,)* })* }
        }
        /// The same of the double-precision kernels.
        pub mod double {
            use bytemuck::{Pod, Zeroable};
            $(
                $(#[$meta])*
                #[repr(C)]
                #[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
                pub struct $name { $($(#[$field_meta])* pub $field: rust_type!($ty, f64),)* }
            )*
            $(
                $(#[$dmeta])*
                #[repr(C)]
                #[derive(Debug, Clone, Copy, Default, PartialEq)]
                pub struct $dname { $($(#[$dfield_meta])* pub $dfield: rust_type!($dty, f64),)* }
            )*
            table! { f64; $($name { $($field: $ty,)* })* $($dname { $($dfield: $dty,)* })* }
        }
    };
}

pub use single::*;

gpu_structs! {
host {
    /// The eye in the local frame, 76 bytes (f64: 136). Written by `pack`, read by `generate`.
    /// A primary ray starts on the plane `advance` in front of the eye, which has all geometry
    /// behind it: its origin then rounds with the scene's size, not with the eye's distance
    /// (numerics.md, Camera).
    struct Camera {
        /// The eye moved `advance` along `forward`.
        origin: real3,
        /// Unit view direction.
        forward: real3,
        /// Image plane at distance 1: half its width.
        right: real3,
        /// Image plane at distance 1: half its height.
        up: real3,
        /// Distance from the eye to the start plane, >= 0.
        advance: real,
        /// 2 / image width.
        step_x: real,
        /// 2 / image height.
        step_y: real,
        /// Radiance of a ray that hits nothing.
        background_r: float,
        /// Green of the same.
        background_g: float,
        /// Blue of the same.
        background_b: float,
        /// Distance along a secondary ray to its origin where ORIGIN_FIXED is on (local units).
        origin_shift: float,
    }

    /// Three corners in the local frame and the plane's normal, all that a ray's test needs, and what the
    /// triangle belongs to, 64 bytes (f64: 112). Written by `pack`, read by `intersect`, `shade`, `shadow`.
    struct Triangle {
        /// Corner.
        a: real3,
        /// Unit normal from the corners in f64.
        normal_x: real,
        /// Corner.
        b: real3,
        /// Its y.
        normal_y: real,
        /// Corner.
        c: real3,
        /// Its z.
        normal_z: real,
        /// Index into `materials`.
        material: uint,
        /// Solid whose surface this is, from 1; 0 = none (opaque, or a thin sheet).
        solid: uint,
        /// INNER_AB, INNER_CA: edges inside a polygon, where no other surface meets this one.
        inner_edges: uint,
        /// Position in the scene's own order; ties in t go to the smallest.
        id: uint,
    }

    /// Shading normal of a flat triangle, 16 bytes (f64: 32). Written by `pack`, read by `shade`.
    struct FlatNormal {
        /// Unit length; given in the scene, or from the corners in f64.
        normal: real3,
        /// Unused; keeps the size a multiple of 16.
        pad: real,
    }

    /// Shading normals at the corners, 36 bytes; present only in scenes with smooth meshes. `a` is
    /// zero for a flat triangle.
    struct CornerNormals {
        /// At corner a.
        a: real3,
        /// At corner b.
        b: real3,
        /// At corner c.
        c: real3,
    }

    /// An analytic sphere in the local frame and what it belongs to, 32 bytes (f64: 48).
    struct Sphere {
        /// Centre.
        center: real3,
        /// Radius, > 0; negative for a sphere so large or small that its numbers are in `extended_spheres`.
        radius: real,
        /// Index into `materials`.
        material: uint,
        /// Solid whose surface this is, from 1; 0 = opaque.
        solid: uint,
        /// Index into `extended_spheres`, or NONE.
        wide: uint,
        /// Position in the scene's own order (after all triangles).
        id: uint,
    }

    /// A very large or very small sphere, 56 bytes (f64: 112), every number as an unevaluated sum of
    /// two. Written as its surface point nearest to the frame's origin and the normal there, so that
    /// |o - c|^2 - r^2 = |o - p|^2 + 2 r n.(o - p) cancels nothing near the surface.
    struct ExtendedSphere {
        /// Surface point nearest the origin.
        point: real3,
        /// What `point` rounds away.
        point_low: real3,
        /// Unit outward normal there.
        normal: real3,
        /// What `normal` rounds away.
        normal_low: real3,
        /// Radius.
        radius: real,
        /// What `radius` rounds away.
        radius_low: real,
    }

    /// Up to four children of a BVH with their boxes, 112 bytes (f64: 208). Boxes are rounded outward and
    /// padded (numerics.md, Boxes). A child is an inner node's index, or a leaf: LEAF_BIT | (count - 1)
    /// << 27 | first primitive; a leaf holds triangles or spheres, never both. An absent child has an
    /// inverted box, which no ray enters.
    struct Node {
        /// Least corner of child 0's box.
        lo_0: real3,
        /// Greatest corner of the same.
        hi_0: real3,
        /// Least corner of child 1's box.
        lo_1: real3,
        /// Greatest corner of the same.
        hi_1: real3,
        /// Least corner of child 2's box.
        lo_2: real3,
        /// Greatest corner of the same.
        hi_2: real3,
        /// Least corner of child 3's box.
        lo_3: real3,
        /// Greatest corner of the same.
        hi_3: real3,
        /// Child 0.
        child_0: uint,
        /// Child 1.
        child_1: uint,
        /// Child 2.
        child_2: uint,
        /// Child 3.
        child_3: uint,
    }

    /// A child of a compressed node of eight (Ylitie, Karras, Laine, "Efficient Incoherent Ray Traversal on GPUs
    /// Through Compressed Wide BVHs", HPG 2017), 16 bytes: a texel, which one lane of a packet fetches. Corners are
    /// steps on the node's grid, 10 bits an axis, x lowest, rounded outward; a coordinate is origin + steps * step,
    /// as the kernels round it. An absent child has the link NONE.
    struct CompressedChild {
        /// As a child of `Node`.
        link: uint,
        /// Least corner.
        lo: uint,
        /// Greatest corner.
        hi: uint,
        /// Bits of the node's grid, a number with each of its first six children: origin, step by axis.
        grid: uint,
    }

    /// A material, 32 bytes.
    struct Material {
        /// Linear RGB.
        diffuse: vec3,
        /// Own colour = `ambient * diffuse` + diffuse light.
        ambient: float,
        /// Weight of reflected and refracted light, in [0, 1].
        secondary: float,
        /// Share of reflection where `fresnel_kind` is FRESNEL_CONSTANT.
        fresnel: float,
        /// FRESNEL_CONSTANT, FRESNEL_SCHLICK or FRESNEL_EXACT.
        fresnel_kind: uint,
        /// Index of refraction inside.
        ior: float,
    }

    /// A point light, 28 bytes (f64: 40). `intensity` is in local units: world intensity * 4^scale_log2.
    struct Light {
        /// Local frame.
        position: real3,
        /// Linear RGB.
        intensity: vec3,
        /// Unused; keeps the size a multiple of 8.
        pad: uint,
    }

}
device {
    /// A ray in flight, 48 bytes (f64: 72). Written by `generate` and `spawn`, read by `intersect`, `shade`,
    /// `spawn`, `shadow`; or written and read by `fused_depth`. `direction` has unit length.
    struct Ray {
        /// Local frame.
        origin: real3,
        /// Unit length.
        direction: real3,
        /// Sample it belongs to, an index into `sample_radiance`.
        sample_index: uint,
        /// Primitive whose surface it starts on, or NONE.
        skip: uint,
        /// Product of weights from the camera.
        throughput: vec3,
        /// Unused; keeps the size a multiple of 16.
        pad: uint,
    }

    /// Closest hit, 16 bytes. Written by `intersect`, read by `shade`.
    struct Hit {
        /// Distance in units of the ray's direction.
        t: real,
        /// Barycentric weight of corner b (triangles).
        u: real,
        /// Barycentric weight of corner c (triangles).
        v: real,
        /// Triangle index, or triangle count + sphere index, or NONE.
        primitive: uint,
    }

    /// Where a ray struck, 64 bytes. Written by `shade`, read by `spawn` and `shadow`.
    struct Surface {
        /// Local frame.
        position: real3,
        /// Spawn offset: along the geometric normal, toward the side the ray came from.
        offset: real3,
        /// Unit shading normal, toward the side the ray came from.
        normal: real3,
        /// As in `Hit`.
        primitive: uint,
        /// Index into `materials`.
        material: uint,
        /// Bits 0-1: CHILD_REFLECTED, CHILD_REFRACTED; bit 2: LEAVES; bits 8-17: children of lower
        /// invocations of the workgroup. So far for `shadow`; the rest is for `spawn` alone.
        flags: uint,
        /// Share of reflection in the secondary weight.
        share: float,
        /// Index of refraction here over the one beyond.
        eta: real,
        /// Cosine between the ray and `normal`, >= 0.
        cosine: real,
        /// Solid entered or left by a refracted ray, from 1; 0 = none.
        solid: uint,
    }

    /// A queue of rays with the size of its dispatch, 20 bytes. Written by the host (depth 1) and
    /// `scan`; its first three words are a VkDispatchIndirectCommand.
    struct Queue {
        /// Workgroups along x.
        groups_x: uint,
        /// Workgroups along y.
        groups_y: uint,
        /// Workgroups along z: 1.
        groups_z: uint,
        /// Live rays.
        count: uint,
        /// Those of them that are reflection rays.
        reflections: uint,
    }

    /// Running sum of a pixel's samples, 24 bytes: Neumaier's sum and compensation (numerics.md, Accumulation).
    struct Film {
        /// Sum, linear RGB.
        sum: vec3,
        /// What rounding took from it.
        compensation: vec3,
    }

    /// Counts of one depth, 16 bytes; cleared by the host before each submit.
    struct DepthCount {
        /// Rays of any kind but shadow rays.
        traced: uint,
        /// Reflection rays among them.
        reflections: uint,
        /// Refraction rays among them.
        refractions: uint,
        /// Shadow rays cast from their hits.
        shadow: uint,
    }

    /// What the path tree of one sample did, 16 bytes; of surveys only. Kept by integer atomics, so in
    /// any order.
    struct Path {
        /// Sum of a hash of each ray: what it struck, how it goes on, which lights it sees.
        hash: uint,
        /// Rays traced, shadow rays included.
        rays: uint,
        /// Longest path.
        depth: uint,
        /// Throughput of the rays that were cut, in units of 1 / CUT_ONE, rounded up.
        cut: uint,
    }

    /// What the samples of one pixel did, 24 bytes; of surveys only. Begins as all zeros.
    struct Mark {
        /// Complement of the least hash of its samples.
        hash_least_inverted: uint,
        /// Greatest hash.
        hash_most: uint,
        /// Rays in all.
        rays: uint,
        /// Longest path.
        depth: uint,
        /// Sum of `cut`, low word.
        cut_low: uint,
        /// High word.
        cut_high: uint,
    }

    /// What a ray adds to its sample, 16 bytes. Written by `shadow` or `fused_depth`, read by `gather`.
    struct Contribution {
        /// Weighted colour.
        light: vec3,
        /// Sample it belongs to.
        sample_index: uint,
    }

    /// Push constants, 60 bytes.
    struct Push {
        /// Image coordinates of the tile's first pixel; 0 in a survey.
        tile_x: uint,
        /// Row of the same.
        tile_y: uint,
        /// Pixels per row of the tile; of the image in a survey.
        tile_width: uint,
        /// Pixels in the tile.
        tile_pixels: uint,
        /// First sample of the batch.
        first_sample: uint,
        /// Samples per pixel in the batch.
        batch_samples: uint,
        /// Samples per pixel in all.
        samples: uint,
        /// Seed of the sampler.
        seed: uint,
        /// Depth of the rays in `rays`, from 1.
        depth: uint,
        /// Depth whose secondary rays are not traced.
        last_depth: uint,
        /// Lights of this `shadow` pass: begin.
        light_begin: uint,
        /// Lights of this `shadow` pass: end.
        light_end: uint,
        /// Rays that fit a queue.
        capacity: uint,
        /// Items for kernels sized by the host.
        items: uint,
        /// Rays with less throughput are not spawned.
        cutoff: float,
    }
}
}

macro_rules! constants {
    ($($(#[$meta:meta])* $name:ident = $value:expr;)*) => {
        $($(#[$meta])* pub const $name: u32 = $value;)*
        /// All shared constants.
        pub const CONSTANTS: &[(&str, u32)] = &[$((stringify!($name), $name),)*];
    };
}

constants! {
    /// No primitive.
    NONE = 0xffff_ffff;
    /// `Node` child: set for a leaf.
    LEAF_BIT = 0x8000_0000;
    /// `Node` child that is a leaf: bits of the first primitive (triangle index, or triangle count + sphere index).
    LEAF_FIRST_BITS = 27;
    /// `Node` child that is a leaf: primitives at most.
    LEAF_MAX = 16;
    /// Entries of a traversal stack; `bvh` never builds what needs more.
    STACK_SIZE = 64;
    /// Entries of a packet's stack, at most: as many as 24 words of four lanes hold beside the one below all.
    PACKET_STACK_SIZE = 95;
    /// `Surface::flags`.
    CHILD_REFLECTED = 1;
    /// `Surface::flags`.
    CHILD_REFRACTED = 2;
    /// `Surface::flags`: the refracted ray leaves `solid`.
    LEAVES = 4;
    /// `Surface::flags`: a solid of higher priority hides this surface; the ray goes on unchanged.
    PASSES = 8;
    /// `Surface::flags`: shift of the local prefix.
    PREFIX_SHIFT = 8;
    /// `Material::fresnel_kind`.
    FRESNEL_CONSTANT = 0;
    /// `Material::fresnel_kind`.
    FRESNEL_SCHLICK = 1;
    /// `Material::fresnel_kind`.
    FRESNEL_EXACT = 2;
    /// Workgroups per row of a large dispatch: the least maxComputeWorkGroupCount Vulkan promises.
    GROUPS_PER_ROW = 65_535;
    /// Primitives whose tests brute force writes out one by one; more are a loop.
    UNROLL_MAX = 32;
    /// Invocations of `scan`, whose one workgroup walks the counts of all workgroups; the least maxComputeWorkGroupInvocations is 128.
    SCAN_WIDTH = 128;
    /// Invocations per workgroup at most; words of a child mask = this / 32.
    WORKGROUP_MAX = 256;
    /// Loop iterations of one traversal at most. lavapipe silently ends every loop of an invocation
    /// after 65,535 in all; a traversal that would come near it is counted in COUNTER_LOOP_CAP instead.
    LOOP_CAP = 60_000;
    /// Index into `counters`.
    COUNTER_NAN_RAYS = 0;
    /// Index into `counters`.
    COUNTER_CLAMPED_LIGHTS = 1;
    /// Index into `counters`.
    COUNTER_STACK_OVERFLOW = 2;
    /// Index into `counters`.
    COUNTER_LOOP_CAP = 3;
    /// Index into `counters`.
    COUNTER_MEDIA_OVERFLOW = 4;
    /// Index into `counters`: a queue was too small; the submit's tile is void and is traced again in smaller batches.
    COUNTER_QUEUE_OVERFLOW = 5;
    /// `Triangle::inner_edges`: the edge from a to b.
    INNER_AB = 1;
    /// `Triangle::inner_edges`: the edge from c to a.
    INNER_CA = 2;
    /// Binding of a buffer's texel view = this + the buffer's own.
    TEXELS_AT = 40;
    /// Numbers per item of `self_test`.
    SELF_TEST_ROW = 11;
    /// Length of `counters`.
    COUNTERS = 6;
    /// `Path::cut` of a throughput of 1. The throughputs that a sample loses sum to 1 at most, for a
    /// material's weights sum to 1: 32 bits hold four times that.
    CUT_ONE = 0x4000_0000;
    /// `sampler_kind`: independent samples.
    SAMPLER_RANDOM = 0;
    /// `sampler_kind`: progressive jittered samples.
    SAMPLER_STRATIFIED = 1;
    /// `sampler_kind`: Owen-scrambled Sobol points.
    SAMPLER_OWEN = 2;
}

macro_rules! specialisation {
    ($($(#[$meta:meta])* $name:ident: $default:expr;)*) => {
        /// Specialisation constants, in order of their ids (0 is the workgroup size).
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub struct Specialisation {
            $($(#[$meta])* pub $name: u32,)*
        }
        impl Specialisation {
            /// Ids and values.
            pub fn values(&self) -> Vec<(u32, u32)> {
                (0..).zip([$(self.$name,)*]).collect()
            }
        }
        impl Default for Specialisation {
            fn default() -> Self { Specialisation { $($name: $default,)* } }
        }
        /// Names and defaults in id order.
        pub const SPECIALISATION: &[(&str, u32)] = &[$((stringify!($name), $default),)*];
    };
}

specialisation! {
    /// Invocations per workgroup of the kernels that work on rays or pixels.
    workgroup: 64;
    /// Triangles in the scene.
    triangle_count: 0;
    /// Spheres in the scene.
    sphere_count: 0;
    /// Point lights in the scene.
    light_count: 0;
    /// 1: walk the BVH; 0: test every primitive.
    use_bvh: 0;
    /// 1: some triangle has corner normals.
    smooth_normals: 0;
    /// Solids a ray can be in at once; 0 if nothing refracts.
    media_capacity: 0;
    /// 1: some sphere is in `extended_spheres`.
    extended_spheres_used: 0;
    /// 1: zero edge functions are decided exactly and hits confined to their boxes; 0: neither.
    robust: 1;
    /// 1: secondary rays start `origin_shift` along their direction and may hit what they left.
    origin_fixed: 0;
    /// 1: a hit may spawn two rays, so that several rays of one sample share a depth.
    branching: 0;
    /// Loop cap of one traversal.
    loop_cap: 60_000;
    /// SAMPLER_RANDOM, SAMPLER_STRATIFIED or SAMPLER_OWEN; `sampler` is a word of GLSL.
    sampler_kind: SAMPLER_OWEN;
    /// Independently scrambled sequences that a pixel's samples are dealt to, at least 1; `film` keeps
    /// their sums apart.
    replicates: 1;
    /// 1: trace listed pixels and record what their paths do.
    survey: 0;
    /// 1: what a ray looks up is read through texel views of the buffers; 0: as storage buffers.
    texels: 0;
    /// Invocations of a subgroup, where they work together; 0: each on its own.
    lanes: 0;
    /// Entries that a packet's stack holds at most; enough for this hierarchy.
    stack_size: STACK_SIZE;
    /// 1: the triangles are few and outside the hierarchy.
    triangles_outside: 0;
    /// 1: the spheres are few and outside the hierarchy.
    spheres_outside: 0;
    /// 1: `fused_depth` does what `intersect`, `shade`, `spawn` and `shadow` do; `child_masks` are used instead of `child_counts`.
    fused: 0;
}

macro_rules! buffers {
    ($($(#[$meta:meta])* $name:ident / $variant:ident: $element:literal;)*) => {
        /// A storage buffer of the frame; its number is its binding.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[repr(u32)]
        pub enum Buf { $($(#[$meta])* $variant,)* }
        /// Names (as the kernels spell them), element types and handles, in binding order.
        pub const BUFFERS: &[(&str, &str, Buf)] = &[$((stringify!($name), $element, Buf::$variant),)*];
    };
}

buffers! {
    /// One `Camera`.
    camera / Camera: "Camera";
    /// Triangles in leaf order.
    triangles / Triangles: "Triangle";
    /// Parallel to `triangles`.
    flat_normals / FlatNormals: "FlatNormal";
    /// Parallel to `triangles`; one unused element where no mesh is smooth.
    corner_normals / CornerNormals: "CornerNormals";
    /// Spheres in leaf order.
    spheres / Spheres: "Sphere";
    /// The spheres that need two numbers each for one.
    extended_spheres / ExtendedSpheres: "ExtendedSphere";
    /// BVH, root first.
    nodes / Nodes: "Node";
    /// The BVH's nodes as packets of rays read them, eight children each, root first.
    compressed_nodes / CompressedNodes: "CompressedChild";
    /// Materials.
    materials / Materials: "Material";
    /// Lights.
    lights / Lights: "Light";
    /// Solid's index of refraction, by solid number; element 0 is the surrounding space.
    solid_iors / SolidIors: "float";
    /// Solid's priority, by solid number; element 0 is the surrounding space.
    solid_priorities / SolidPriorities: "int";
    /// Solids the eye is in, outermost first, `media_capacity` words.
    eye_media / EyeMedia: "uint";
    /// Pixels of the tile, row * image width + column; of surveys only.
    pixels / Pixels: "uint";
    /// Rays of this depth; where kernels are fused, the children of ray i at places 2 i and 2 i + 1, or at i where none branches.
    rays / Rays: "Ray";
    /// Rays of the next depth.
    next_rays / NextRays: "Ray";
    /// Solids each ray is in, outermost first, `media_capacity` words a ray, 0 = none.
    media / Media: "uint";
    /// The same for the next depth.
    next_media / NextMedia: "uint";
    /// Size of `rays`.
    queue / Queue: "Queue";
    /// Size of `next_rays`.
    next_queue / NextQueue: "Queue";
    /// Parallel to `rays`; between split kernels.
    hits / Hits: "Hit";
    /// Parallel to `rays`; between split kernels.
    surfaces / Surfaces: "Surface";
    /// Children of each workgroup of `shade`: reflections << 16 | refractions.
    child_counts / ChildCounts: "uint";
    /// Which children the rays of each subgroup of `fused_depth` have: bit `lane` a reflection ray, bit 16 + `lane` a refraction ray.
    child_masks / ChildMasks: "uint";
    /// Exclusive prefix sum over the children of workgroups: where a workgroup's children start in `next_rays`.
    offsets / Offsets: "uint";
    /// Where in `rays` each ray of the queue is, where kernels are fused; of depths from 2 on.
    ray_indices / RayIndices: "uint";
    /// Weighted own colour of each ray and its sample, in the queue's order; used from depth 2 on where rays branch, or where lights come in several passes.
    contributions / Contributions: "Contribution";
    /// Radiance of each sample of the batch.
    sample_radiance / SampleRadiance: "vec3";
    /// What the path tree of each sample of the batch did; of surveys only.
    paths / Paths: "Path";
    /// Running sum of each pixel of the tile, `replicates` of them a pixel.
    film / Film: "Film";
    /// What the samples of each pixel of the tile did; of surveys only.
    marks / Marks: "Mark";
    /// One `DepthCount` per depth.
    depth_counts / DepthCounts: "DepthCount";
    /// Counters.
    counters / Counters: "uint";
    /// Operands and results of `self_test`; outside the frame.
    self_test / SelfTest: "real";
}

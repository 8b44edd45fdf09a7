//! Specialisation constants: numbers that are fixed when a pipeline is created.

use super::constants::{LAYER_LIGHT, SAMPLER_OWEN, STACK_SIZE};

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
            /// Running sums of one pixel in `film`.
            pub fn film_sums(&self) -> u32 {
                self.replicates * self.parts
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
    /// Steps of the walks of one invocation after which they stop, unfinished.
    loop_cap: 60_000;
    /// SAMPLER_RANDOM, SAMPLER_STRATIFIED or SAMPLER_OWEN; `sampler` is a word of GLSL.
    sampler_kind: SAMPLER_OWEN;
    /// Independently scrambled sequences that a pixel's samples are dealt to, at least 1; `film` keeps
    /// their sums apart.
    replicates: 1;
    /// Consecutive parts of a pixel's samples whose sums `film` keeps apart; 1 with several replicates.
    parts: 1;
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
    /// 1: box and primitive tests are counted.
    counting: 0;
    /// What the rays of a sample add up to: LAYER_LIGHT, or, where only first surfaces are traced, LAYER_PLACE or LAYER_NORMAL.
    surface_layer: LAYER_LIGHT;
    /// 1: `fused_depth` does what `intersect`, `shade`, `spawn` and `shadow` do; `child_masks` are used instead of `child_counts`.
    fused: 0;
}

//! Numbers that both sides use.

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
    /// `Node` child that is a leaf: greatest number of primitives.
    LEAF_MAX = 16;
    /// Entries of a traversal stack; `bvh` never builds a hierarchy that needs more.
    STACK_SIZE = 64;
    /// Greatest number of entries of a packet's stack: 24 words of four lanes, less the entry below all others.
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
    /// Greatest number of primitives for which brute force unrolls its loop.
    UNROLL_MAX = 32;
    /// Invocations of `scan`, whose one workgroup walks the counts of all workgroups; the least maxComputeWorkGroupInvocations is 128.
    SCAN_WIDTH = 128;
    /// Greatest number of invocations per workgroup; words of a child mask = this / 32.
    WORKGROUP_MAX = 256;
    /// Greatest number of loop iterations of one invocation. lavapipe silently ends every loop of an invocation
    /// after 65,535 in all, counted for a vector of lanes; what is left is for what no kernel counts: the leaf in
    /// hand when a walk stops, at most LEAF_MAX for each entry of a stack, and loops over a few solids or lights.
    LOOP_CAP = 60_000;
    /// Words of a walk that goes on in another dispatch: its stack, or a lane's rows of a packet's, and four numbers.
    WALK_WORDS = 68;
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
    /// Index into `counters`: walks that took more steps than a dispatch may; the submit is void and is done again in parts.
    COUNTER_UNFINISHED = 6;
    /// `Triangle::inner_edges`: the edge from a to b.
    INNER_AB = 1;
    /// `Triangle::inner_edges`: the edge from c to a.
    INNER_CA = 2;
    /// Binding of a buffer's texel view = this + the buffer's own.
    TEXELS_AT = 40;
    /// Numbers per item of `self_test`.
    SELF_TEST_ROW = 11;
    /// Parts of the samples of a survey without replicates (src/accuracy/sampling.rs).
    PARTS = 4;
    /// Counters at the start of `counters`.
    COUNTERS = 7;
    /// `Path::cut` of a throughput of 1. The throughputs that a sample loses sum to 1 at most, for a
    /// material's weights sum to 1: 32 bits hold four times that.
    CUT_ONE = 0x4000_0000;
    /// `Ray::kind`: from the camera.
    RAY_PRIMARY = 0;
    /// `Ray::kind`: reflected.
    RAY_REFLECTION = 1;
    /// `Ray::kind`: refracted.
    RAY_REFRACTION = 2;
    /// Kind of a shadow ray, which is in no queue.
    RAY_SHADOW = 3;
    /// Kinds of rays.
    RAY_KINDS = 4;
    /// Words for the tests of one kind at one depth: box tests and primitive tests, low word first.
    TEST_WORDS = 4;
    /// `surface_layer`: light.
    LAYER_LIGHT = 0;
    /// `surface_layer`: distance along the view in local units, 1, index of the material; zeros where nothing is met.
    LAYER_PLACE = 1;
    /// `surface_layer`: shading normal on the ray's side; zeros where nothing is met.
    LAYER_NORMAL = 2;
    /// `sampler_kind`: independent samples.
    SAMPLER_RANDOM = 0;
    /// `sampler_kind`: progressive jittered samples.
    SAMPLER_STRATIFIED = 1;
    /// `sampler_kind`: Owen-scrambled Sobol points.
    SAMPLER_OWEN = 2;
}

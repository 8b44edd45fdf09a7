//! Storage buffers and their binding numbers.

macro_rules! buffers {
    ($($(#[$meta:meta])* $name:ident / $variant:ident: $element:literal;)*) => {
        /// A storage buffer of the passes; its number is its binding.
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
    /// Where walks are that go on in another dispatch, WALK_WORDS words each; of batches whose walks do not end in one.
    walks / Walks: "uint";
    /// Running sums of each pixel of the tile, `replicates` * `parts` a pixel.
    film / Film: "Film";
    /// What the samples of each pixel of the tile did; of surveys only.
    marks / Marks: "Mark";
    /// One `DepthCount` per depth.
    depth_counts / DepthCounts: "DepthCount";
    /// Counters; where tests are counted, then TEST_WORDS for each depth and kind of ray.
    counters / Counters: "uint";
    /// Operands and results of `self_test`; outside the frame.
    self_test / SelfTest: "real";
}

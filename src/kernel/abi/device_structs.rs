//! Structs that exist only on the device: rays, hits, sums and counts. Also `Queue` and `Push`,
//! which the host writes as well but which have no `real` fields.

use super::GpuStruct;

device_structs! {
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
        /// RAY_PRIMARY, RAY_REFLECTION or RAY_REFRACTION where tests are counted, else 0; the size is a multiple of 16.
        kind: uint,
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
        /// Sum of the rounding errors of `sum`.
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

    /// Hash and counts of the path tree of one sample, 16 bytes; in surveys only. Updated by integer
    /// atomics, whose order does not matter.
    struct Path {
        /// Sum of a hash of each ray: its primitive, its children, the lights it sees.
        hash: uint,
        /// Rays traced, shadow rays included; where tests are counted, box and primitive tests instead.
        rays: uint,
        /// Longest path.
        depth: uint,
        /// Throughput of the rays that were cut, in units of 1 / CUT_ONE, rounded up.
        cut: uint,
    }

    /// Hashes and counts of the samples of one pixel, 24 bytes; in surveys only. Begins as all zeros.
    struct Mark {
        /// Complement of the least hash of its samples.
        hash_least_inverted: uint,
        /// Greatest hash.
        hash_most: uint,
        /// Sum of the samples' rays.
        rays: uint,
        /// Longest path.
        depth: uint,
        /// Sum of `cut`, low word.
        cut_low: uint,
        /// High word.
        cut_high: uint,
    }

    /// Light that a ray adds to its sample, 16 bytes. Written by `shadow` or `fused_depth`, read by `gather`.
    struct Contribution {
        /// Weighted colour.
        light: vec3,
        /// Sample it belongs to.
        sample_index: uint,
    }

    /// Push constants, 76 bytes.
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
        /// First sample of the range that the film sums.
        range_first: uint,
        /// Samples per pixel in that range.
        range_samples: uint,
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
        /// First ray of the queue that `walk` works on.
        walk_first: uint,
        /// How often these walks were dispatched before.
        walk_round: uint,
    }
}

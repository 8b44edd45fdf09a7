//! Structs that the host fills: the scene and the camera.

use super::GpuStruct;

host_structs! {
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

    /// Three corners in the local frame and the plane's normal, which the intersection test reads; material and
    /// solid; 64 bytes (f64: 112). Written by `pack`, read by `intersect`, `shade`, `shadow`.
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

    /// An analytic sphere in the local frame with its material and solid, 32 bytes (f64: 48).
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
        /// Remainder of `point` after rounding.
        point_low: real3,
        /// Unit outward normal there.
        normal: real3,
        /// Remainder of `normal` after rounding.
        normal_low: real3,
        /// Radius.
        radius: real,
        /// Remainder of `radius` after rounding.
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

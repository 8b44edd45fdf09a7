//! Twin of `glsl/light.comp`.

use super::lib::light::Lit;
use super::lib::traverse::Shapes;
use super::structs::{
    Camera, Contribution, DepthCount, Hit, Light, Material, Path, Push, Queue, Ray, Sphere, Surface, Triangle,
};
use crate::kernel::abi::{NONE, Specialisation};

/// Own colour of every struck surface, by what `walk` has found.
pub fn light(
    spec: &Specialisation,
    push: &Push,
    camera: &[Camera],
    triangles: &[Triangle],
    spheres: &[Sphere],
    materials: &[Material],
    lights: &[Light],
    rays: &[Ray],
    queue: &[Queue],
    hits: &[Hit],
    surfaces: &[Surface],
    contributions: &mut [Contribution],
    sample_radiance: &mut [[f32; 3]],
    paths: &mut [Path],
    depth_counts: &mut [DepthCount],
    counters: &mut [u32],
) {
    let shapes =
        Shapes { spec, triangles, spheres, extended_spheres: &[], nodes: &[], compressed_nodes: &[] };
    let queries = &mut Vec::new();
    let (first, last) = (push.light_begin == 0, push.light_end == spec.light_count);
    let camera = &camera[0];
    let mut lit = Lit {
        shapes,
        push,
        camera,
        lights,
        contributions,
        sample_radiance,
        paths,
        depth_counts,
        counters,
        answers: Some(hits),
        queries,
    };
    for i in 0..queue[0].count as usize {
        let s = &surfaces[i];
        let m = &materials[if s.primitive != NONE { s.material as usize } else { 0 }];
        lit.light_up(i, &rays[i], s, m, first, last);
    }
}

//! Twin of `glsl/intersect.comp`.

use super::lib::count_tests::{Query, note_tests};
use super::lib::traverse::{Shapes, make_traversal_ray};
use super::real::FAR;
use super::structs::{ExtendedSphere, Hit, Node, Path, Push, Queue, Ray, Sphere, Triangle};
use crate::kernel::abi::Specialisation;
use crate::kernel::abi::single::CompressedChild;

/// Closest hit of every ray in the queue.
pub fn intersect(
    spec: &Specialisation,
    push: &Push,
    triangles: &[Triangle],
    spheres: &[Sphere],
    extended_spheres: &[ExtendedSphere],
    nodes: &[Node],
    compressed_nodes: &[CompressedChild],
    rays: &[Ray],
    queue: &[Queue],
    hits: &mut [Hit],
    paths: &mut [Path],
    counters: &mut [u32],
) {
    let shapes = Shapes { spec, triangles, spheres, extended_spheres, nodes, compressed_nodes };
    let mut queries = Vec::new();
    for i in 0..queue[0].count as usize {
        let r = make_traversal_ray(rays[i].origin.into(), rays[i].direction.into(), rays[i].skip);
        hits[i] = shapes.closest_hit(&r, FAR, false, counters);
        let Ray { sample_index, kind, .. } = rays[i];
        queries.push(Query { ray: r, limit: FAR, any: false, sample_index, kind });
    }
    if spec.counting != 0 {
        note_tests(&shapes, push, &queries, 1, paths, counters);
    }
}

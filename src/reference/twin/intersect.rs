//! Twin of `glsl/intersect.comp`.

use super::lib::traverse::{Shapes, make_traversal_ray};
use super::real::FAR;
use super::structs::{ExtendedSphere, Hit, Node, Queue, Ray, Sphere, Triangle};
use crate::kernel::abi::Specialisation;

/// Closest hit of every ray in the queue.
pub fn intersect(
    spec: &Specialisation,
    triangles: &[Triangle],
    spheres: &[Sphere],
    extended_spheres: &[ExtendedSphere],
    nodes: &[Node],
    rays: &[Ray],
    queue: &[Queue],
    hits: &mut [Hit],
    counters: &mut [u32],
) {
    let shapes = Shapes { spec, triangles, spheres, extended_spheres, nodes };
    for i in 0..queue[0].count as usize {
        let r = make_traversal_ray(rays[i].origin.into(), rays[i].direction.into(), rays[i].skip);
        hits[i] = shapes.closest_hit(&r, FAR, false, counters);
    }
}

//! Twin of `glsl/walk.comp`. Walks end in the round that begins them.

use super::lib::count_tests::{Query, note_tests};
use super::lib::light::{may_be_lit, no_query, shadow_ray};
use super::lib::traverse::{Shapes, make_traversal_ray};
use super::real::FAR;
use super::structs::{
    Camera, ExtendedSphere, Hit, Light, Material, Node, Path, Push, Queue, Ray, Sphere, Surface, Triangle,
};
use crate::kernel::abi::single::CompressedChild;
use crate::kernel::abi::{NONE, RAY_SHADOW, Specialisation};

/// What some rays of the queue, or the shadow rays from what they struck, hit.
pub fn walk(
    spec: &Specialisation,
    push: &Push,
    camera: &[Camera],
    triangles: &[Triangle],
    spheres: &[Sphere],
    extended_spheres: &[ExtendedSphere],
    nodes: &[Node],
    compressed_nodes: &[CompressedChild],
    materials: &[Material],
    lights: &[Light],
    rays: &[Ray],
    queue: &[Queue],
    surfaces: &[Surface],
    hits: &mut [Hit],
    paths: &mut [Path],
    counters: &mut [u32],
) {
    if push.walk_round != 0 {
        return;
    }
    let shapes = Shapes { spec, triangles, spheres, extended_spheres, nodes, compressed_nodes };
    let mut queries = Vec::new();
    let end = queue[0].count.min(push.walk_first + push.items);
    for i in push.walk_first as usize..end as usize {
        let Ray { sample_index, kind, .. } = rays[i];
        if push.light_end == 0 {
            let r = make_traversal_ray(rays[i].origin.into(), rays[i].direction.into(), rays[i].skip);
            hits[i] = shapes.closest_hit(&r, FAR, false, counters);
            queries.push(Query { ray: r, limit: FAR, any: false, sample_index, kind });
            continue;
        }
        let (s, l) = (&surfaces[i], push.light_end - 1);
        let m = &materials[if s.primitive != NONE { s.material as usize } else { 0 }];
        let bit = 1 << (l - push.light_begin);
        let mut hidden = if l == push.light_begin { 0 } else { hits[i].primitive };
        let mut query = no_query(sample_index);
        let to = if may_be_lit(s, m) {
            shadow_ray(spec, &lights[l as usize], s, camera[0].origin_shift)
        } else {
            None
        };
        if let Some(to) = to {
            query = Query { ray: to.ray, limit: to.limit, any: true, sample_index, kind: RAY_SHADOW };
            let found = shapes.closest_hit(&to.ray, to.limit, true, counters).primitive != NONE;
            hidden |= if found { bit } else { 0 };
        }
        hits[i].primitive = hidden;
        queries.push(query);
    }
    if spec.counting != 0 {
        note_tests(&shapes, push, &queries, 1, paths, counters);
    }
}

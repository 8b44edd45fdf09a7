//! Twin of `glsl/fused_depth.comp`.

use super::lib::count_tests::{Query, note_tests};
use super::lib::light::{Lit, lights_of};
use super::lib::spawn::{Nursery, spawn};
use super::lib::strike::Scene;
use super::lib::traverse::{Shapes, make_traversal_ray};
use super::real::FAR;
use super::structs::{
    Camera, Contribution, CornerNormals, DepthCount, ExtendedSphere, FlatNormal, Light, Material, Node, Path,
    Push, Queue, Ray, Sphere, Triangle,
};
use crate::kernel::abi::single::CompressedChild;
use crate::kernel::abi::{CHILD_REFLECTED, CHILD_REFRACTED, NONE, Specialisation};

/// One depth of every ray in the queue: closest hit, surface, children and own colour. Which children a subgroup's
/// rays have is a word, as in glsl/lib/base/children.glsl.
pub fn fused_depth(
    spec: &Specialisation,
    push: &Push,
    camera: &[Camera],
    triangles: &[Triangle],
    flat_normals: &[FlatNormal],
    corner_normals: &[CornerNormals],
    spheres: &[Sphere],
    extended_spheres: &[ExtendedSphere],
    nodes: &[Node],
    compressed_nodes: &[CompressedChild],
    materials: &[Material],
    lights: &[Light],
    solid_iors: &[f32],
    solid_priorities: &[i32],
    rays: &[Ray],
    next_rays: &mut [Ray],
    media: &[u32],
    next_media: &mut [u32],
    queue: &[Queue],
    child_masks: &mut [u32],
    ray_indices: &[u32],
    contributions: &mut [Contribution],
    sample_radiance: &mut [[f32; 3]],
    paths: &mut [Path],
    depth_counts: &mut [DepthCount],
    counters: &mut [u32],
) {
    let (count, capacity) = (queue[0].count as usize, spec.media_capacity as usize);
    let (lanes, most) = (spec.lanes as usize, 1 + usize::from(spec.branching != 0));
    let scene = Scene {
        spec,
        push,
        triangles,
        flat_normals,
        corner_normals,
        spheres,
        extended_spheres,
        materials,
        solid_iors,
        solid_priorities,
    };
    let shapes = Shapes { spec, triangles, spheres, extended_spheres, nodes, compressed_nodes };
    let (mut queries, mut shadow_queries) = (Vec::new(), Vec::new());
    let camera = &camera[0];
    // All subgroups of a workgroup have their word.
    child_masks[..count.next_multiple_of(spec.workgroup as usize) / lanes].fill(0);
    for i in 0..count {
        let place = if push.depth == 1 { i } else { ray_indices[i] as usize };
        let (ray, inside) = (&rays[place], &media[place * capacity..(place + 1) * capacity]);
        let r = make_traversal_ray(ray.origin.into(), ray.direction.into(), ray.skip);
        let h = shapes.closest_hit(&r, FAR, false, counters);
        let Ray { sample_index, kind, .. } = *ray;
        queries.push(Query { ray: r, limit: FAR, any: false, sample_index, kind });
        let s = scene.strike(ray, inside, &h, paths);
        let m = &materials[if s.primitive != NONE { s.material as usize } else { 0 }];
        let mut next = Nursery { rays: next_rays, media: next_media, counters };
        spawn(spec, camera, &s, ray, m.secondary, inside, i * most, &mut next);
        let bit = |flag, shift| u32::from(s.flags & flag != 0) << (shift + i % lanes);
        child_masks[i / lanes] |= bit(CHILD_REFLECTED, 0) | bit(CHILD_REFRACTED, 16);
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
            answers: None,
            queries: &mut shadow_queries,
        };
        lit.light_up(i, ray, &s, m, true, true);
    }
    if spec.counting != 0 {
        note_tests(&shapes, push, &queries, 1, paths, counters);
        note_tests(&shapes, push, &shadow_queries, lights_of(push), paths, counters);
    }
}

//! Twin of `glsl/shade.comp`.

use super::lib::strike::Scene;
use super::structs::{
    CornerNormals, ExtendedSphere, FlatNormal, Hit, Material, Path, Push, Queue, Ray, Sphere, Surface,
    Triangle,
};
use crate::kernel::abi::{CHILD_REFLECTED, CHILD_REFRACTED, PREFIX_SHIFT, Specialisation};

/// Turns hits into surfaces, and counts the children of each workgroup.
pub fn shade(
    spec: &Specialisation,
    push: &Push,
    triangles: &[Triangle],
    flat_normals: &[FlatNormal],
    corner_normals: &[CornerNormals],
    spheres: &[Sphere],
    extended_spheres: &[ExtendedSphere],
    materials: &[Material],
    solid_iors: &[f32],
    solid_priorities: &[i32],
    rays: &[Ray],
    media: &[u32],
    queue: &[Queue],
    hits: &[Hit],
    surfaces: &mut [Surface],
    child_counts: &mut [u32],
    paths: &mut [Path],
) {
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
    let (count, capacity) = (queue[0].count as usize, spec.media_capacity as usize);
    for (group, begin) in (0..count).step_by(spec.workgroup as usize).enumerate() {
        let (mut reflections, mut refractions) = (0, 0);
        for i in begin..count.min(begin + spec.workgroup as usize) {
            let mut s = scene.strike(&rays[i], &media[i * capacity..(i + 1) * capacity], &hits[i], paths);
            let children = s.flags;
            s.flags |= (reflections + refractions) << PREFIX_SHIFT;
            surfaces[i] = s;
            reflections += u32::from(children & CHILD_REFLECTED != 0);
            refractions += u32::from(children & CHILD_REFRACTED != 0);
        }
        child_counts[group] = reflections << 16 | refractions;
    }
}

//! Twin of `glsl/spawn.comp`.

use super::lib::spawn::{self, Nursery};
use super::structs::{Camera, Material, Queue, Ray, Surface};
use crate::kernel::abi::{CHILD_REFLECTED, CHILD_REFRACTED, NONE, PREFIX_SHIFT, Specialisation};

/// Reflection and refraction rays of the next depth.
pub fn spawn(
    spec: &Specialisation,
    camera: &[Camera],
    materials: &[Material],
    rays: &[Ray],
    media: &[u32],
    queue: &[Queue],
    next_queue: &[Queue],
    surfaces: &[Surface],
    offsets: &[u32],
    next_rays: &mut [Ray],
    next_media: &mut [u32],
    counters: &mut [u32],
) {
    if next_queue[0].count == 0 {
        return;
    }
    let capacity = spec.media_capacity as usize;
    let mut next = Nursery { rays: next_rays, media: next_media, counters };
    for i in 0..queue[0].count as usize {
        let s = &surfaces[i];
        if s.primitive == NONE || s.flags & (CHILD_REFLECTED | CHILD_REFRACTED) == 0 {
            continue;
        }
        let inside = &media[i * capacity..(i + 1) * capacity];
        let to = (offsets[i / spec.workgroup as usize] + (s.flags >> PREFIX_SHIFT)) as usize;
        let secondary = materials[s.material as usize].secondary;
        spawn::spawn(spec, &camera[0], s, &rays[i], secondary, inside, to, &mut next);
    }
}

//! Twin of `glsl/spawn.comp`.

use super::lib::fresnel::{reflected, refracted};
use super::lib::numeric::{dot3, safe_normalize};
use super::lib::surface::spawn_origin;
use super::real::{Real3, U, Vec3};
use super::structs::{Camera, Material, Queue, Ray, Surface};
use crate::abi::{
    CHILD_REFLECTED, CHILD_REFRACTED, COUNTER_MEDIA_OVERFLOW, LEAVES, NONE, PASSES, PREFIX_SHIFT,
    Specialisation,
};

fn above(spec: &Specialisation, direction: Real3, offset: Real3) -> Real3 {
    if spec.smooth_normals == 0 {
        return direction;
    }
    let n = safe_normalize(offset);
    let height = dot3(direction, n);
    if height < 4.0 * U { safe_normalize(direction + (4.0 * U - height) * n) } else { direction }
}

/// The list without `solid`, or with it as the last.
fn change_media(from: &[u32], to: &mut [u32], solid: u32, leaves: bool, counters: &mut [u32]) {
    let mut n = 0;
    for m in from {
        if *m != 0 && *m != solid {
            to[n] = *m;
            n += 1;
        }
    }
    if !leaves {
        if n < to.len() {
            to[n] = solid;
            n += 1;
        } else {
            counters[COUNTER_MEDIA_OVERFLOW as usize] += 1;
        }
    }
    to[n..].fill(0);
}

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
    let (fixed, shift) = (spec.origin_fixed != 0, camera[0].origin_shift);
    for i in 0..queue[0].count as usize {
        let s = &surfaces[i];
        if s.primitive == NONE || s.flags & (CHILD_REFLECTED | CHILD_REFRACTED) == 0 {
            continue;
        }
        let (position, offset, normal) =
            (Real3::from(s.position), Real3::from(s.offset), Real3::from(s.normal));
        let d = Real3::from(rays[i].direction);
        let mut throughput = Vec3::from(rays[i].throughput);
        if s.flags & PASSES == 0 {
            throughput *= materials[s.material as usize].secondary;
        }
        let skip = if fixed { NONE } else { s.primitive };
        let slot = rays[i].slot;
        let child = |w: Real3, weight: f32| Ray {
            origin: spawn_origin(position, offset, w, fixed, shift).into(),
            direction: w.into(),
            slot,
            skip,
            throughput: (weight * throughput).into(),
            pad: 0,
        };
        let inside = &media[i * capacity..(i + 1) * capacity];
        let mut to = (offsets[i / spec.workgroup as usize] + (s.flags >> PREFIX_SHIFT)) as usize;
        if s.flags & CHILD_REFLECTED != 0 {
            let w = above(spec, reflected(d, normal, s.cosine), offset);
            next_rays[to] = child(w, s.share);
            next_media[to * capacity..(to + 1) * capacity].copy_from_slice(inside);
            to += 1;
        }
        if s.flags & CHILD_REFRACTED != 0 {
            let w = if s.eta == 1.0 { d } else { refracted(d, normal, s.eta, s.cosine) };
            next_rays[to] = child(w, 1.0 - s.share);
            let list = &mut next_media[to * capacity..(to + 1) * capacity];
            if s.solid != 0 {
                change_media(inside, list, s.solid, s.flags & LEAVES != 0, counters);
            } else {
                list.copy_from_slice(inside);
            }
        }
    }
}

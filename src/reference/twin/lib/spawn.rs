//! Twin of `glsl/lib/optics/spawn.glsl`.

use super::super::real::{Real3, U, Vec3};
use super::super::structs::{Camera, Ray, Surface};
use super::fresnel::{reflected, refracted};
use super::numeric::{dot3, safe_normalize};
use super::surface::spawn_origin;
use crate::kernel::abi::{
    CHILD_REFLECTED, CHILD_REFRACTED, COUNTER_MEDIA_OVERFLOW, LEAVES, NONE, PASSES, RAY_REFLECTION,
    RAY_REFRACTION, Specialisation,
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

/// Where children go: their rays and their lists of solids.
pub struct Nursery<'a> {
    /// By place.
    pub rays: &'a mut [Ray],
    /// Their lists of solids.
    pub media: &'a mut [u32],
    /// By `COUNTER_…`.
    pub counters: &'a mut [u32],
}

/// Children of `ray` at surface `s`, from place `to` on, reflection first. `inside` is the ray's list of solids,
/// `secondary` the material's weight.
pub fn spawn(
    spec: &Specialisation,
    camera: &Camera,
    s: &Surface,
    ray: &Ray,
    secondary: f32,
    inside: &[u32],
    mut to: usize,
    next: &mut Nursery<'_>,
) {
    let capacity = spec.media_capacity as usize;
    let (fixed, shift) = (spec.origin_fixed != 0, camera.origin_shift);
    let (position, offset, normal) = (Real3::from(s.position), Real3::from(s.offset), Real3::from(s.normal));
    let d = Real3::from(ray.direction);
    let mut throughput = Vec3::from(ray.throughput);
    if s.flags & PASSES == 0 {
        throughput *= secondary;
    }
    let skip = if fixed { NONE } else { s.primitive };
    let child = |w: Real3, weight: f32, kind: u32| Ray {
        origin: spawn_origin(position, offset, w, fixed, shift).into(),
        direction: w.into(),
        sample_index: ray.sample_index,
        skip,
        throughput: (weight * throughput).into(),
        kind: if spec.counting != 0 { kind } else { 0 },
    };
    if s.flags & CHILD_REFLECTED != 0 {
        let w = above(spec, reflected(d, normal, s.cosine), offset);
        next.rays[to] = child(w, s.share, RAY_REFLECTION);
        next.media[to * capacity..(to + 1) * capacity].copy_from_slice(inside);
        to += 1;
    }
    if s.flags & CHILD_REFRACTED != 0 {
        let w = if s.eta == 1.0 { d } else { refracted(d, normal, s.eta, s.cosine) };
        next.rays[to] = child(w, 1.0 - s.share, RAY_REFRACTION);
        let list = &mut next.media[to * capacity..(to + 1) * capacity];
        if s.solid != 0 {
            change_media(inside, list, s.solid, s.flags & LEAVES != 0, next.counters);
        } else {
            list.copy_from_slice(inside);
        }
    }
}

//! Twin of `glsl/generate.comp`.

use super::lib::numeric::safe_normalize;
use super::real::{Real, Real3, Vec3, real};
use super::structs::{Camera, Push, Ray};
use crate::abi::{NONE, Specialisation};
use crate::sampler;

fn primary_ray(push: &Push, c: &Camera, slot: u32) -> Ray {
    let pixel = slot % push.tile_pixels;
    let x = push.tile_x + pixel % push.tile_width;
    let y = push.tile_y + pixel / push.tile_width;
    let k = push.first_sample + slot / push.tile_pixels;
    let offset = sampler::offset(push.seed, x, y, k, push.samples);
    let sx = (x as Real + real(offset[0])) * c.step_x - 1.0;
    let sy = 1.0 - (y as Real + real(offset[1])) * c.step_y;
    let lateral = sx * Real3::from(c.right) + sy * Real3::from(c.up);
    Ray {
        origin: (Real3::from(c.origin) + c.advance * lateral).into(),
        direction: safe_normalize(Real3::from(c.forward) + lateral).into(),
        slot,
        skip: NONE,
        throughput: Vec3::ONE.into(),
        pad: 0,
    }
}

/// Primary rays of a batch.
pub fn generate(
    spec: &Specialisation,
    push: &Push,
    camera: &[Camera],
    eye_media: &[u32],
    rays: &mut [Ray],
    media: &mut [u32],
    slots: &mut [[f32; 3]],
) {
    let capacity = spec.media_capacity as usize;
    for slot in 0..push.items as usize {
        rays[slot] = primary_ray(push, &camera[0], slot as u32);
        slots[slot] = [0.0; 3];
        for j in 0..capacity {
            media[slot * capacity + j] = eye_media[j];
        }
    }
}

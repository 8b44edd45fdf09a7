//! Twin of `glsl/generate.comp`.

use super::lib::numeric::safe_normalize;
use super::real::{Real, Real3, Vec3, real};
use super::structs::{Camera, Path, Push, Ray};
use crate::abi::{NONE, Specialisation};
use crate::sampler::{self, Sampler};

fn primary_ray(spec: &Specialisation, push: &Push, c: &Camera, pixels: &[u32], slot: u32) -> Ray {
    let pixel = slot % push.tile_pixels;
    let at = if spec.survey != 0 { pixels[pixel as usize] } else { pixel };
    let x = push.tile_x + at % push.tile_width;
    let y = push.tile_y + at / push.tile_width;
    let k = push.first_sample + slot / push.tile_pixels;
    let kind = Sampler::of_word(spec.sampler_kind);
    let offset = sampler::offset(kind, spec.replicates, push.seed, x, y, k, push.samples);
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
    pixels: &[u32],
    rays: &mut [Ray],
    media: &mut [u32],
    slots: &mut [[f32; 3]],
    paths: &mut [Path],
) {
    let capacity = spec.media_capacity as usize;
    for slot in 0..push.items as usize {
        rays[slot] = primary_ray(spec, push, &camera[0], pixels, slot as u32);
        slots[slot] = [0.0; 3];
        if spec.survey != 0 {
            paths[slot] = Path::default();
        }
        for j in 0..capacity {
            media[slot * capacity + j] = eye_media[j];
        }
    }
}

//! Twin of `glsl/generate.comp`.

use super::lib::numeric::safe_normalize;
use super::real::{Real, Real3, Vec3, real};
use super::structs::{Camera, Path, Push, Ray};
use crate::kernel::abi::{NONE, Specialisation};
use crate::settings::sampler::{self, Sampler};

fn primary_ray(spec: &Specialisation, push: &Push, c: &Camera, pixels: &[u32], sample_index: u32) -> Ray {
    let pixel = sample_index % push.tile_pixels;
    let at = if spec.survey != 0 { pixels[pixel as usize] } else { pixel };
    let x = push.tile_x + at % push.tile_width;
    let y = push.tile_y + at / push.tile_width;
    let k = push.first_sample + sample_index / push.tile_pixels;
    let kind = Sampler::of_word(spec.sampler_kind);
    let offset = sampler::offset(kind, spec.replicates, push.seed, x, y, k, push.samples);
    let sx = (x as Real + real(offset[0])) * c.step_x - 1.0;
    let sy = 1.0 - (y as Real + real(offset[1])) * c.step_y;
    let lateral = sx * Real3::from(c.right) + sy * Real3::from(c.up);
    Ray {
        origin: (Real3::from(c.origin) + c.advance * lateral).into(),
        direction: safe_normalize(Real3::from(c.forward) + lateral).into(),
        sample_index,
        skip: NONE,
        throughput: Vec3::ONE.into(),
        kind: 0,
    }
}

fn in_blocks(spec: &Specialisation, push: &Push, at: u32) -> u32 {
    let strip = push.tile_width.saturating_mul(8);
    let first = at - at % strip;
    if spec.survey != 0 || push.tile_pixels - first < strip {
        return at;
    }
    let (i, blocks) = (at - first, push.tile_width / 8 * 64);
    let mut x = i / 64 * 8 + ((i & 1) | (i >> 1 & 2) | (i >> 2 & 4));
    let mut y = (i >> 1 & 1) | (i >> 2 & 2) | (i >> 3 & 4);
    if i >= blocks {
        let width = push.tile_width % 8;
        x = push.tile_width - width + (i - blocks) % width;
        y = (i - blocks) / width;
    }
    first + y * push.tile_width + x
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
    paths: &mut [Path],
) {
    let capacity = spec.media_capacity as usize;
    for item in 0..push.items {
        let at = item % push.tile_pixels;
        let sample_index = (item - at + in_blocks(spec, push, at)) as usize;
        let item = item as usize;
        rays[item] = primary_ray(spec, push, &camera[0], pixels, sample_index as u32);
        if spec.survey != 0 {
            paths[sample_index] = Path::default();
        }
        for j in 0..capacity {
            media[item * capacity + j] = eye_media[j];
        }
    }
}

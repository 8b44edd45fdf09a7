//! Twin of `glsl/resolve.comp`.

use super::lib::numeric::neumaier;
use super::real::Vec3;
use super::structs::{Film, Mark, Path, Push};
use crate::kernel::abi::Specialisation;
use std::ops::Range;

/// Adds the batch's samples to their pixels.
pub fn resolve(
    spec: &Specialisation,
    push: &Push,
    sample_radiance: &[[f32; 3]],
    paths: &[Path],
    film: &mut [Film],
    marks: &mut [Mark],
) {
    let pixels = push.tile_pixels as usize;
    let (replicates, parts) = (spec.replicates as usize, spec.parts as usize);
    let batch = push.batch_samples as usize;
    for pixel in 0..pixels {
        let mut add = |sets: usize, set: usize, samples: Range<usize>, step: usize| {
            let entry = &mut film[pixel * sets + set];
            let (mut sum, mut compensation) = (Vec3::from(entry.sum), Vec3::from(entry.compensation));
            for k in samples.step_by(step) {
                neumaier(&mut sum, &mut compensation, sample_radiance[k * pixels + pixel].into());
            }
            *entry = Film { sum: sum.into(), compensation: compensation.into() };
        };
        if parts == 1 {
            let turn = push.first_sample as usize % replicates;
            for r in 0..replicates {
                add(replicates, r, (r + replicates - turn) % replicates..batch, replicates);
            }
        } else {
            for p in 0..parts {
                add(parts, p, place_in_batch(spec, push, p)..place_in_batch(spec, push, p + 1), 1);
            }
        }
        if spec.survey == 0 {
            continue;
        }
        let m = &mut marks[pixel];
        for k in 0..push.batch_samples as usize {
            let p = &paths[k * pixels + pixel];
            m.hash_least_inverted = m.hash_least_inverted.max(!p.hash);
            m.hash_most = m.hash_most.max(p.hash);
            m.rays = m.rays.wrapping_add(p.rays);
            m.depth = m.depth.max(p.depth);
            m.cut_low = m.cut_low.wrapping_add(p.cut);
            m.cut_high += u32::from(m.cut_low < p.cut);
        }
    }
}

/// Where part `p` of the range begins, as a sample of this batch.
fn place_in_batch(spec: &Specialisation, push: &Push, p: usize) -> usize {
    let begin = push.range_first + (p as u32 * push.range_samples).div_ceil(spec.parts);
    begin.saturating_sub(push.first_sample).min(push.batch_samples) as usize
}

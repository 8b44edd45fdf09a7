//! Twin of `glsl/resolve.comp`.

use super::lib::numeric::neumaier;
use super::real::Vec3;
use super::structs::{Film, Mark, Path, Push};
use crate::kernel::abi::Specialisation;

/// Adds the batch's samples to their pixels.
pub fn resolve(
    spec: &Specialisation,
    push: &Push,
    sample_radiance: &[[f32; 3]],
    paths: &[Path],
    film: &mut [Film],
    marks: &mut [Mark],
) {
    let (pixels, replicates) = (push.tile_pixels as usize, spec.replicates as usize);
    let turn = push.first_sample as usize % replicates;
    for pixel in 0..pixels {
        for r in 0..replicates {
            let entry = &mut film[pixel * replicates + r];
            let (mut sum, mut compensation) = (Vec3::from(entry.sum), Vec3::from(entry.compensation));
            for k in ((r + replicates - turn) % replicates..push.batch_samples as usize).step_by(replicates) {
                neumaier(&mut sum, &mut compensation, sample_radiance[k * pixels + pixel].into());
            }
            *entry = Film { sum: sum.into(), compensation: compensation.into() };
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

//! Twin of `glsl/gather.comp`.

use super::lib::numeric::neumaier;
use super::real::Vec3;
use super::structs::{Contribution, Queue};
use crate::kernel::abi::{COUNTER_LOOP_CAP, LOOP_CAP};

/// Adds the contributions of all rays of one sample at this depth to the sample.
pub fn gather(
    queue: &[Queue],
    contributions: &[Contribution],
    sample_radiance: &mut [[f32; 3]],
    counters: &mut [u32],
) {
    let count = queue[0].count as usize;
    for i in 0..count {
        let sample_index = contributions[i].sample_index;
        if i > 0 && contributions[i - 1].sample_index == sample_index {
            continue;
        }
        let (mut sum, mut compensation) = (Vec3::from(contributions[i].light), Vec3::ZERO);
        let mut j = i + 1;
        while j < count && j - i < LOOP_CAP as usize && contributions[j].sample_index == sample_index {
            neumaier(&mut sum, &mut compensation, contributions[j].light.into());
            j += 1;
        }
        if j - i == LOOP_CAP as usize {
            counters[COUNTER_LOOP_CAP as usize] += 1;
        }
        let total = &mut sample_radiance[sample_index as usize];
        *total = (Vec3::from(*total) + (sum + compensation)).into();
    }
}

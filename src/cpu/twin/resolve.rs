//! Twin of `glsl/resolve.comp`.

use super::lib::numeric::neumaier;
use super::real::Vec3;
use super::structs::{Film, Push};

/// Adds the batch's samples to their pixels.
pub fn resolve(push: &Push, slots: &[[f32; 3]], film: &mut [Film]) {
    let pixels = push.tile_pixels as usize;
    for (pixel, entry) in film.iter_mut().enumerate().take(pixels) {
        let (mut sum, mut compensation) = (Vec3::from(entry.sum), Vec3::from(entry.compensation));
        for k in 0..push.batch_samples as usize {
            neumaier(&mut sum, &mut compensation, slots[k * pixels + pixel].into());
        }
        *entry = Film { sum: sum.into(), compensation: compensation.into() };
    }
}

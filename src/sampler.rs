//! Where in its pixel a sample lies: counter-based, the same bits here and in `glsl/lib/sampler.glsl`.
//! Sample k of pixel (x, y) depends on (seed, x, y, k) alone.

/// The four-dimensional PCG hash of Jarzynski and Olano, "Hash Functions for GPU Rendering",
/// JCGT 9(3), 2020, listing `pcg4d`.
pub fn pcg4d(v: [u32; 4]) -> [u32; 4] {
    let mut v = v.map(|c| c.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    let mix = |v: &mut [u32; 4]| {
        v[0] = v[0].wrapping_add(v[1].wrapping_mul(v[3]));
        v[1] = v[1].wrapping_add(v[2].wrapping_mul(v[0]));
        v[2] = v[2].wrapping_add(v[0].wrapping_mul(v[1]));
        v[3] = v[3].wrapping_add(v[1].wrapping_mul(v[2]));
    };
    mix(&mut v);
    v = v.map(|c| c ^ (c >> 16));
    mix(&mut v);
    v
}

/// Position of sample `k` of `samples` inside pixel (x, y), each coordinate in [0, 1) and a multiple
/// of 2^-24 (so exact in `f32`). With one sample it is the pixel's centre.
pub fn offset(seed: u32, x: u32, y: u32, k: u32, samples: u32) -> [f32; 2] {
    if samples == 1 {
        return [0.5, 0.5];
    }
    let h = pcg4d([x, y, k, seed]);
    let unit = |c: u32| (c >> 8) as f32 * (1.0 / 16_777_216.0);
    [unit(h[0]), unit(h[1])]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_fill_the_pixel_evenly() {
        // 64 cells, 65,536 samples: chi-square with 63 degrees of freedom stays below its 1 - 1e-6
        // quantile (131) for a sound hash; a constant or striped one scores thousands.
        let mut cells = [0u32; 64];
        for k in 0..65_536 {
            let [u, v] = offset(7, 3, 5, k, 65_536);
            assert!((0.0..1.0).contains(&u) && (0.0..1.0).contains(&v));
            cells[(u * 8.0) as usize * 8 + (v * 8.0) as usize] += 1;
        }
        let chi2: f64 = cells.iter().map(|&c| (f64::from(c) - 1024.0).powi(2) / 1024.0).sum();
        assert!(chi2 < 131.0, "chi-square {chi2}");
    }

    #[test]
    fn neighbours_and_seeds_differ() {
        let a = offset(0, 1, 2, 3, 4);
        for b in [offset(1, 1, 2, 3, 4), offset(0, 2, 2, 3, 4), offset(0, 1, 3, 3, 4), offset(0, 1, 2, 2, 4)]
        {
            assert_ne!(a, b);
        }
        assert_eq!(offset(9, 1, 2, 0, 1), [0.5, 0.5]);
    }
}

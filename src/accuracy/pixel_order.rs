//! Pixels from coarse to fine: whatever is traced first is an even image of few pixels.
//!
//! The grids of side 64, 32, … 1 lie in each other. A grid adds to the one before it three sets: first the
//! middles of its cells, then those of their edges.

/// Side of the first grid.
const COARSEST: u32 = 64;

/// All pixels `y * width + x` of an image, each once.
pub fn order(width: u32, height: u32) -> Vec<u32> {
    let mut all = Vec::with_capacity(width as usize * height as usize);
    let mut grid = |side: u32, [x, y]: [u32; 2]| {
        for y in (y..height).step_by(side as usize) {
            all.extend((x..width).step_by(side as usize).map(|x| y * width + x));
        }
    };
    let mut side = COARSEST;
    grid(side, [0, 0]);
    while side > 1 {
        let half = side / 2;
        for corner in [[half, half], [half, 0], [0, half]] {
            grid(side, corner);
        }
        side = half;
    }
    all
}

/// For each pixel the one that stands for it: itself if it has samples, else the nearest point of the finest
/// grid of which that point has. `samples` has been filled in [`order`].
pub fn stand_ins(width: u32, samples: &[u32]) -> Vec<u32> {
    let height = samples.len() as u32 / width.max(1);
    let nearest = |at: u32, side: u32, end: u32| {
        let point = (at + side / 2) / side * side;
        if point < end { point } else { point - side }
    };
    let stand_in = |p: u32| {
        let (x, y) = (p % width, p / width);
        let mut side = 1;
        while side <= COARSEST {
            let point = nearest(y, side, height) * width + nearest(x, side, width);
            if samples[point as usize] > 0 {
                return point;
            }
            side *= 2;
        }
        // The first of all.
        0
    };
    (0..samples.len() as u32).map(stand_in).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_pixel_comes_once(width in 1u32..200, height in 1u32..150) {
            let mut all = order(width, height);
            prop_assert_eq!(all[0], 0);
            all.sort_unstable();
            prop_assert!(all.into_iter().eq(0..width * height));
        }

        /// None is further from its stand-in than the side of the finest grid that is whole.
        #[test]
        fn any_prefix_is_an_even_image(width in 1u32..200, height in 1u32..150, share in 0.0f64..1.0) {
            let all = order(width, height);
            let points = |side: u32| (width.div_ceil(side) * height.div_ceil(side)) as usize;
            let count = ((share * all.len() as f64) as usize).clamp(points(COARSEST), all.len());
            let mut samples = vec![0; all.len()];
            all[..count].iter().for_each(|p| samples[*p as usize] = 1);
            let sides = (0..=6).map(|k| 1u32 << k);
            let far = f64::from(sides.filter(|side| points(*side) <= count).min().unwrap_or(COARSEST));
            for (p, q) in stand_ins(width, &samples).into_iter().enumerate() {
                let p = p as u32;
                prop_assert!(samples[q as usize] > 0);
                prop_assert!(samples[p as usize] == 0 || p == q);
                let apart = |a: u32, b: u32| f64::from(a.abs_diff(b));
                let distance = apart(p % width, q % width).max(apart(p / width, q / width));
                prop_assert!(distance <= far, "{p} {q}: {distance} of {far}");
            }
        }
    }

    #[test]
    fn the_first_pixel_stands_for_all() {
        assert_eq!(stand_ins(100, &[vec![3], vec![0; 9999]].concat()), vec![0; 10_000]);
    }
}

//! Pixels from coarse to fine: whatever is traced first is an even image of few pixels.
//!
//! The grids of side 64, 32, … 1 lie in each other. A grid adds to the one before it three sets: first the
//! middles of its cells, then those of their edges.

use std::ops::Range;

/// Side of the first grid.
const COARSEST: u32 = 64;

/// The pixels `y * width + x` of an image at `places` of the order from coarse to fine, in which every pixel comes once.
pub fn order(width: u32, height: u32, places: Range<usize>) -> Vec<u32> {
    let mut listed = Vec::with_capacity(places.len());
    let mut place = 0;
    let mut grid = |side: u32, [x, y]: [u32; 2]| {
        for y in (y..height).step_by(side as usize) {
            let row = (x..width).step_by(side as usize);
            let (from, length) = (places.start.saturating_sub(place), row.len());
            let to = places.end.saturating_sub(place).min(length);
            place += length;
            listed.extend(row.skip(from).take(to.saturating_sub(from)).map(|x| y * width + x));
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
    listed
}

/// For a pixel the one that stands for it: itself if it has samples, else the nearest point of the finest
/// grid of which that point has. `samples` has been filled in [`order`].
pub fn stand_in(width: u32, samples: &[u32]) -> impl Fn(u32) -> u32 + Sync + Send {
    let height = samples.len() as u32 / width.max(1);
    let nearest = move |at: u32, side: u32, end: u32| {
        let point = (at + side / 2) / side * side;
        if point < end { point } else { point - side }
    };
    move |p: u32| {
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
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(width: u32, height: u32) -> Vec<u32> {
        order(width, height, 0..width as usize * height as usize)
    }
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_pixel_comes_once(width in 1u32..200, height in 1u32..150, cut in (0.0f64..1.0, 0.0f64..1.0)) {
            let mut all = all(width, height);
            prop_assert_eq!(all[0], 0);
            let (a, b) = ((cut.0 * all.len() as f64) as usize, (cut.1 * all.len() as f64) as usize);
            prop_assert_eq!(order(width, height, a..b), all[a..b.max(a)].to_vec());
            all.sort_unstable();
            prop_assert!(all.into_iter().eq(0..width * height));
        }

        /// None is further from its stand-in than the side of the finest grid that is whole.
        #[test]
        fn any_prefix_is_an_even_image(width in 1u32..200, height in 1u32..150, share in 0.0f64..1.0) {
            let all = all(width, height);
            let points = |side: u32| (width.div_ceil(side) * height.div_ceil(side)) as usize;
            let count = ((share * all.len() as f64) as usize).clamp(points(COARSEST), all.len());
            let mut samples = vec![0; all.len()];
            all[..count].iter().for_each(|p| samples[*p as usize] = 1);
            let sides = (0..=6).map(|k| 1u32 << k);
            let far = f64::from(sides.filter(|side| points(*side) <= count).min().unwrap_or(COARSEST));
            let stand_in = stand_in(width, &samples);
            for p in 0..all.len() as u32 {
                let q = stand_in(p);
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
        let samples = [vec![3], vec![0; 9999]].concat();
        let stand_in = stand_in(100, &samples);
        assert!((0..10_000).all(|p| stand_in(p) == 0));
    }
}

//! Gradient noise (Perlin 2002) from integer hashes: the same bits on every machine.

use glam::DVec3;

/// Gradient noise at `p`, in [-0.87, 0.87] (half the diagonal of a unit cell).
pub(super) fn gradient_noise(p: DVec3, seed: u32) -> f64 {
    let cell = p.floor();
    let local = p - cell;
    // Perlin's quintic: zero first and second derivative at both ends.
    let fade = local * local * local * (local * (local * 6.0 - 15.0) + 10.0);
    let mut sum = 0.0;
    for corner in 0..8u32 {
        let bits = DVec3::from_array([0, 1, 2].map(|axis| f64::from(corner >> axis & 1)));
        let weight = bits * fade + (DVec3::ONE - bits) * (DVec3::ONE - fade);
        let node = cell + bits;
        let gradient = gradient([node.x, node.y, node.z].map(|x| x as i32 as u32), seed);
        sum += gradient.dot(local - bits) * weight.element_product();
    }
    sum
}

/// A unit vector chosen by the lattice point and the seed.
fn gradient(node: [u32; 3], seed: u32) -> DVec3 {
    let mut hash = node.iter().fold(mix(seed), |hash, x| mix(hash ^ x));
    // Points of the cube outside its inscribed sphere are redrawn, so that no direction is favoured.
    loop {
        let v = DVec3::from_array([0; 3].map(|_: u32| {
            hash = mix(hash);
            f64::from(hash) / f64::from(u32::MAX) * 2.0 - 1.0
        }));
        let square = v.length_squared();
        if (1e-4..=1.0).contains(&square) {
            return v / square.sqrt();
        }
    }
}

/// A bijective scramble of 32 bits: Wellons' lowbias32, moved off its fixed point 0.
fn mix(x: u32) -> u32 {
    let mut x = x.wrapping_add(0x9e37_79b9);
    x = (x ^ x >> 16).wrapping_mul(0x7feb_352d);
    x = (x ^ x >> 15).wrapping_mul(0x846c_a68b);
    x ^ x >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_on_the_lattice_smooth_between_and_bounded() {
        assert_eq!(gradient_noise(DVec3::new(3.0, -2.0, 7.0), 1), 0.0);
        let mut spread: f64 = 0.0;
        for i in 0..2000 {
            let p = DVec3::new(0.37, 0.21, -0.13) * f64::from(i);
            let (a, b) = (gradient_noise(p, 1), gradient_noise(p + DVec3::splat(1e-6), 1));
            // The gradients have length 1 and the fades slopes below 2.
            assert!((a - b).abs() < 1e-5);
            assert!(a.abs() <= 0.75f64.sqrt());
            spread = spread.max(a.abs());
        }
        assert!(spread > 0.5);
        assert_ne!(gradient_noise(DVec3::splat(0.5), 1), gradient_noise(DVec3::splat(0.5), 2));
    }
}

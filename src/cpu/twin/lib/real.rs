//! The kernels' `real`: its type here, and all that depends on its format.

/// `real`.
pub type Real = f32;
/// `real3`.
pub type Real3 = glam::Vec3;
/// Colours: `vec3` in every precision.
pub type Vec3 = glam::Vec3;

/// 2^-24, unit roundoff.
pub const U: Real = 5.960_464_477_539_062_5e-8;
/// Veltkamp's splitting factor, 2^12 + 1.
pub const SPLIT: Real = 4097.0;
/// Larger than any t in the local frame, yet finite.
pub const FAR: Real = 3.0e38;
/// Least normal number; denormals may be flushed.
pub const NORMAL_MIN: Real = 1.175_494_35e-38;

/// NaN or infinity, by bits.
pub fn is_not_finite(v: Real3) -> bool {
    v.to_array().iter().any(|c| c.to_bits() & 0x7f80_0000 == 0x7f80_0000)
}

/// The next float above (`up` in magnitude) or below a number that is not zero.
pub fn step(x: Real, up: bool) -> Real {
    Real::from_bits(if up { x.to_bits().wrapping_add(1) } else { x.to_bits().wrapping_sub(1) })
}

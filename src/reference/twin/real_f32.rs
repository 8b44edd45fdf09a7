//! The kernels' `real` in single precision, and what depends on its format.

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

/// NaN or infinity, by bits.
pub fn is_not_finite(v: Real3) -> bool {
    v.to_array().iter().any(|c| c.to_bits() & 0x7f80_0000 == 0x7f80_0000)
}

/// `real(x)`.
pub fn real(x: f32) -> Real {
    x
}

/// `float(x)`.
pub fn float(x: Real) -> f32 {
    x
}

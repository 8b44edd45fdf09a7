//! The kernels' `real` in double precision, and what depends on its format.

/// `real`.
pub type Real = f64;
/// `real3`.
pub type Real3 = glam::DVec3;
/// Colours: `vec3` in every precision.
pub type Vec3 = glam::Vec3;

/// 2^-53, unit roundoff.
pub const U: Real = 1.110_223_024_625_156_5e-16;
/// Veltkamp's splitting factor, 2^27 + 1.
pub const SPLIT: Real = 134_217_729.0;
/// Larger than any t in the local frame, yet finite: in the kernels a single-precision literal.
pub const FAR: Real = 3.0e38_f32 as Real;

/// NaN or infinity, by bits.
pub fn is_not_finite(v: Real3) -> bool {
    v.to_array().iter().any(|c| c.to_bits() >> 52 & 0x7ff == 0x7ff)
}

/// `real(x)`.
pub fn real(x: f32) -> Real {
    x.into()
}

/// `float(x)`.
pub fn float(x: Real) -> f32 {
    x as f32
}

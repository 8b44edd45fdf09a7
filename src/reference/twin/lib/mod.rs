//! Twins of `glsl/lib`, file by file.

pub mod r#box;
pub mod fresnel;
pub mod light;
pub mod media;
pub mod numeric;
pub mod spawn;
pub mod sphere;
pub mod strike;
pub mod surface;
pub mod trace;
pub mod triangle;
pub mod wide;

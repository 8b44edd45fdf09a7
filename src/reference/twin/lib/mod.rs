//! Twins of `glsl/lib`, file by file.

pub mod r#box;
pub mod count_tests;
pub mod double_length;
pub mod fresnel;
pub mod light;
pub mod media;
pub mod numeric;
pub mod spawn;
pub mod sphere;
pub mod strike;
pub mod surface;
pub mod traverse;
pub mod triangle;

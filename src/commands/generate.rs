//! `whitted generate`.

use super::failure::Failure;
use crate::generate::{self, Shape};

/// Writes the shape's file.
pub fn run(shape: &Shape) -> Result<(), Failure> {
    Ok(generate::run(shape)?)
}

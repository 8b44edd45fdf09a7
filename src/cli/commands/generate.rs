//! `whitted generate`.

use crate::cli::failure::Failure;
use crate::scene::procedural::{self, Shape};

/// Writes the shape's file.
pub fn run(shape: &Shape) -> Result<(), Failure> {
    Ok(procedural::run(shape)?)
}

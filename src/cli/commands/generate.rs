//! `whitted generate`.

use crate::cli::failure::Failure;
use crate::cli::files::Files;
use crate::scene::procedural::{self, Shape};

/// Writes the shape's file.
pub fn run(shape: &Shape) -> Result<(), Failure> {
    let file = match shape {
        Shape::Sphereflake(args) => &args.output,
        Shape::RotatedCube(args) => &args.placement.output,
        Shape::DisplacedSphere(args) => &args.placement.output,
    };
    let files = Files::new().writes("-o", Some(file));
    match shape {
        Shape::RotatedCube(_) | Shape::DisplacedSphere(_) if file.as_os_str() != "-" => {
            files.writes("the material file", Some(&file.with_extension("mtl"))).check()?;
        }
        _ => files.check()?,
    }
    Ok(procedural::run(shape)?)
}

//! The extremes, as scenes and ray batches run on a device, each with a derived bound and the figure
//! reached. `whitted stress` prints them; `tests/stress.rs` runs the same cases on the CPU twins, and
//! plants mistakes to see each case fail.

mod camera;
mod case;
mod contact;
mod duplicates;
mod exact;
mod frame;
mod hierarchy;
mod leaks;
mod lighting;
mod media;
mod optics;
mod origins;
mod pixels;
pub mod page;
mod refraction;
mod roots;
mod spheres;
mod thin;
mod tracer;
mod triangles;

pub use crate::scene::procedural::shapes::moved;
pub use case::{Case, Figure, Harness};
pub use tracer::{Picture, Tracer, Twins};

/// All cases, in the order they are run.
pub fn cases() -> Vec<Case> {
    [
        frame::CASES,
        triangles::CASES,
        spheres::CASES,
        contact::CASES,
        origins::CASES,
        leaks::CASES,
        hierarchy::CASES,
        refraction::CASES,
        media::CASES,
        lighting::CASES,
        camera::CASES,
        thin::CASES,
        duplicates::CASES,
    ]
    .concat()
}

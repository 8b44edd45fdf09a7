//! The extremes, as scenes and ray batches run on a device, each with a derived bound and the figure
//! reached. `whitted stress` prints them; the tests run the same cases on the CPU twins, and plant
//! the defect each case guards against to see it fail.

mod camera;
mod case;
mod files;
mod frame;
mod hierarchy;
mod lighting;
mod origins;
pub mod page;
mod refraction;
mod shapes;
mod spheres;
mod tracer;
mod triangles;

pub use case::{Case, Figure, Harness};
pub use tracer::{Picture, Tracer};

/// All cases, in the order they are run.
pub fn cases() -> Vec<Case> {
    [
        frame::CASES,
        triangles::CASES,
        spheres::CASES,
        origins::CASES,
        hierarchy::CASES,
        refraction::CASES,
        lighting::CASES,
        camera::CASES,
        files::CASES,
    ]
    .concat()
}

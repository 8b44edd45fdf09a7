//! Stress cases: extreme scenes and batches of rays run on a device, each with a derived error
//! bound. `whitted stress` prints the results; `tests/stress.rs` runs the same cases on the CPU
//! twins, and plants mistakes to check that each case can fail.

mod camera;
mod case;
mod contact;
mod duplicates;
mod exact;
mod local_frame;
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
mod two_scales;
mod walks;

pub use crate::scene::procedural::shapes::moved;
pub use case::{Case, Figure, Harness};
pub use tracer::{Picture, Tracer, Twins};

/// All cases, in the order in which they run.
pub fn cases() -> Vec<Case> {
    [
        local_frame::CASES,
        two_scales::CASES,
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
        walks::CASES,
    ]
    .concat()
}

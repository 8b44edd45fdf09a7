//! Experiments on whole renders. Nothing but the command line imports this room.

pub mod calibrate;
pub mod gallery;
pub(crate) mod markdown;
pub(crate) mod page;
pub(crate) mod plot;
pub mod probe;
pub mod profile;
pub mod receipt;
pub mod render_page;
pub mod stress;
pub mod suite;
pub mod surface_pictures;
pub mod sweep;

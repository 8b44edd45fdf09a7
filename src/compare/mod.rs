//! Distances between two pictures.

pub mod flip;
pub mod metrics;
pub mod statistical;

//! Measuring images against each other, and numbers that were measured more than once.

pub mod metrics;
pub mod samples;
pub mod stats;
pub mod sweep;

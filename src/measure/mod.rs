//! Measuring images against each other.

pub mod metrics;

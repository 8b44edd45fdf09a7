//! Measuring images against each other, and numbers that were measured more than once.

pub mod allocate;
pub mod budget;
pub mod flip;
pub mod gathered;
pub mod interval;
pub mod limit;
pub mod metrics;
pub mod promise;
pub mod quantile;
pub mod samples;
pub mod sampling;
pub mod stats;
#[cfg(test)]
pub(crate) mod synthetic;

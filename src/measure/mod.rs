//! Measuring images against each other, and numbers that were measured more than once. The error budget of
//! one image: [`sampling`], [`truncation`]; what steers by it: [`allocate`].

pub mod allocate;
pub mod budget;
pub mod calibrate;
pub mod coarse;
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
pub mod sweep;
#[cfg(test)]
mod synthetic;
pub mod truncation;

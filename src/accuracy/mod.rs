//! The error of an image: its four parts ([`sampling`], [`truncation`], rounding), bounds on each, and the
//! drivers that keep an error or a time ([`promise`]).

pub mod allocate;
pub mod bright;
pub mod budget;
pub mod dim;
pub mod drawn;
pub mod pieces;
pub mod pixel_order;
pub mod pixel_sums;
pub mod interval;
pub mod pixel_interval;
pub mod radiance_bound;
pub mod projection;
pub mod promise;
pub mod quantile;
pub mod sampling;
#[cfg(test)]
pub(crate) mod synthetic;
pub mod truncation;
pub mod unseen;

//! Whole images on the device: to the bit against the twins, within stated bounds against the oracle,
//! and against closed forms.

// A panic is a test's failure report, in its helpers too.
#![allow(clippy::unwrap_used)]

mod common;

#[path = "images/closed.rs"]
mod closed;
#[path = "images/judged.rs"]
mod judged;
#[path = "images/twins.rs"]
mod twins;

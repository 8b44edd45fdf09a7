//! A grid of settings, every point timed and judged against one truth.

pub mod analysis;
pub mod axes;
pub mod page;
pub mod point;
pub mod record;
pub mod row;
mod run;
mod trace;
pub mod truth;

pub use record::Record;
pub use run::{Plan, Watch, run};
pub use trace::SweepError;

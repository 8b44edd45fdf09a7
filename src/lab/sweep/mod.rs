//! A grid of settings, every point timed and judged against one truth.

pub mod analysis;
pub mod axes;
mod folder;
mod judging;
mod keys;
pub mod page;
mod plan;
pub mod point;
pub mod record;
pub mod row;
mod run;
mod timing;
pub mod truth;
mod truth_tracer;

pub use plan::{Plan, Watch};
pub use record::Record;
pub use run::run;
pub use truth_tracer::SweepError;

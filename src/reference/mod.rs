//! The same light on the CPU: the kernels' twins, and the oracle that judges both.

pub mod oracle;
pub mod twin;

//! The same light on the CPU: the oracle.

pub mod oracle;

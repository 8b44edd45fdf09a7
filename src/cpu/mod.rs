//! The same light on the CPU: the oracle.

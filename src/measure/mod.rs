//! Measuring images against each other.

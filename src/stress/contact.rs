//! x

use super::case::Case;

/// Cases of this file.
pub const CASES: &[Case] = &[];

//! What the host machine has for this process.

pub mod cache_folder;
pub mod memory;

//! `whitted`: a Whitted (1980) ray tracer as raw Vulkan compute.
//!
//! ```text
//! scene text, OBJ ─ scene ─▶ Scene ─ prepare ─▶ flat arrays ─ plan ─▶ queues, tiles, batches
//! plan ─▶ generate, per depth { intersect, shade, scan, spawn, shadow, gather }, resolve
//! vk ─▶ recorded, submitted, timed ─ render ─▶ image + report
//! ```
//!
//! The rooms below stand from the bottom up: a room uses those above it in this list, never those below.
#![deny(unsafe_code)]

pub mod atomic_file;
pub mod cache_folder;
pub mod stats;
pub mod units;

pub mod scene;
pub mod kernel;
pub mod settings;
pub mod prepare;
pub mod report;
pub mod plan;
pub mod vk;
pub mod image;
pub mod compare;
pub mod render;
pub mod accuracy;
pub mod reference;
pub mod lab;
pub mod cli;

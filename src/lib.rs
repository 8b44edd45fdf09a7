//! `whitted`: a Whitted (1980) ray tracer as raw Vulkan compute.
//!
//! ```text
//! scene text, OBJ ─ scene ─▶ Scene ─ frame, bvh, pack ─▶ flat arrays ─ plan ─▶ queues, tiles, batches
//! plan ─ passes ─▶ generate, per depth { intersect, shade, scan, spawn, shadow, gather }, resolve
//! passes ─ vk ─▶ recorded, submitted, timed ─ render ─▶ image + report
//! cpu: the kernels' twins and the oracle that judges them
//! ```
//!
//! The modules below are in reading order.
#![deny(unsafe_code)]

pub mod abi;
pub mod spirv;
pub mod kernels;
pub mod scene;
pub mod generate;
pub mod frame;
pub mod inside;
pub mod bvh;
pub mod coincident;
pub mod found;
pub mod pack;
#[cfg(feature = "defects")]
#[doc(hidden)]
pub mod defect;
pub mod general;
pub mod reach;
pub mod settings;
pub mod plan;
pub mod passes;
pub mod traffic;
pub mod vk;
pub mod render;
pub mod selftest;
pub mod probe;
pub mod report;
pub mod predict;
pub mod outline;
pub mod receipt;
pub mod timeline;
pub mod sampler;
pub mod cpu;
mod plot;
pub mod stress;
pub mod measure;
pub mod image;
pub mod atomic_file;
pub mod units;
pub mod table;
pub mod profile;
pub mod progress;
pub mod gallery;
pub mod cli;
pub mod commands;

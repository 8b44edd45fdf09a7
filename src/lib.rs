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
pub mod bvh;
pub mod cpu;
pub mod frame;
pub mod generate;
pub mod image;
pub mod inside;
pub mod kernels;
pub mod measure;
pub mod pack;
pub mod passes;
pub mod plan;
pub mod render;
pub mod report;
pub mod sampler;
pub mod scene;
pub mod settings;
pub mod spirv;
pub mod vk;

//! The explained plan: what was found in the scene, what follows from it, the memory and time it takes.
//! Serde data and its text; `plan::explain` fills it.

mod text;

pub use text::text;

use super::prediction::Prediction;
use super::{DeviceInfo, LocalFrameInfo, ProgramInfo, SettingsInfo};
use crate::prepare::scene_features::Found;
use serde::Serialize;

/// All that is known before a render runs.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Outline {
    /// Which program plans.
    pub program: ProgramInfo,
    /// For which device.
    pub device: DeviceInfo,
    /// Path as given.
    pub scene: String,
    /// The settings in force.
    pub settings: SettingsInfo,
    /// What the scene has.
    pub found: Found,
    /// The same in words, absent features included.
    pub features: Vec<FeatureRow>,
    /// Centre and power-of-two scale of the kernels' coordinates.
    pub local_frame: LocalFrameInfo,
    /// How deep light travels.
    pub reach: ReachInfo,
    /// How the closest hit is found.
    pub search: SearchInfo,
    /// What follows; null where the device cannot hold it.
    pub plan: Option<Planned>,
    /// Limits of the device that the plan keeps.
    pub limits: LimitInfo,
    /// How long it will take; null where that was not asked for or there is no plan.
    pub time: Option<Prediction>,
    /// Why there is no plan.
    pub refused: Option<Refused>,
}

/// A feature, found or not.
#[derive(Debug, Clone, Serialize)]
pub struct FeatureRow {
    /// Its name.
    pub name: &'static str,
    /// Whether the kernels are made for it.
    pub found: bool,
    /// How much of it, or why not.
    pub detail: String,
}

/// How deep light travels.
#[derive(Debug, Clone, Default, Serialize)]
pub struct ReachInfo {
    /// Depth that was asked for.
    pub asked: u32,
    /// Depth of the last passes.
    pub last: u32,
    /// Greatest factor of any surface on a ray's throughput.
    pub weight: f64,
    /// In words.
    pub why: String,
}

/// How the closest hit is found.
#[derive(Debug, Clone, Default, Serialize)]
pub struct SearchInfo {
    /// `brute force` or `hierarchy`.
    pub kind: &'static str,
    /// Nodes of the hierarchy.
    pub nodes: u64,
    /// Its levels.
    pub depth: u64,
    /// In words.
    pub why: String,
}

/// What follows from scene, settings and device.
#[derive(Debug, Clone, Serialize)]
pub struct Planned {
    /// The kernels of the frame.
    pub kernels: Vec<KernelRow>,
    /// Specialisation constants that leave code out, or add it.
    pub constants: Vec<Constant>,
    /// Shapes are constants of the kernels.
    pub known_shapes: bool,
    /// Why, or why not.
    pub known_shapes_why: String,
    /// Kernels read what a ray looks up through texel views.
    pub texels: bool,
    /// Why, or why not.
    pub texels_why: String,
    /// Rays that fit a queue.
    pub capacity: u32,
    /// Device bytes of a place in a queue, over all its buffers.
    pub bytes_per_place: u64,
    /// Invocations of a workgroup.
    pub workgroup: u32,
    /// Lights of one `shadow` pass.
    pub lights_per_pass: u32,
    /// Pixels of a tile, at most.
    pub tile_pixels: u32,
    /// Tiles of the image.
    pub tiles: u64,
    /// Samples of a pixel traced together, at most.
    pub batch_samples: u32,
    /// Batches over all tiles, if no queue overflows.
    pub batches: u64,
    /// Dispatches of one batch.
    pub dispatches: u64,
    /// Bytes of each buffer.
    pub buffers: Vec<BufferRow>,
    /// Bytes of all.
    pub bytes: u64,
}

/// A buffer of the plan.
#[derive(Debug, Clone, Serialize)]
pub struct BufferRow {
    /// As the kernels spell it.
    pub name: &'static str,
    /// Elements.
    pub elements: u64,
    /// Bytes.
    pub bytes: u64,
}

/// Limits of the device.
#[derive(Debug, Clone, Default, Serialize)]
pub struct LimitInfo {
    /// Bytes that one binding can hold.
    pub one_buffer: u64,
    /// Bytes of its heap.
    pub heap: u64,
    /// Bytes of it that a plan may take.
    pub heap_share: u64,
}

/// A plan that the device cannot hold.
#[derive(Debug, Clone, Serialize)]
pub struct Refused {
    /// What it lacks, and what would fit.
    pub message: String,
    /// Exit code of the render.
    pub exit_code: u8,
}

/// A kernel of the frame.
#[derive(Debug, Clone, Serialize)]
pub struct KernelRow {
    /// Its name.
    pub kernel: &'static str,
    /// Which compiled form: `f32`, `f64`, `few` (shapes as constants) or `packet` (the
    /// rays of a subgroup walk the hierarchy together).
    pub form: &'static str,
    /// Dispatches in one batch.
    pub launches: u64,
}

/// A specialisation constant.
#[derive(Debug, Clone, Serialize)]
pub struct Constant {
    /// As the kernels spell it.
    pub name: &'static str,
    /// Its value here.
    pub value: u32,
    /// Its value in a kernel that has everything; None where that is any number.
    pub general: Option<u32>,
    /// What it does.
    pub why: String,
}

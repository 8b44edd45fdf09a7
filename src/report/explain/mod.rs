//! The explained plan of a render: features of the scene, the kernels and memory that follow from
//! them, and the predicted time. Serde data and its text; `plan::explain` fills it.

mod text;

pub use text::text;

use super::info::{DeviceInfo, LocalFrameInfo, ProgramInfo, SettingsInfo};
use super::prediction::Prediction;
use crate::prepare::scene_features::SceneFeatures;
use serde::Serialize;

/// Everything known before a render runs.
#[derive(Debug, Clone, Default, Serialize)]
pub struct ExplainedPlan {
    /// Version of the program.
    pub program: ProgramInfo,
    /// Device planned for.
    pub device: DeviceInfo,
    /// Path as given.
    pub scene: String,
    /// The settings in force.
    pub settings: SettingsInfo,
    /// Features of the scene.
    #[serde(rename = "found")]
    pub scene_features: SceneFeatures,
    /// The same in words, one row per feature, absent ones included.
    pub features: Vec<FeatureRow>,
    /// Centre and power-of-two scale of the kernels' coordinates.
    pub local_frame: LocalFrameInfo,
    /// Greatest depth of a ray.
    #[serde(rename = "reach")]
    pub max_depth: MaxDepthInfo,
    /// How the closest hit is found.
    pub search: SearchInfo,
    /// Kernels, sizes and buffers; null if the device cannot hold them.
    pub plan: Option<Planned>,
    /// Memory limits that the plan keeps.
    pub limits: LimitInfo,
    /// Memory of the host that the image takes.
    pub host: HostInfo,
    /// Predicted time; null if not asked for, or if there is no plan.
    pub time: Option<Prediction>,
    /// Why there is no plan.
    pub refused: Option<Refused>,
    /// The error that the settings were chosen for; absent if none was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<PlannedError>,
}

/// An error that settings were chosen for: RMSE in linear light clamped to [0, 1].
#[derive(Debug, Clone, Serialize)]
pub struct PlannedError {
    /// As asked for.
    pub asked: f64,
    /// As expected of the whole from the pixels that were looked at.
    pub expected: f64,
    /// Pixels that were looked at.
    pub pixels: u32,
}

/// A feature of scenes, present or absent.
#[derive(Debug, Clone, Serialize)]
pub struct FeatureRow {
    /// Its name.
    pub name: &'static str,
    /// True if the scene has it and the kernels are compiled for it.
    pub found: bool,
    /// How many, or why it is absent.
    pub detail: String,
}

/// Greatest depth of a ray.
#[derive(Debug, Clone, Default, Serialize)]
pub struct MaxDepthInfo {
    /// Depth asked for.
    pub asked: u32,
    /// Depth of the last passes.
    pub last: u32,
    /// Greatest factor by which a surface multiplies a ray's throughput, 0 to 1.
    pub weight: f64,
    /// Reason for `last`.
    pub why: String,
}

/// How the closest hit is found.
#[derive(Debug, Clone, Default, Serialize)]
pub struct SearchInfo {
    /// `brute force` or `hierarchy`.
    pub kind: &'static str,
    /// Nodes of the hierarchy; 0 for brute force.
    pub nodes: u64,
    /// Levels of the hierarchy; 0 for brute force.
    pub depth: u64,
    /// Reason for `kind`.
    pub why: String,
}

/// Kernels, sizes and buffers of a render.
#[derive(Debug, Clone, Serialize)]
pub struct Planned {
    /// Kernels in the order of their first dispatch.
    pub kernels: Vec<KernelRow>,
    /// Specialisation constants that remove or add code.
    pub constants: Vec<Constant>,
    /// True if kernels read the scene through texel views.
    pub texels: bool,
    /// Reason for `texels`.
    pub texels_why: String,
    /// Rays that fit a queue.
    pub capacity: u32,
    /// Device bytes per ray in a queue, over all buffers of the queue.
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
    /// Sum over all buffers.
    pub bytes: u64,
}

/// A buffer of the plan.
#[derive(Debug, Clone, Serialize)]
pub struct BufferRow {
    /// Its name in the kernels.
    pub name: &'static str,
    /// Length in elements.
    pub elements: u64,
    /// Length in bytes.
    pub bytes: u64,
}

/// Limits of the device.
#[derive(Debug, Clone, Default, Serialize)]
pub struct LimitInfo {
    /// Bytes that one binding can hold.
    pub one_buffer: u64,
    /// Bytes of its heap.
    pub heap: u64,
    /// Bytes of the heap that a plan may use.
    pub heap_share: u64,
}

/// Memory of the host, beside the scene and the device's buffers.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub struct HostInfo {
    /// Bytes for the image while it is rendered and written as EXR, the largest format.
    pub image: u64,
    /// Bytes for it with sums of every pixel: `--budget`, `--error`, `--time` and `--aov`.
    pub bounded: u64,
    /// Bytes that this process can still have; null where nothing is known.
    pub free: Option<u64>,
}

/// A plan that the device cannot hold.
#[derive(Debug, Clone, Serialize)]
pub struct Refused {
    /// The limit that is exceeded, and what would fit.
    pub message: String,
    /// Exit code of the render.
    pub exit_code: u8,
}

/// A kernel that runs.
#[derive(Debug, Clone, Serialize)]
pub struct KernelRow {
    /// Its name.
    pub kernel: &'static str,
    /// Compiled form: `f32`, `f64` or `packet` (the lanes of a subgroup traverse the scene
    /// together).
    pub form: &'static str,
    /// Dispatches in one batch.
    pub launches: u64,
}

/// A specialisation constant.
#[derive(Debug, Clone, Serialize)]
pub struct Constant {
    /// Its name in the kernels.
    pub name: &'static str,
    /// Its value in this plan.
    pub value: u32,
    /// Its value in a kernel that supports every feature; None if that kernel takes any value.
    pub general: Option<u32>,
    /// Effect of the value.
    pub why: String,
}

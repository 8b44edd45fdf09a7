//! The machine-readable report: the names of report-format.md, filled by `render`, written as JSON.
//! Times in seconds, sizes in bytes.

pub mod explain;
pub mod prediction;
pub mod receipt;
pub mod table;
pub mod timeline;

use crate::settings::Settings;
use receipt::Receipt;
use serde::{Deserialize, Serialize};

/// One render, told in numbers.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Report {
    /// Which program made the image.
    pub program: ProgramInfo,
    /// On which device.
    pub device: DeviceInfo,
    /// Of which scene.
    pub scene: SceneInfo,
    /// With which settings.
    pub settings: SettingsInfo,
    /// What was planned before the start.
    pub plan: PlanInfo,
    /// Where the time went.
    pub time: TimeInfo,
    /// Rays that were really traced.
    pub rays: RayInfo,
    /// One row per pass and depth, in frame order.
    pub passes: Vec<PassInfo>,
    /// How wrong the image may be; null where it was not asked for.
    pub error: Option<ErrorInfo>,
    /// What was asked for instead of settings.
    pub asked: AskedInfo,
    /// Things that ought not to happen, counted.
    pub counters: Counters,
    /// What the user should know: arithmetic that could not be trusted, solids that coincide.
    pub warnings: Vec<String>,
    /// The image that came out.
    pub image: ImageInfo,
    /// What was planned, what it took, what it did without: of `render --receipt`, else absent.
    #[serde(skip_deserializing, skip_serializing_if = "Option::is_none")]
    pub receipt: Option<Receipt>,
}

/// The program.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ProgramInfo {
    /// Always `whitted`.
    pub name: String,
    /// Cargo version.
    pub version: String,
    /// Commit, or `unknown` outside a checkout.
    pub git: String,
}

impl Default for ProgramInfo {
    fn default() -> Self {
        ProgramInfo {
            name: env!("CARGO_PKG_NAME").into(),
            version: env!("CARGO_PKG_VERSION").into(),
            git: option_env!("WHITTED_GIT").unwrap_or("unknown").into(),
        }
    }
}

/// The Vulkan device.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct DeviceInfo {
    /// As the driver names it.
    pub name: String,
    /// `cpu`, `discrete`, `integrated`, `virtual` or `other`.
    #[serde(rename = "type")]
    pub kind: String,
    /// Driver name and version text.
    pub driver: String,
    /// Vulkan version, `1.3.230`.
    pub api: String,
}

/// What the scene holds.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct SceneInfo {
    /// Path as given.
    pub file: String,
    /// Triangles after polygons and faces were fanned and degenerate ones dropped.
    pub triangles: u64,
    /// Analytic spheres.
    pub spheres: u64,
    /// Point lights.
    pub lights: u64,
    /// Centre and power-of-two scale of the kernels' coordinates.
    pub local_frame: LocalFrameInfo,
}

/// `local = (world - center) * 2^scale_log2`.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct LocalFrameInfo {
    /// Metres.
    pub center: [f64; 3],
    /// Binary exponent.
    pub scale_log2: i32,
}

/// The settings in force.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct SettingsInfo {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Per pixel.
    pub samples: u32,
    /// Rays in the longest path.
    pub depth: u32,
    /// Rays with less throughput are not spawned; 0 spawns all.
    pub cutoff: f32,
    /// `random`, `stratified` or `owen`.
    pub sampler: String,
    /// Independently scrambled sequences that the samples are dealt to.
    pub replicates: u32,
    /// `robust`.
    pub precision: String,
    /// Seed of the sampler.
    pub seed: u32,
    /// Ray-origin policy: `bound`.
    pub origin: String,
    /// `[x0, y0, x1, y1]` in pixels, or null for the whole image.
    pub crop: Option<[u32; 4]>,
}

impl SettingsInfo {
    /// The settings under the report's names.
    pub fn of(settings: &Settings) -> SettingsInfo {
        SettingsInfo {
            width: settings.width,
            height: settings.height,
            samples: settings.samples,
            depth: settings.depth,
            cutoff: settings.cutoff,
            sampler: settings.sampler.name().into(),
            replicates: settings.replicates,
            precision: settings.precision.name().into(),
            seed: settings.seed,
            origin: settings.origin.name(),
            crop: settings.crop,
        }
    }
}

impl SettingsInfo {
    /// The rectangle of pixels that is rendered: `[x0, y0, x1, y1]`.
    pub fn region(&self) -> [u32; 4] {
        self.crop.unwrap_or([0, 0, self.width, self.height])
    }
}

/// The plan.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct PlanInfo {
    /// What the scene requires, in plain words.
    pub features: Vec<String>,
    /// Device memory.
    pub bytes: u64,
    /// Tiles of the image.
    pub tiles: u64,
    /// Batches of samples over all tiles.
    pub batches: u64,
    /// Whether the scene's shapes were constants of the kernels.
    pub known_shapes: bool,
}

/// Where the time went, seconds.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct TimeInfo {
    /// Whole process up to the report.
    pub wall: f64,
    /// Reading and checking the scene.
    pub scene: f64,
    /// Local frame, acceleration structure, packing, upload.
    pub build: f64,
    /// Device start, pipelines and the first (compiling) dispatch of each kernel.
    pub first_dispatch: f64,
    /// Sum of the passes' device time.
    pub device: f64,
    /// From the first submit to the last pixel on the host.
    pub render: f64,
}

/// Live rays.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct RayInfo {
    /// Camera rays.
    pub primary: u64,
    /// Reflection rays.
    pub reflection: u64,
    /// Refraction rays.
    pub refraction: u64,
    /// Shadow rays.
    pub shadow: u64,
    /// The same by depth, 1 = primary.
    pub by_depth: Vec<DepthInfo>,
}

impl RayInfo {
    /// All rays.
    pub fn total(&self) -> u64 {
        self.primary + self.reflection + self.refraction + self.shadow
    }
}

/// Rays of one depth.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct DepthInfo {
    /// 1 = primary rays.
    pub depth: u32,
    /// Primary, reflection and refraction rays traced at this depth.
    pub traced: u64,
    /// Shadow rays cast from their hits.
    pub shadow: u64,
}

/// One row of the profile.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct PassInfo {
    /// The kernel's name.
    pub name: String,
    /// Depth, 1 = primary rays; 0 for passes outside the per-depth loop.
    pub depth: u32,
    /// Dispatches added up in this row.
    pub launches: u64,
    /// Device seconds between timestamps, barrier included.
    pub seconds: f64,
    /// Live items (rays or pixels) worked on.
    pub items: u64,
}

/// The error budget: three parts whose sum holds the true error, in linear light clamped to [0, 1].
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorInfo {
    /// `rmse`, over all pixels and channels.
    pub kind: String,
    /// With which the sampling part holds.
    pub confidence: f64,
    /// Upper bound on what finitely many samples leave.
    pub sampling: f64,
    /// Root of the expected mean squared sampling error; no safety in it.
    pub sampling_estimate: f64,
    /// Upper bound on what rays that were not traced would have added to the image as shown.
    pub truncation: f64,
    /// False where hidden light has no bound; as shown it still adds no more than `truncation`.
    pub truncation_bounded: bool,
    /// Why it has none.
    pub truncation_unbounded_why: Option<String>,
    /// Mean throughput of the rays that were not traced.
    pub cut: f64,
    /// Difference to the same samples in f64; null where they could not be compared.
    pub rounding: Option<f64>,
    /// Pixels compared of which some sample took another way in f64.
    pub rounding_pixels: Option<u64>,
    /// The sum of the parts that are known.
    pub total: f64,
}

/// What was asked for.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct AskedInfo {
    /// `--error`.
    pub error: Option<f64>,
    /// `--time`, seconds.
    pub time: Option<f64>,
    /// Whether that was reached.
    pub met: Option<bool>,
    /// Why not.
    pub unmet_why: Option<String>,
}

/// Things that ought not to happen.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counters {
    /// Triangles without area, dropped at load.
    pub degenerate_triangles: u64,
    /// Rays with a NaN or infinity.
    pub nan_rays: u64,
    /// Lights nearer to a surface than its spawn offset, clamped.
    pub clamped_lights: u64,
    /// Traversal stack overflows.
    pub stack_overflow: u64,
    /// Traversals ended by the loop cap.
    pub loop_cap: u64,
    /// Rays that were in more solids than their list holds.
    pub media_overflow: u64,
}

/// The image.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct ImageInfo {
    /// Path as given, `-` for standard output.
    pub file: String,
    /// SHA-256 over the linear f32 RGB rows as little-endian bytes.
    pub linear_sha256: String,
}

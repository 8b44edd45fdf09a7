//! The parts of a report.

use crate::settings::{Schedule, Settings};
use serde::{Deserialize, Serialize};

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
    /// Name given by the driver.
    pub name: String,
    /// `cpu`, `discrete`, `integrated`, `virtual` or `other`.
    #[serde(rename = "type")]
    pub kind: String,
    /// Driver name and version text.
    pub driver: String,
    /// Vulkan version, `1.3.230`.
    pub api: String,
}

/// Contents of the scene.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct SceneInfo {
    /// Path as given.
    pub file: String,
    /// Triangles, after triangulation and without degenerate ones.
    pub triangles: u64,
    /// Analytic spheres.
    pub spheres: u64,
    /// Point lights.
    pub lights: u64,
    /// What was assumed in reading the scene's files, or left out; absent if nothing was.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// `name=value` of each `${name}` in the scene's text; absent if there is none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub variables: Vec<String>,
    /// The axis that `--up` names; absent if it was not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub up: Option<String>,
    /// Centre and power-of-two scale of the kernels' coordinates.
    pub local_frame: LocalFrameInfo,
}

/// `local = (world - center) * 2^scale_log2`.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct LocalFrameInfo {
    /// World coordinates of the origin of the local frame.
    pub center: [f64; 3],
    /// Binary exponent.
    pub scale_log2: i32,
}

/// The settings in force.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct SettingsInfo {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Samples per pixel.
    pub samples: u32,
    /// Rays in the longest path.
    pub depth: u32,
    /// Rays with a smaller throughput are not spawned; 0 spawns all.
    pub cutoff: f32,
    /// `random`, `stratified` or `owen`.
    pub sampler: String,
    /// Number of independently scrambled sequences that the samples are divided into.
    pub replicates: u32,
    /// `fast`, `robust` or `f64`.
    pub precision: String,
    /// Seed of the sampler.
    pub seed: u32,
    /// Origin of secondary rays: `bound` or `fixed:X`.
    pub origin: String,
    /// `[x0, y0, x1, y1]` in pixels, or null for the whole image.
    pub crop: Option<[u32; 4]>,
}

impl SettingsInfo {
    /// The report's form of `settings`.
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
    /// The settings that it is the report's form of, with a schedule of this machine's own.
    ///
    /// # Errors
    /// If a name in it is none that is known; says what to write.
    pub fn to_settings(&self, schedule: Schedule) -> Result<Settings, String> {
        let settings = Settings {
            width: self.width,
            height: self.height,
            samples: self.samples,
            depth: self.depth,
            cutoff: self.cutoff,
            sampler: self.sampler.parse()?,
            replicates: self.replicates,
            seed: self.seed,
            precision: self.precision.parse()?,
            origin: self.origin.parse()?,
            crop: self.crop,
            schedule,
        };
        settings.check().map_err(|error| error.to_string())?;
        Ok(settings)
    }

    /// The rendered rectangle, `[x0, y0, x1, y1]` in pixels.
    pub fn region(&self) -> [u32; 4] {
        self.crop.unwrap_or([0, 0, self.width, self.height])
    }
}

/// The plan.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct PlanInfo {
    /// Features of the scene that the kernels are compiled for.
    pub features: Vec<String>,
    /// Bytes of device memory.
    pub bytes: u64,
    /// Tiles of the image.
    pub tiles: u64,
    /// Batches of samples over all tiles.
    pub batches: u64,
}

/// Times, seconds.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct TimeInfo {
    /// From the library: the sum of `scene`, `build`, `first_dispatch` and `render`. From the command line: the whole
    /// process up to the report.
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

impl TimeInfo {
    fn all(&mut self) -> [&mut f64; 6] {
        let TimeInfo { wall, scene, build, first_dispatch, device, render } = self;
        [wall, scene, build, first_dispatch, device, render]
    }

    /// True if all are times: not negative, and finite.
    pub(crate) fn is_sound(&self) -> bool {
        self.clone().all().into_iter().all(|seconds| (0.0..f64::INFINITY).contains(seconds))
    }

    /// Adds the times of another part.
    pub(crate) fn add(&mut self, other: &TimeInfo) {
        let mut other = other.clone();
        self.all().into_iter().zip(other.all()).for_each(|(sum, more)| *sum += *more);
    }
}

/// Numbers of rays traced.
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
    /// The same by depth, from 1.
    pub by_depth: Vec<DepthInfo>,
}

impl RayInfo {
    /// From what each depth counted, from 1: rays traced, reflection and refraction rays among them, and shadow rays.
    /// It ends at the first depth without rays.
    pub fn of(depths: &[[u64; 4]]) -> RayInfo {
        let live = depths.iter().take_while(|counts| counts[0] > 0);
        let by_depth: Vec<DepthInfo> = (1..).zip(live).map(|(d, counts)| DepthInfo::of(d, *counts)).collect();
        let sum = |kind: fn(&DepthInfo) -> u64| by_depth.iter().map(kind).sum();
        RayInfo {
            primary: sum(|d| d.primary),
            reflection: sum(|d| d.reflection),
            refraction: sum(|d| d.refraction),
            shadow: sum(|d| d.shadow),
            by_depth,
        }
    }

    /// All rays.
    pub fn total(&self) -> u64 {
        self.primary + self.reflection + self.refraction + self.shadow
    }
}

/// Rays of one depth.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct DepthInfo {
    /// 1 = primary rays.
    pub depth: u32,
    /// Primary, reflection and refraction rays traced at this depth.
    pub traced: u64,
    /// Camera rays among them; 0 from depth 2 on.
    #[serde(default)]
    pub primary: u64,
    /// Reflection rays among them.
    #[serde(default)]
    pub reflection: u64,
    /// Refraction rays among them.
    #[serde(default)]
    pub refraction: u64,
    /// Shadow rays cast from their hits.
    pub shadow: u64,
}

impl DepthInfo {
    /// From rays traced, reflection and refraction rays among them, and shadow rays.
    pub fn of(depth: u32, [traced, reflection, refraction, shadow]: [u64; 4]) -> DepthInfo {
        let primary = traced.saturating_sub(reflection + refraction);
        DepthInfo { depth, traced, primary, reflection, refraction, shadow }
    }
}

/// One pass at one depth.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct PassInfo {
    /// The kernel's name.
    pub name: String,
    /// Depth, 1 = primary rays; 0 for passes outside the per-depth loop.
    pub depth: u32,
    /// Number of dispatches.
    pub launches: u64,
    /// Device seconds between timestamps, including the barrier.
    pub seconds: f64,
    /// Rays, samples or pixels processed.
    pub items: u64,
}

/// The error bound: four parts whose sum bounds the true error, in linear light clamped to [0, 1].
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorInfo {
    /// Kind of error: `rmse`, over all pixels and channels.
    pub kind: String,
    /// Confidence of the whole, in (0, 1).
    pub confidence: f64,
    /// Upper bound on the sampling error.
    pub sampling: f64,
    /// Best estimate of the sampling error, without a safety margin.
    pub sampling_estimate: f64,
    /// Upper bound on the contribution of rays that were not traced, to the clamped image.
    pub truncation: f64,
    /// The same from the scene's greatest radiance alone, where longer paths of some pixels gave less; null elsewhere.
    #[serde(default)]
    pub truncation_certain: Option<f64>,
    /// Number of those pixels.
    #[serde(default)]
    pub truncation_pixels: Option<u64>,
    /// False if the light of rays that were not traced has no bound; clamped, it is still at most
    /// `truncation`.
    pub truncation_bounded: bool,
    /// Reason that `truncation_bounded` is false.
    pub truncation_unbounded_why: Option<String>,
    /// Mean throughput of the rays that were not traced.
    pub cut: f64,
    /// RMSE from the same samples in f64; null if not compared.
    pub rounding: Option<f64>,
    /// Pixels with a sample whose path differs in f64.
    pub rounding_pixels: Option<u64>,
    /// RMSE from the same samples in f64 over the other pixels; null unless every sample was compared.
    #[serde(default)]
    pub rounding_values: Option<f64>,
    /// RMSE of the file as it is written; null if no file was asked for.
    #[serde(default)]
    pub encoding: Option<f64>,
    /// Part of `sampling`: what no sample met can contribute.
    #[serde(default)]
    pub unseen: f64,
    /// What could be hidden in parts of pixels that no sample met if mirrors, glass and bright surfaces showed the
    /// scene's brightest light there, without a trace in neighbouring pixels; not part of `total`; null if that is no
    /// more than `unseen`.
    #[serde(default)]
    pub not_excluded: Option<f64>,
    /// Reason that nothing of this can be relied on: rays that were not finite or were lost.
    #[serde(default)]
    pub void: Option<String>,
    /// Sum of the known parts.
    pub total: f64,
}

/// The error of the image on its way, against a reference picture.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ReferenceInfo {
    /// The picture's path as given.
    pub file: String,
    /// After each round of samples; the last is of the whole image.
    pub points: Vec<ReferencePoint>,
}

/// The error after some of the samples.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct ReferencePoint {
    /// Since the first submit, without the time that comparisons took.
    pub seconds: f64,
    /// Samples per pixel, the mean over the image.
    pub samples: f64,
    /// Rays of all kinds.
    pub rays: u64,
    /// RMSE over all pixels and channels, in linear light clamped to [0, 1].
    pub rmse: f64,
}

/// The error or time asked for.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct AskedInfo {
    /// `--error`.
    pub error: Option<f64>,
    /// `--time`, seconds.
    pub time: Option<f64>,
    /// True if it was kept.
    pub met: Option<bool>,
    /// Reason that it was not kept.
    pub unmet_why: Option<String>,
}

/// Counts of numerical faults.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counters {
    /// Triangles without area, which are ignored.
    pub degenerate_triangles: u64,
    /// Rays with a NaN or infinity.
    pub nan_rays: u64,
    /// Lights closer to a surface than the ray offset there; their distance is clamped.
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

impl Counters {
    /// Why rays that were counted here make the image unreliable, if any do.
    pub fn lost(&self) -> Option<String> {
        let faults = [
            (self.nan_rays, "with a NaN or infinity"),
            (self.stack_overflow, "that overflowed the traversal stack"),
            (self.loop_cap, "stopped at the limit on traversal steps"),
            (self.media_overflow, "inside more nested solids than are tracked"),
        ];
        let found: Vec<String> = (faults.iter().filter(|(count, _)| *count > 0))
            .map(|(count, what)| format!("{} {what}", crate::units::plural(*count, "ray")))
            .collect();
        (!found.is_empty()).then(|| format!("{}: the error of the image is unknown", found.join(", ")))
    }
}

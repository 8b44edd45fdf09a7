//! The machine-readable report: the keys of docs/report.md, filled by `render`, written as JSON.
//! Times in seconds, sizes in bytes.

#[doc(hidden)]
pub mod compiled;
pub mod explain;
mod info;
#[doc(hidden)]
pub mod prediction;
#[doc(hidden)]
pub mod receipt;
#[doc(hidden)]
pub mod table;
#[doc(hidden)]
pub mod test_counts;
#[doc(hidden)]
pub mod text;
#[doc(hidden)]
pub mod timeline;

pub use info::*;

use receipt::Receipt;
use serde::{Deserialize, Serialize};
use test_counts::TestCounts;

/// The report of one render.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Report {
    /// Version of the program.
    pub program: ProgramInfo,
    /// Device used.
    pub device: DeviceInfo,
    /// Scene rendered.
    pub scene: SceneInfo,
    /// Settings in force.
    pub settings: SettingsInfo,
    /// Sizes planned before the render.
    pub plan: PlanInfo,
    /// Times, seconds.
    pub time: TimeInfo,
    /// Rays traced.
    pub rays: RayInfo,
    /// Box and primitive tests; absent unless counted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tests: Option<TestCounts>,
    /// One row per pass and depth, in the order of dispatch.
    pub passes: Vec<PassInfo>,
    /// Error bounds; null if not asked for.
    pub error: Option<ErrorInfo>,
    /// The error against a reference picture; absent if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<ReferenceInfo>,
    /// The error or time asked for.
    pub asked: AskedInfo,
    /// Counts of numerical faults.
    pub counters: Counters,
    /// Warnings for the user, such as unreliable arithmetic or coincident solids.
    pub warnings: Vec<String>,
    /// The image file.
    pub image: ImageInfo,
    /// The receipt of `render --receipt`; otherwise absent.
    #[serde(skip_deserializing, skip_serializing_if = "Option::is_none")]
    pub receipt: Option<Receipt>,
}

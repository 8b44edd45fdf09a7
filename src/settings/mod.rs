//! What a render is asked for, apart from the scene. Pure data.

mod error;
#[doc(hidden)]
pub mod forced_features;
pub mod sampler;
mod share;

pub use error::SettingsError;
pub use share::Share;

use crate::kernel::abi;
use crate::scene::Scene;
use crate::settings::forced_features::ForcedFeatures;
use crate::settings::sampler::Sampler;
use std::str::FromStr;

/// Which Vulkan device to use.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum DeviceChoice {
    /// The most capable one: discrete, integrated, virtual, then CPU; of several, one with f64, with a driver that was measured, with
    /// longer texel buffers, with the newer Vulkan; ties by enumeration order.
    #[default]
    Best,
    /// By index in `whitted devices`.
    Index(usize),
    /// The most capable software device.
    Cpu,
    /// By UUID (32 hexadecimal digits, dashes ignored).
    Uuid([u8; 16]),
    /// By part of its name, case ignored; of several the most capable.
    Name(String),
}

impl FromStr for DeviceChoice {
    type Err = std::convert::Infallible;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let hex: String = text.chars().filter(|c| *c != '-').collect();
        Ok(if let Ok(index) = text.parse() {
            DeviceChoice::Index(index)
        } else if text.eq_ignore_ascii_case("cpu") {
            DeviceChoice::Cpu
        } else if let (32, Ok(bits)) = (hex.len(), u128::from_str_radix(&hex, 16)) {
            DeviceChoice::Uuid(bits.to_be_bytes())
        } else {
            DeviceChoice::Name(text.to_owned())
        })
    }
}

/// Arithmetic of the kernels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, PartialOrd, Ord)]
pub enum Precision {
    /// Robust, or f64 where the scene needs it and the device has it. Renders settle it; reports name what
    /// was used.
    #[default]
    Auto,
    /// f32 without the rechecks: what a plain kernel does.
    Fast,
    /// f32, zero edge functions decided exactly, hits confined to their boxes, spheres beyond f32's
    /// reach in double length.
    Robust,
    /// f64 throughout, where the device has it.
    Double,
}

impl Precision {
    /// As the command line and the report spell it.
    pub fn name(self) -> &'static str {
        match self {
            Precision::Auto => "auto",
            Precision::Fast => "fast",
            Precision::Robust => "robust",
            Precision::Double => "f64",
        }
    }
}

impl FromStr for Precision {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        [Precision::Auto, Precision::Fast, Precision::Robust, Precision::Double]
            .into_iter()
            .find(|p| p.name() == text)
            .ok_or_else(|| "write auto, fast, robust or f64".into())
    }
}

/// What a sample adds to its pixel in place of light: numbers of the first surface that it meets, or zeros.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SurfaceSums {
    /// Distance along the view in local units, 1, index of the material.
    Place,
    /// Shading normal on the ray's side.
    Normal,
}

impl SurfaceSums {
    /// As kernels know it.
    pub(crate) fn word(self) -> u32 {
        match self {
            SurfaceSums::Place => abi::LAYER_PLACE,
            SurfaceSums::Normal => abi::LAYER_NORMAL,
        }
    }
}

/// Where secondary and shadow rays start.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Origin {
    /// Off the surface by a bound on the hit point's rounding, the primitive itself skipped.
    #[default]
    Bound,
    /// This far along the ray, metres, nothing skipped: for measuring what a fixed epsilon costs.
    Fixed(f64),
}

impl Origin {
    /// As the command line and the report spell it.
    pub fn name(self) -> String {
        match self {
            Origin::Bound => "bound".into(),
            Origin::Fixed(x) => format!("fixed:{x}"),
        }
    }
}

impl FromStr for Origin {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let fixed = |x: &str| x.parse().ok().filter(|x: &f64| x.is_finite() && *x >= 0.0).map(Origin::Fixed);
        match text.strip_prefix("fixed:") {
            None if text == "bound" => Some(Origin::Bound),
            None => None,
            Some(x) => fixed(x),
        }
        .ok_or_else(|| "write bound, or fixed:X with a distance X >= 0 in metres".into())
    }
}

/// Reads the least throughput of a ray, in [0, 1).
///
/// # Errors
/// If it is no number or outside that range; says what to write.
pub fn parse_cutoff(text: &str) -> Result<f32, String> {
    match text.parse() {
        Ok(cutoff) if (0.0..1.0).contains(&cutoff) => Ok(cutoff),
        _ => Err("the least throughput must be at least 0 and below 1; 0 cuts nothing".into()),
    }
}

/// Settings of one render.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Per pixel, at least 1.
    pub samples: u32,
    /// Rays in the longest path, at least 1.
    pub depth: u32,
    /// A ray with less throughput is not spawned; 0 spawns all.
    pub cutoff: f32,
    /// How the samples of a pixel are spread over it.
    pub sampler: Sampler,
    /// Independently scrambled sequences that a pixel's samples are dealt to in turn, at least 1: their
    /// means are independent estimates of the pixel. Means nothing to [`Sampler::Random`].
    pub replicates: u32,
    /// Seed of the sampler.
    pub seed: u32,
    /// Arithmetic of the kernels.
    pub precision: Precision,
    /// Where secondary and shadow rays start.
    pub origin: Origin,
    /// Render only pixels x0 <= x < x1, y0 <= y < y1; the image has that size, and each pixel is the
    /// same as in the whole image.
    pub crop: Option<[u32; 4]>,
    /// How the work is cut; never changes a bit of the image.
    pub schedule: Schedule,
}

impl Settings {
    /// The scene's own settings.
    pub fn of(scene: &Scene) -> Settings {
        Settings {
            width: scene.camera.width,
            height: scene.camera.height,
            samples: scene.render.samples,
            depth: scene.render.depth,
            cutoff: 0.0,
            sampler: Sampler::default(),
            replicates: 1,
            seed: 0,
            precision: Precision::default(),
            origin: Origin::default(),
            crop: None,
            schedule: Schedule::default(),
        }
    }

    /// The rectangle of pixels to render: `[x0, y0, x1, y1]`.
    pub fn region(&self) -> [u32; 4] {
        self.crop.unwrap_or([0, 0, self.width, self.height])
    }
}

/// How much work goes into the hierarchy of a large scene. Never changes a bit of the image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, PartialOrd, Ord)]
pub enum Hierarchy {
    /// Binned along all axes.
    #[default]
    Balanced,
    /// The same, and then subtrees moved to where they cost less: for many rays through one scene.
    Best,
}

impl Hierarchy {
    /// All, in order of their work.
    pub const ALL: [Hierarchy; 2] = [Hierarchy::Balanced, Hierarchy::Best];

    /// As the command line spells it.
    pub fn name(self) -> &'static str {
        match self {
            Hierarchy::Balanced => "balanced",
            Hierarchy::Best => "best",
        }
    }
}

impl FromStr for Hierarchy {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Hierarchy::ALL.into_iter().find(|h| h.name() == text);
        found.ok_or_else(|| "write balanced or best".into())
    }
}

/// How the work is cut into tiles, batches and workgroups. `None` leaves it to the plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Schedule {
    /// Pixels per tile, at most.
    pub tile_pixels: Option<u32>,
    /// Samples of a pixel traced together, at most.
    pub batch_samples: Option<u32>,
    /// Invocations per workgroup: 32, 64, 128 or 256.
    pub workgroup: Option<u32>,
    /// Rays that fit a queue, at most (never fewer than a batch starts with). A queue that turns out
    /// too small costs time, not light: the tile is traced again in smaller batches.
    pub capacity: Option<u32>,
    /// How much work goes into the hierarchy.
    pub hierarchy: Hierarchy,
    /// One kernel for the stages of a depth, as in long renders, where the plan has one.
    pub fused: Option<bool>,
    /// Count box and primitive tests ([`Report::tests`](crate::Report::tests)), by kernels that are slower.
    pub count_tests: bool,
    /// Sum up what the first surfaces are instead of their light.
    pub surface_layer: Option<SurfaceSums>,
    /// Steps of a walk after which it stops and goes on in another dispatch, at most. Where a walk of a batch does, the
    /// batch is done again in parts, which costs time, not light.
    pub walk_steps: Option<u32>,
    /// Features that kernels have although the scene lacks them.
    pub forced_features: ForcedFeatures,
    /// The tiles that are rendered, those of one share; the others stay black.
    pub share: Share,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cutoffs() {
        assert_eq!((parse_cutoff("0"), parse_cutoff("0.5")), (Ok(0.0), Ok(0.5)));
        for bad in ["1", "-0.1", "NaN", "inf", ""] {
            assert!(parse_cutoff(bad).is_err(), "{bad}");
        }
    }
}

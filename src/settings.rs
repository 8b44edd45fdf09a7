//! What a render is asked for, apart from the scene. Pure data.

use crate::scene::Scene;

/// Which Vulkan device to use.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum DeviceChoice {
    /// The most capable one: discrete, integrated, virtual, then CPU; ties by enumeration order.
    #[default]
    Best,
    /// By index in `whitted devices`.
    Index(usize),
    /// The first software device.
    Cpu,
    /// By UUID (32 hexadecimal digits, dashes ignored).
    Uuid([u8; 16]),
    /// By part of its name, case ignored.
    Name(String),
}

impl std::str::FromStr for DeviceChoice {
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
    /// Seed of the sampler.
    pub seed: u32,
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
            seed: 0,
            crop: None,
            schedule: Schedule::default(),
        }
    }

    /// The rectangle of pixels to render: `[x0, y0, x1, y1]`.
    pub fn region(&self) -> [u32; 4] {
        self.crop.unwrap_or([0, 0, self.width, self.height])
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
}

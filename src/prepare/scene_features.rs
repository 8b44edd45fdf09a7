//! What a scene has, found by a scan before anything is planned; and stand-ins for what it lacks, where
//! that is switched on all the same (`forced_features`).

use crate::kernel::abi::{self, double};
use serde::Serialize;

/// What the kernels need for a scene, and no more.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct SceneFeatures {
    /// Triangles with an area.
    pub triangles: u64,
    /// Spheres.
    pub spheres: u64,
    /// Those that single precision cannot hold: radii outside 2^-14 to 2^12 of the scene's.
    #[serde(rename = "wide_spheres")]
    pub extended_spheres: u64,
    /// Some triangle has normals at its corners.
    pub smooth_normals: bool,
    /// Point lights.
    pub lights: u64,
    /// Some surface mirrors.
    pub mirrors: bool,
    /// Closed surfaces that light passes.
    pub solids: u64,
    /// Those that a ray can be in at once, at most.
    pub solids_at_once: u32,
    /// Some hit sends on two rays.
    pub branching: bool,
}

impl SceneFeatures {
    /// The scene's primitives.
    pub fn primitives(&self) -> u64 {
        self.triangles + self.spheres
    }
}

/// Where stand-ins are, in the local frame, whose scene has radius 1: so far off that a ray which meets one
/// must agree with one direction to 2^-20, and in no direction that a picture favours.
const FAR_AWAY: [f64; 3] = [636_123.0, 761_857.0, -302_339.0];

/// A triangle of that place, which no ray meets. `id` is beyond all the scene's.
pub(crate) fn triangle(id: u32) -> (double::Triangle, double::FlatNormal) {
    let [x, y, z] = FAR_AWAY;
    let (a, b, c) = ([x, y, z], [x + 1.0, y, z], [x, y + 1.0, z]);
    let (material, solid, inner_edges) = (0, 0, 0);
    let shape = double::Triangle {
        a,
        normal_x: 0.0,
        b,
        normal_y: 0.0,
        c,
        normal_z: 1.0,
        material,
        solid,
        inner_edges,
        id,
    };
    (shape, double::FlatNormal { normal: [0.0, 0.0, 1.0], pad: 0.0 })
}

/// A sphere there.
pub(crate) fn sphere(id: u32) -> double::Sphere {
    let (material, solid, wide) = (0, 0, abi::NONE);
    double::Sphere { center: FAR_AWAY, radius: 2f64.powi(-10), material, solid, wide, id }
}

/// A light that gives none, at another's place, or above the scene.
pub(crate) fn light(at: Option<&double::Light>) -> double::Light {
    double::Light { position: at.map_or([0.0, 0.0, 2.0], |l| l.position), intensity: [0.0; 3], pad: 0 }
}

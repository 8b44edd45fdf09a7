//! Where in the image a box of the scene may be seen.

use crate::scene::Scene;
use crate::scene::bounds::Bounds;
use crate::settings::Settings;
use glam::DVec3;

/// Rounding of projected coordinates, pixels: f64 has more than enough digits, f32 rays do not.
pub const MARGIN: f64 = 1e-3;

/// The camera's image.
pub struct Projection {
    eye: DVec3,
    /// View direction, and image axes divided by half the image's size at distance 1.
    forward: DVec3,
    right: DVec3,
    down: DVec3,
    /// Pixels of the image.
    pub size: [f64; 2],
    /// What is rendered of it: left, top, right, bottom.
    pub region: [u32; 4],
}

impl Projection {
    pub fn new(scene: &Scene, settings: &Settings) -> Projection {
        let c = &scene.camera;
        let [right, up, forward] = c.axes();
        let half_height = (c.fov / 2.0).tan();
        let half_width = half_height * f64::from(settings.width) / f64::from(settings.height);
        Projection {
            eye: c.look_from,
            forward,
            right: right / half_width,
            down: -up / half_height,
            size: [settings.width, settings.height].map(f64::from),
            region: settings.region(),
        }
    }

    /// The rectangle of the image, in pixels from its corner, that holds a box: left, top, right, bottom. `None` if no
    /// part of the box can be seen, everything if it reaches behind the eye.
    pub fn rectangle(&self, bounds: &Bounds) -> Option<[f64; 4]> {
        let [width, height] = self.size;
        let (mut lo, mut hi) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        // Corners before the eye, behind it, and beyond each side of what it sees: |x| <= z and |y| <= z.
        let (mut before, mut behind, mut beyond) = (false, false, [true; 4]);
        for corner in bounds.corners() {
            let v = corner - self.eye;
            let (x, y, z) = (v.dot(self.right), v.dot(self.down), v.dot(self.forward));
            let rounded = MARGIN * v.length();
            for (all, over) in beyond.iter_mut().zip([x - z, -x - z, y - z, -y - z]) {
                *all &= over > rounded;
            }
            if z <= 1e-9 * v.length() {
                behind = true;
                continue;
            }
            before = true;
            let at = [(x / z + 1.0) * 0.5 * width, (y / z + 1.0) * 0.5 * height];
            for i in 0..2 {
                (lo[i], hi[i]) = (lo[i].min(at[i]), hi[i].max(at[i]));
            }
        }
        if !before || beyond.contains(&true) {
            return None;
        }
        match behind {
            true => Some([0.0, 0.0, width, height]),
            false => Some([lo[0] - MARGIN, lo[1] - MARGIN, hi[0] + MARGIN, hi[1] + MARGIN]),
        }
    }
}

/// The halves of a box across its longest side.
pub fn halves(bounds: &Bounds) -> [Bounds; 2] {
    let size = bounds.hi - bounds.lo;
    let axis = if size.x >= size.y.max(size.z) {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    };
    let middle = 0.5 * (bounds.lo[axis] + bounds.hi[axis]);
    let (mut low, mut high) = (*bounds, *bounds);
    (low.hi[axis], high.lo[axis]) = (middle, middle);
    [low, high]
}

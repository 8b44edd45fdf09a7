//! The camera of a drawn scene, and where pixels lie in space.

use glam::DVec3;

/// A camera.
#[derive(Debug, Clone, Copy)]
pub(super) struct View {
    /// The eye.
    pub(super) from: DVec3,
    /// The point in the middle of the image.
    pub(super) at: DVec3,
    /// Up in the image, roughly.
    pub(super) up: DVec3,
    /// Vertical field of view, degrees.
    pub(super) fov: f64,
    /// Width and height, pixels.
    pub(super) size: [u32; 2],
}

impl View {
    /// Unit vectors to the right, up and forward.
    pub(super) fn axes(&self) -> [DVec3; 3] {
        let forward = (self.at - self.from).normalize();
        let right = forward.cross(self.up).normalize();
        [right, right.cross(forward), forward]
    }

    /// Width of a pixel on a plane at `distance` along the view.
    pub(super) fn pixel(&self, distance: f64) -> f64 {
        2.0 * (self.fov.to_radians() / 2.0).tan() * distance / f64::from(self.size[1])
    }

    /// The point of the plane at `distance` that is seen at column `x` and row `y`, in pixels from the top left corner.
    pub(super) fn point(&self, x: f64, y: f64, distance: f64) -> DVec3 {
        let [right, up, forward] = self.axes();
        let [width, height] = self.size.map(f64::from);
        let pixel = self.pixel(distance);
        self.from
            + forward * distance
            + right * ((x - width / 2.0) * pixel)
            + up * ((height / 2.0 - y) * pixel)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_lie_where_the_camera_sees_them() {
        let view = View { from: DVec3::ZERO, at: -DVec3::Z, up: DVec3::Y, fov: 90.0, size: [40, 20] };
        assert!((view.point(20.0, 10.0, 2.0) - DVec3::new(0.0, 0.0, -2.0)).length() < 1e-12);
        // The top left corner at 45 degrees above the middle, twice as far to the left.
        assert!((view.point(0.0, 0.0, 1.0) - DVec3::new(-2.0, 1.0, -1.0)).length() < 1e-12);
        assert!((view.pixel(1.0) - 0.1).abs() < 1e-12);
    }
}

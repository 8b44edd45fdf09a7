//! Where a mesh goes: scale, then rotate, then translate.

use glam::{DMat3, DVec3};

/// A similarity: `x -> rotate * (scale * x) + translate`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transform {
    /// Uniform, > 0.
    pub scale: f64,
    /// A rotation.
    pub rotate: DMat3,
    /// Metres.
    pub translate: DVec3,
}

impl Transform {
    /// `degrees` are the angles about the x, y and z axes, applied in that order.
    pub fn new(scale: f64, degrees: DVec3, translate: DVec3) -> Transform {
        Transform { scale, rotate: rotation(degrees), translate }
    }

    /// Where a point goes.
    pub fn point(&self, point: DVec3) -> DVec3 {
        self.rotate * (self.scale * point) + self.translate
    }

    /// Where a direction goes; lengths are kept.
    pub fn direction(&self, direction: DVec3) -> DVec3 {
        self.rotate * direction
    }
}

/// Rotation about x, then y, then z by `degrees`, counter-clockwise seen from the axis's end.
pub fn rotation(degrees: DVec3) -> DMat3 {
    let [(sx, cx), (sy, cy), (sz, cz)] = degrees.to_array().map(sin_cos);
    let x = DMat3::from_cols_array(&[1.0, 0.0, 0.0, 0.0, cx, sx, 0.0, -sx, cx]);
    let y = DMat3::from_cols_array(&[cy, 0.0, -sy, 0.0, 1.0, 0.0, sy, 0.0, cy]);
    let z = DMat3::from_cols_array(&[cz, sz, 0.0, -sz, cz, 0.0, 0.0, 0.0, 1.0]);
    z * y * x
}

/// Sine and cosine of an angle in degrees, exact at multiples of 90, so that quarter turns keep boxes
/// aligned with the axes.
fn sin_cos(degrees: f64) -> (f64, f64) {
    let turn = degrees.rem_euclid(360.0);
    let quarter = (turn / 90.0).round();
    let (s, c) = (turn - 90.0 * quarter).to_radians().sin_cos();
    match quarter as u32 % 4 {
        0 => (s, c),
        1 => (c, -s),
        2 => (-s, -c),
        _ => (-c, s),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quarter_turns_are_exact_and_in_turn() {
        assert_eq!(rotation(DVec3::new(90.0, 0.0, 0.0)) * DVec3::Y, DVec3::Z);
        assert_eq!(rotation(DVec3::new(0.0, 90.0, 0.0)) * DVec3::Z, DVec3::X);
        assert_eq!(rotation(DVec3::new(0.0, 0.0, -270.0)) * DVec3::X, DVec3::Y);
        assert_eq!(rotation(DVec3::new(90.0, 90.0, 0.0)) * DVec3::Y, DVec3::X);
    }

    #[test]
    fn angles_agree_with_radians() {
        for degrees in [-400.0, -30.0, 12.5, 44.9, 45.1, 100.0, 359.0f64] {
            let (s, c) = sin_cos(degrees);
            // The reduction and the conversion to radians cost a few roundings of angles up to 400.
            assert!((s - degrees.to_radians().sin()).abs() < 1e-14);
            assert!((c - degrees.to_radians().cos()).abs() < 1e-14);
        }
    }

    #[test]
    fn scale_comes_first() {
        let place = Transform::new(2.0, DVec3::new(0.0, 0.0, 90.0), DVec3::X);
        assert_eq!(place.point(DVec3::X), DVec3::new(1.0, 2.0, 0.0));
        assert_eq!(place.direction(DVec3::X), DVec3::Y);
    }
}

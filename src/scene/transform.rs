//! Where a mesh goes: first its own affine map (a node's matrix), then scale, rotate, translate.

use glam::{DAffine3, DMat3, DVec3};

/// `x -> rotate * (scale * (first * x)) + translate`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transform {
    /// Any invertible affine map, applied before the rest; the identity is skipped.
    first: Option<First>,
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
        Transform { first: None, scale, rotate: rotation(degrees), translate }
    }

    /// This transform with `first` applied before it. None if `first` has no inverse, or an entry that is not
    /// finite.
    pub fn after(&self, first: DAffine3) -> Option<Transform> {
        let affine = match self.first {
            Some(own) => own.affine * first,
            None => first,
        };
        if affine == DAffine3::IDENTITY {
            return Some(Transform { first: None, ..*self });
        }
        let normals = affine.matrix3.inverse().transpose();
        (affine.is_finite() && normals.is_finite())
            .then_some(Transform { first: Some(First { affine, normals }), ..*self })
    }

    /// The factor by which it stretches every length; None if it stretches some more than others.
    pub fn uniform_scale(&self) -> Option<f64> {
        let Some(First { affine, .. }) = self.first else { return Some(self.scale) };
        let [x, y, z] = [affine.matrix3.x_axis, affine.matrix3.y_axis, affine.matrix3.z_axis];
        let size = x.length();
        // Matrices written in single precision are off by 2^-24 in each of three entries, at both vectors.
        let slack = 6.0 * f64::from(f32::EPSILON) * size * size;
        let lengths = [y.length_squared(), z.length_squared()].map(|l| (l - size * size).abs());
        let angles = [x.dot(y), x.dot(z), y.dot(z)].map(f64::abs);
        lengths.iter().chain(&angles).all(|off| *off <= slack).then_some(self.scale * size)
    }

    /// True if the map turns a right hand into a left one: the order of corners then no longer
    /// says which side of a face is outside.
    pub fn mirrors(&self) -> bool {
        self.first.is_some_and(|first| first.affine.matrix3.determinant() < 0.0)
    }

    /// Where a point goes.
    pub fn point(&self, point: DVec3) -> DVec3 {
        let point = self.first.map_or(point, |first| first.affine.transform_point3(point));
        self.rotate * (self.scale * point) + self.translate
    }

    /// Where the unit `normal` of a surface points afterwards: by the inverse transpose of an affine map.
    pub fn normal(&self, normal: DVec3) -> DVec3 {
        self.rotate * self.first.map_or(normal, |first| (first.normals * normal).normalize())
    }
}

/// An affine map with the inverse transpose of its linear part.
#[derive(Debug, Clone, Copy, PartialEq)]
struct First {
    affine: DAffine3,
    normals: DMat3,
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
        assert_eq!(place.normal(DVec3::X), DVec3::Y);
    }

    #[test]
    fn normals_stay_perpendicular_to_what_is_sheared_and_mirrored() {
        let first = DAffine3::from_cols(
            DVec3::new(-2.0, 0.5, 0.0),
            DVec3::new(0.0, 1.0, 0.25),
            DVec3::new(1.0, 0.0, 3.0),
            DVec3::new(5.0, 6.0, 7.0),
        );
        let place = Transform::new(2.0, DVec3::new(10.0, 20.0, 30.0), DVec3::X).after(first).unwrap();
        assert!(place.mirrors());
        let (a, b) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(-3.0, 0.5, 1.0));
        let side = |x| place.point(x) - place.point(DVec3::ZERO);
        let normal = place.normal(a.cross(b).normalize());
        assert!(normal.dot(side(a).normalize()).abs() < 1e-15);
        assert!(normal.dot(side(b).normalize()).abs() < 1e-15);
        assert_eq!(place.after(DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0))), None);
        assert_eq!(
            Transform::new(1.0, DVec3::ZERO, DVec3::ZERO).after(DAffine3::IDENTITY).unwrap().first,
            None
        );
    }
}

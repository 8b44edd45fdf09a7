//! The report's cube: eight corners put through a 4x4 affine matrix.

use super::solid::{Corners, Solid};
use crate::scene::rotation;
use glam::{DMat4, DVec3};

/// The corners of each side, counter-clockwise seen from outside; bit 0, 1, 2 of a corner's number says
/// whether it lies at the positive end of x, y, z.
const SIDES: [[u32; 4]; 6] =
    [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

/// A cube with edges of length `size`, rotated by `degrees` about the x, y and z axes in turn, with its
/// centre moved to `center`.
pub fn rotated_cube(size: f64, degrees: DVec3, center: DVec3) -> Solid {
    let rotate = DMat4::from_mat3(rotation(degrees));
    let affine = DMat4::from_translation(center) * rotate * DMat4::from_scale(DVec3::splat(size));
    let corner = |bits: u32| DVec3::from_array([0, 1, 2].map(|axis| f64::from(bits >> axis & 1) - 0.5));
    let vertices = (0..8).map(|bits| affine.transform_point3(corner(bits))).collect();
    // Side 2 k looks along the negative axis k, side 2 k + 1 along the positive one.
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let normals = axes.iter().flat_map(|a| [-*a, *a]).map(|n| rotate.transform_vector3(n)).collect();
    let triangles = |(side, [a, b, c, d]): (usize, [u32; 4])| {
        [[a, b, c], [a, c, d]].map(|vertices| Corners { vertices, normal: side as u32 })
    };
    let faces = SIDES.into_iter().enumerate().flat_map(triangles).collect();
    Solid { name: "rotated_cube", vertices, normals, faces }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_look_outward_along_their_normals() {
        let center = DVec3::new(1.0, 2.0, 3.0);
        let cube = rotated_cube(2.0, DVec3::new(10.0, 20.0, 30.0), center);
        assert_eq!((cube.vertices.len(), cube.normals.len(), cube.faces.len()), (8, 6, 12));
        let mut area = 0.0;
        for face in &cube.faces {
            let [a, b, c] = face.vertices.map(|v| cube.vertices[v as usize]);
            let cross = (b - a).cross(c - a);
            area += cross.length() / 2.0;
            assert!(cross.normalize().distance(cube.normals[face.normal as usize]) < 1e-14);
            assert!(cross.dot(a - center) > 0.0);
        }
        assert!((area - 24.0).abs() < 1e-12);
    }
}

//! Corner normals from smoothing groups.
//!
//! At a corner the planes of all triangles are summed that share its vertex and its group and stand to its own triangle's
//! plane at less than [`CREASE_DEGREES`], each by the angle it spans there (Thuermer and Wuethrich, "Computing Vertex Normals
//! from Polygonal Facets", 1998), which does not depend on how a face is cut. Exporters that write `s 1` once for
//! a whole box keep its edges sharp that way.

use crate::scene::Face;
use crate::scene::table::unit;
use glam::DVec3;
use rayon::prelude::*;
use std::collections::HashMap;

/// Surfaces that meet at this angle or more keep their edge: a right angle does, and any round thing of five sides or more
/// is smooth.
const CREASE_DEGREES: f64 = 85.0;

/// Triangles at a vertex beyond which all of a group are summed whatever their angle, so that no vertex takes a time of the
/// square of them.
const CROWD: usize = 256;

/// How far corner normals may be off the plane's own to be that of a flat triangle: sums of equal planes, rounded.
const FLAT: f64 = 1e-12;

/// Vertices that a thread takes at a time.
const CHUNK: usize = 1 << 13;

/// Gives corner normals to the triangles in a group that have none; how many. `groups` are (first triangle, group or 0).
pub(super) fn add_normals(
    vertices: &[DVec3],
    normals: &mut Vec<DVec3>,
    faces: &mut [Face],
    groups: &[(usize, u32)],
) -> usize {
    // Corners are numbered in 32 bits.
    if faces.len() > u32::MAX as usize / 3 {
        return 0;
    }
    let group_of = |triangle: usize| {
        let at = groups.partition_point(|(first, _)| *first <= triangle);
        at.checked_sub(1).map_or(0, |at| groups[at].1)
    };
    let is_smooth = |i: usize| faces[i].normals.is_none() && group_of(i) != 0;
    let (starts, corners) = corners_by_vertex(vertices.len(), faces, is_smooth);
    let plane = |i: u32| {
        let [a, b, c] = faces[i as usize].vertices.map(|v| vertices[v as usize]);
        let size = (b - a).abs().max((c - a).abs()).max_element();
        unit(((b - a) / size).cross((c - a) / size)).unwrap_or_default()
    };
    let weighted = |corner: u32| {
        let (i, k) = (corner / 3, corner as usize % 3);
        let at = |k: usize| vertices[faces[i as usize].vertices[k % 3] as usize];
        let sides = [at(k + 1) - at(k), at(k + 2) - at(k)].map(|side| unit(side).unwrap_or_default());
        plane(i) * sides[0].dot(sides[1]).clamp(-1.0, 1.0).acos()
    };
    let crease = CREASE_DEGREES.to_radians().cos();
    // At each vertex the different normals, and the corners that have them.
    let of_vertex = |corners: &[u32], found: &mut Found| {
        let facts: Vec<(u32, DVec3, DVec3)> =
            corners.iter().map(|c| (group_of(*c as usize / 3), plane(c / 3), weighted(*c))).collect();
        let mut sums: HashMap<u32, DVec3> = HashMap::new();
        if facts.len() > CROWD {
            facts.iter().for_each(|(group, _, part)| *sums.entry(*group).or_default() += *part);
        }
        let first = found.normals.len();
        for (corner, (group, own, _)) in corners.iter().zip(&facts) {
            let near = facts.iter().filter(|(g, plane, _)| g == group && plane.dot(*own) > crease);
            let sum = sums.get(group).copied().unwrap_or_else(|| near.map(|(.., part)| *part).sum());
            // A triangle without area, which keeps no normals in the end, may have none here either.
            let normal = unit(sum).or_else(|| unit(*own)).unwrap_or(DVec3::Z);
            let known = found.normals[first..].iter().position(|n| *n == normal);
            let index = first + known.unwrap_or(found.normals.len() - first);
            if known.is_none() {
                found.normals.push(normal);
            }
            found.of_corner.push((*corner, index as u32));
        }
    };
    let chunks: Vec<Found> = (0..vertices.len().div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            let mut found = Found::default();
            for v in chunk * CHUNK..((chunk + 1) * CHUNK).min(vertices.len()) {
                of_vertex(&corners[starts[v] as usize..starts[v + 1] as usize], &mut found);
            }
            found
        })
        .collect();
    let smooth: Vec<u32> = (0..faces.len() as u32).filter(|i| is_smooth(*i as usize)).collect();
    let planes: Vec<DVec3> = smooth.par_iter().map(|i| plane(*i)).collect();
    for found in chunks {
        let base = normals.len() as u32;
        normals.extend(found.normals);
        for (corner, index) in found.of_corner {
            let face = &mut faces[corner as usize / 3];
            face.normals.get_or_insert([0; 3])[corner as usize % 3] = base + index;
        }
    }
    let mut count = 0;
    for (i, plane) in smooth.into_iter().zip(planes) {
        let face = &mut faces[i as usize];
        let off = |n: &u32| (normals[*n as usize] - plane).length() > FLAT;
        if plane != DVec3::ZERO && face.normals.is_some_and(|n| n.iter().any(off)) {
            count += 1;
        } else {
            face.normals = None;
        }
    }
    count
}

/// What a chunk of vertices gives.
#[derive(Default)]
struct Found {
    normals: Vec<DVec3>,
    /// Corner (three times its triangle, plus 0 to 2) and index in `normals`.
    of_corner: Vec<(u32, u32)>,
}

/// The corners at each vertex, those of vertex v at `starts[v]..starts[v + 1]`, in the order of triangles.
fn corners_by_vertex(
    vertices: usize,
    faces: &[Face],
    is_wanted: impl Fn(usize) -> bool,
) -> (Vec<u32>, Vec<u32>) {
    let wanted = || faces.iter().enumerate().filter(|(i, _)| is_wanted(*i));
    let mut starts = vec![0u32; vertices + 1];
    wanted().flat_map(|(_, f)| f.vertices).for_each(|v| starts[v as usize + 1] += 1);
    (0..vertices).for_each(|v| starts[v + 1] += starts[v]);
    let mut next = starts.clone();
    let mut corners = vec![0u32; starts[vertices] as usize];
    for (i, face) in wanted() {
        for (k, v) in face.vertices.into_iter().enumerate() {
            let slot = &mut next[v as usize];
            corners[*slot as usize] = (3 * i + k) as u32;
            *slot += 1;
        }
    }
    (starts, corners)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An open tube of `sides` sides about the z axis, two triangles each.
    fn tube(sides: u32) -> (Vec<DVec3>, Vec<Face>) {
        let angle = |i: u32| 2.0 * std::f64::consts::PI * f64::from(i) / f64::from(sides);
        let corner = |i: u32, z: f64| DVec3::new(angle(i).cos(), angle(i).sin(), z);
        let vertices = (0..sides).flat_map(|i| [corner(i, 0.0), corner(i, 1.0)]).collect();
        let face = |vertices| Face { vertices, normals: None, material: 0 };
        let faces = (0..sides).flat_map(|i| {
            let (a, b) = (2 * i, 2 * ((i + 1) % sides));
            [face([a, b, b + 1]), face([a, b + 1, a + 1])]
        });
        (vertices, faces.collect())
    }

    #[test]
    fn a_tube_is_round_and_a_box_is_not() {
        for (sides, round) in [(4, false), (5, true), (40, true), (2000, true)] {
            let (vertices, mut faces) = tube(sides);
            let mut normals = Vec::new();
            let count = add_normals(&vertices, &mut normals, &mut faces, &[(0, 1)]);
            assert_eq!(count, if round { faces.len() } else { 0 });
            for face in &faces {
                assert_eq!(face.normals.is_some(), round, "{sides}");
                for (v, n) in face.vertices.iter().zip(face.normals.iter().flatten()) {
                    let outward = vertices[*v as usize] * DVec3::new(1.0, 1.0, 0.0);
                    assert!(normals[*n as usize].distance(outward) < 1e-12);
                }
            }
            if round {
                assert!(normals.len() <= 4 * sides as usize);
            }
        }
    }

    #[test]
    fn groups_part_and_none_is_flat() {
        let (vertices, mut faces) = tube(8);
        let mut normals = Vec::new();
        // Four sides in group 1, two in none, two in group 2.
        add_normals(&vertices, &mut normals, &mut faces, &[(0, 1), (8, 0), (12, 2)]);
        assert!(faces[8..12].iter().all(|f| f.normals.is_none()));
        // Where group 1 ends, the normal is that of its last side.
        let side = DVec3::new(
            (7.0 * std::f64::consts::PI / 8.0).cos(),
            (7.0 * std::f64::consts::PI / 8.0).sin(),
            0.0,
        );
        let at = faces[6].vertices.iter().position(|v| *v == 8).unwrap();
        assert!(normals[faces[6].normals.unwrap()[at] as usize].distance(side) < 1e-12);
    }

    #[test]
    fn a_crowd_is_summed_at_once() {
        // A cone of 1000 sides: its tip's normal is the axis.
        let (ring, _) = tube(1000);
        let mut vertices: Vec<DVec3> = ring.into_iter().step_by(2).collect();
        vertices.push(DVec3::new(0.0, 0.0, 0.1));
        let mut faces: Vec<Face> = (0..1000)
            .map(|i| Face { vertices: [i, (i + 1) % 1000, 1000], normals: None, material: 0 })
            .collect();
        let mut normals = Vec::new();
        add_normals(&vertices, &mut normals, &mut faces, &[(0, 3)]);
        assert!(normals[faces[7].normals.unwrap()[2] as usize].distance(DVec3::Z) < 1e-9);
    }
}

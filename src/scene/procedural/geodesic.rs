//! A geodesic sphere (a subdivided icosahedron), displaced by noise.

use super::noise::gradient_noise;
use super::solid::{Corners, Solid};
use glam::DVec3;

/// The icosahedron's faces, counter-clockwise seen from outside.
const FACES: [[usize; 3]; 20] = [
    [0, 11, 5],
    [0, 5, 1],
    [0, 1, 7],
    [0, 7, 10],
    [0, 10, 11],
    [1, 5, 9],
    [5, 11, 4],
    [11, 10, 2],
    [10, 7, 6],
    [7, 1, 8],
    [3, 9, 4],
    [3, 4, 2],
    [3, 2, 6],
    [3, 6, 8],
    [3, 8, 9],
    [4, 9, 5],
    [2, 4, 11],
    [6, 2, 10],
    [8, 6, 7],
    [9, 8, 1],
];

/// Frequency and height of each octave of the displacement. The heights sum to 0.87 and noise stays
/// within 0.87, so the radius stays above 1 - 0.76: the surface never meets itself.
const OCTAVES: [(f64, f64); 4] = [(1.7, 0.45), (3.6, 0.25), (7.9, 0.12), (17.0, 0.05)];

/// Moves each octave to another part of the noise.
const OCTAVE_SHIFT: f64 = 11.3;

/// The frequency whose 20 f^2 triangles come nearest to `triangles`.
pub fn frequency(triangles: u64) -> u32 {
    let exact = (triangles as f64 / 20.0).sqrt();
    let low = exact.floor().max(1.0);
    let count = |f: f64| 20.0 * f * f;
    let wanted = triangles as f64;
    (if wanted - count(low) <= count(low + 1.0) - wanted { low } else { low + 1.0 }) as u32
}

/// A sphere of radius 1 about the origin with 20 f^2 triangles, each vertex moved along its radius by
/// gradient noise of height `roughness` in [0, 1]. Neighbours share vertices, so the mesh is closed.
pub fn displaced_sphere(f: u32, roughness: f64, seed: u32) -> Solid {
    let (mut vertices, faces) = geodesic(f);
    for v in &mut vertices {
        let mut height = 0.0;
        for (octave, (frequency, share)) in (0u32..).zip(OCTAVES) {
            let p = *v * frequency + DVec3::splat(OCTAVE_SHIFT * f64::from(octave));
            height += share * gradient_noise(p, seed.wrapping_add(octave));
        }
        *v *= 1.0 + roughness * height;
    }
    Solid { name: "displaced_sphere", vertices, normals: Vec::new(), faces }
}

/// The unit geodesic sphere of frequency `f`: 12 corners, then the inner points of 30 edges, then those
/// of 20 faces.
fn geodesic(f: u32) -> (Vec<DVec3>, Vec<Corners>) {
    let corners = icosahedron();
    let n = f as usize;
    let mut vertices = Vec::with_capacity(10 * n * n + 2);
    vertices.extend(corners);
    // First vertex of each edge's inner points, which run from the lower corner to the higher.
    let mut edges = [[0; 12]; 12];
    for face in FACES {
        for (a, b) in [(face[0], face[1]), (face[1], face[2]), (face[2], face[0])] {
            // Each edge belongs to two faces, which walk it in opposite directions.
            if a < b {
                edges[a][b] = vertices.len();
                let point = |i: usize| corners[a] * (n - i) as f64 + corners[b] * i as f64;
                vertices.extend((1..n).map(|i| point(i).normalize()));
            }
        }
    }
    let on_edge = |a: usize, b: usize, i: usize| match i {
        0 => a,
        i if i == n => b,
        i if a < b => edges[a][b] + i - 1,
        i => edges[b][a] + n - i - 1,
    };
    let mut faces = Vec::with_capacity(20 * n * n);
    for [a, b, c] in FACES {
        let inner = vertices.len();
        for i in 1..n {
            for j in 1..n - i {
                let k = n - i - j;
                let point = corners[a] * k as f64 + corners[b] * i as f64 + corners[c] * j as f64;
                vertices.push(point.normalize());
            }
        }
        // Point (i, j) lies i steps toward b and j toward c. Row i has n - i - 1 inner points.
        let at = |i: usize, j: usize| match (i, j) {
            (0, j) => on_edge(a, c, j),
            (i, 0) => on_edge(a, b, i),
            (i, j) if i + j == n => on_edge(b, c, j),
            (i, j) => inner + (i - 1) * (n - 1) - i * (i - 1) / 2 + j - 1,
        };
        let mut push = |corners: [usize; 3]| {
            faces.push(Corners { vertices: corners.map(|v| v as u32), normal: 0 });
        };
        for i in 0..n {
            for j in 0..n - i {
                push([at(i, j), at(i + 1, j), at(i, j + 1)]);
                if i + j + 2 <= n {
                    push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                }
            }
        }
    }
    (vertices, faces)
}

/// The corners of the regular icosahedron, as unit vectors.
fn icosahedron() -> [DVec3; 12] {
    let p = (1.0 + 5f64.sqrt()) / 2.0;
    let corners = [
        [-1.0, p, 0.0],
        [1.0, p, 0.0],
        [-1.0, -p, 0.0],
        [1.0, -p, 0.0],
        [0.0, -1.0, p],
        [0.0, 1.0, p],
        [0.0, -1.0, -p],
        [0.0, 1.0, -p],
        [p, 0.0, -1.0],
        [p, 0.0, 1.0],
        [-p, 0.0, -1.0],
        [-p, 0.0, 1.0],
    ];
    corners.map(|c| DVec3::from_array(c).normalize())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    #[test]
    fn the_nearest_frequency_is_chosen() {
        for (triangles, f) in
            [(20, 1), (49, 1), (51, 2), (1_000, 7), (70_000, 59), (1_113_920, 236), (10_000_000, 707)]
        {
            assert_eq!(frequency(triangles), f, "{triangles}");
        }
    }

    #[test]
    fn closed_outward_and_of_the_right_size() {
        for f in [1, 2, 3, 4, 7, 20] {
            let solid = displaced_sphere(f, 1.0, 7);
            let n = f as usize;
            assert_eq!((solid.vertices.len(), solid.faces.len()), (10 * n * n + 2, 20 * n * n));
            let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
            for face in &solid.faces {
                let [a, b, c] = face.vertices;
                for (from, to) in [(a, b), (b, c), (c, a)] {
                    assert_ne!(from, to);
                    *edges.entry((from, to)).or_default() += 1;
                }
                let [a, b, c] = face.vertices.map(|v| solid.vertices[v as usize]);
                assert!((b - a).cross(c - a).dot(a) > 0.0);
            }
            // Every edge is walked once each way: two faces share it, and they agree what outside is.
            assert!(edges.iter().all(|((a, b), count)| *count == 1 && edges.contains_key(&(*b, *a))));
            assert_eq!(edges.len(), 60 * n * n);
        }
    }

    #[test]
    fn without_roughness_it_is_a_sphere() {
        let solid = displaced_sphere(5, 0.0, 7);
        assert!(solid.vertices.iter().all(|v| (v.length() - 1.0).abs() < 1e-15));
    }
}

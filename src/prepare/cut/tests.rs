use super::*;
use crate::scene::procedural::shapes::{empty, matte, mesh, polygon};
use std::collections::HashMap;

const PLACE: Place = Place { center: DVec3::new(0.3, 1.7, -0.2), depth: 1.0 };

fn triangles(scene: &Scene) -> Vec<[DVec3; 3]> {
    let polygons = scene.polygons.iter().map(|p| [0, 1, 2].map(|i| p.vertices[i]));
    let faces =
        scene.meshes.iter().flat_map(|m| m.faces.iter().map(|f| f.vertices.map(|v| m.vertices[v as usize])));
    polygons.chain(faces).collect()
}

fn area(t: &[DVec3; 3]) -> f64 {
    (t[1] - t[0]).cross(t[2] - t[0]).length() / 2.0
}

/// A ground of two triangles in one mesh, beside one of a polygon, with common edges.
fn grounds(r: f64) -> Scene {
    let mut s = empty(vec![matte([1.0; 3], 0.0)]);
    let v = [[-r, 0.0, -r], [-r, 0.0, r], [0.7, 0.0, r], [0.7, 0.0, -r]];
    s.meshes = vec![mesh(v.map(DVec3::from).to_vec(), &[[0, 1, 2], [0, 2, 3]], 0)];
    s.polygons = vec![polygon(&[[0.7, 0.0, -r], [0.7, 0.0, r], [r, 0.0, r], [r, 0.0, -r]], 0)];
    s
}

#[test]
fn pieces_are_small_beside_their_distance_and_cover_the_shape() {
    for r in [1e3, 1e5, 1e7] {
        let pieces = triangles(&cut(&grounds(r), PLACE).unwrap());
        let total: f64 = pieces.iter().map(area).sum();
        assert!((total / (4.0 * r * r) - 1.0).abs() < 1e-12, "{total}");
        // Two sides that meet may each be two distances of their own nearest points.
        let most = LARGEST + LARGEST * LARGEST;
        for p in &pieces {
            assert!(extent(p) <= most * (PLACE.depth + PLACE.distance(p)), "{p:?}");
        }
        assert!(pieces.len() < 2000, "{}", pieces.len());
    }
}

/// Every edge but those at the rim has a piece on either side, corner for corner, across shapes too.
#[test]
fn no_edge_ends_within_another() {
    let r = 1e5;
    let pieces = triangles(&cut(&grounds(r), PLACE).unwrap());
    let mut edges: HashMap<[[u64; 3]; 2], i32> = HashMap::new();
    for p in &pieces {
        for (a, b) in [(p[0], p[1]), (p[1], p[2]), (p[2], p[0])] {
            let mut key = [a, b].map(|v| v.to_array().map(f64::to_bits));
            key.sort_unstable();
            *edges.entry(key).or_default() += 1;
        }
    }
    for (edge, count) in edges {
        let [a, b] = edge.map(|v| DVec3::from(v.map(f64::from_bits)));
        let at_rim = (0..3).any(|i| a[i] == b[i] && a[i].abs() == r);
        assert_eq!(count, if at_rim { 1 } else { 2 }, "{a} to {b}");
    }
}

#[test]
fn normals_are_those_of_the_whole_shape() {
    let mut s = grounds(1e4);
    s.polygons.clear();
    let corners = s.meshes[0].vertices.clone();
    s.meshes[0].normals = vec![DVec3::Y, DVec3::new(0.6, 0.8, 0.0), DVec3::new(0.0, 0.8, 0.6), DVec3::Y];
    s.meshes[0].faces.iter_mut().for_each(|f| f.normals = Some(f.vertices));
    let whole = s.meshes[0].clone();
    let cut = cut(&s, PLACE).unwrap();
    let mesh = &cut.meshes[0];
    for face in &mesh.faces {
        let of = |i: usize| {
            (mesh.vertices[face.vertices[i] as usize], mesh.normals[face.normals.unwrap()[i] as usize])
        };
        for (at, normal) in [0, 1, 2].map(of) {
            let fits = whole.faces.iter().any(|f| {
                let [a, b, c] = f.vertices.map(|v| corners[v as usize]);
                let (n, all) = (DVec3::Y, (b - a).cross(c - a).dot(DVec3::Y));
                let w = [(c - b, b), (a - c, c), (b - a, a)].map(|(side, p)| side.cross(at - p).dot(n) / all);
                let normals = f.vertices.map(|v| whole.normals[v as usize]);
                let want = normals[0] * w[0] + normals[1] * w[1] + normals[2] * w[2];
                w.iter().all(|w| *w > -1e-9) && (normal - want).length() < 1e-9
            });
            assert!(fits, "{at}: {normal}");
        }
    }
}

#[test]
fn what_is_small_enough_stays() {
    assert!(cut(&grounds(1.0), PLACE).is_none());
    assert!(cut(&empty(vec![matte([1.0; 3], 0.0)]), PLACE).is_none());
}

#[test]
fn a_shape_that_touches_the_eye_is_cut_to_an_end() {
    let place = Place { center: DVec3::new(0.25, 0.0, 0.125), depth: 1e-9 };
    let cut = cut(&grounds(1e5), place).unwrap();
    assert!(triangles(&cut).len() < 20_000, "{}", triangles(&cut).len());
}

/// A polygon that is no fan from its first corner is cut along its own triangles.
#[test]
fn a_concave_ground_keeps_its_outline() {
    let r = 1e6;
    // An L whose first corner sees only a part of it.
    let corners = [[0.0, -r], [0.0, 0.0], [-r, 0.0], [-r, r], [r, r], [r, -r]].map(|[x, z]| [x, 0.0, z]);
    let mut s = empty(vec![matte([1.0; 3], 0.0)]);
    s.polygons = vec![polygon(&corners, 0)];
    s.polygons[0].cut = vec![[0, 1, 4], [0, 4, 5], [1, 2, 3], [1, 3, 4]];
    assert!((s.polygons[0].triangles().map(|t| area(&t)).sum::<f64>() / (3.0 * r * r) - 1.0).abs() < 1e-12);
    let pieces = triangles(&cut(&s, PLACE).unwrap());
    assert!(pieces.len() > 20);
    let total: f64 = pieces.iter().map(area).sum();
    assert!((total / (3.0 * r * r) - 1.0).abs() < 1e-12, "{total}");
    for p in pieces {
        let middle = (p[0] + p[1] + p[2]) / 3.0;
        assert!(middle.x > 0.0 || middle.z > 0.0, "{middle} is outside");
    }
}

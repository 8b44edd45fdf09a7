//! Checks that a list of corners is a planar polygon, and cuts it into triangles.

use super::Polygon;
use super::table::unit;
use super::triangulate::{self, Cut};
use glam::DVec3;

/// How far a corner may lie off the plane, in extents of the polygon. Corners written with six
/// significant digits (C's `%g`) are off by up to 5e-6 of a coordinate, so sqrt(3) * 5e-6 in space; the
/// plane is fitted to corners that are off as much, and its fit may double and tilt may double that.
const PLANARITY: f64 = 4.0 * 1.732_050_807_568_877_2 * 5e-6;

/// How far (as a sine) a written normal may lean from the corners' own: normals written with three
/// decimals are off by sqrt(3) * 5e-4 in space; twice as much again for each end.
pub(super) const NORMAL_LEAN: f64 = 4.0 * 1.732_050_807_568_877_2 * 5e-4;

/// Why corners are no polygon: message and remedy.
pub(super) type Fault = (String, String);

/// The unit normal of planar `corners`, which are counter-clockwise about it.
pub(super) fn normal(corners: &[DVec3]) -> Result<DVec3, Fault> {
    let n = corners.len();
    if n < 3 {
        return Err((
            format!("a polygon with {n} corners"),
            "give at least three corners, `[[0, 0, 0], [1, 0, 0], [0, 1, 0]]`".to_owned(),
        ));
    }
    // Relative to the first corner and scaled to size 1, so that no product over- or underflows.
    let size = corners.iter().map(|c| (*c - corners[0]).abs().max_element()).fold(0.0, f64::max);
    if size == 0.0 {
        return Err(no_area());
    }
    let local: Vec<DVec3> = corners.iter().map(|c| (*c - corners[0]) / size).collect();
    let far = corners.iter().map(|c| c.abs().max_element()).fold(0.0, f64::max) / size;
    // A coordinate read from decimals and its difference to another are off by half an ulp each.
    let rounding = f64::EPSILON * far;

    // Newell's sum: twice the area, as a vector. Each term errs by `rounding` on two vectors no longer
    // than sqrt(3).
    let area: DVec3 = (1..n - 1).map(|i| local[i].cross(local[i + 1])).sum();
    let slack = 4.0 * n as f64 * (rounding + f64::EPSILON);
    if area.length() <= slack {
        return Err(no_area());
    }
    let normal = unit(area).ok_or_else(no_area)?;

    let center = local.iter().sum::<DVec3>() / n as f64;
    let heights = local.iter().map(|c| (*c - center).dot(normal).abs());
    let (worst, height) =
        heights.enumerate().max_by(|a, b| a.1.total_cmp(&b.1)).expect("at least three corners");
    if n > 3 && height > PLANARITY + slack {
        return Err((
            format!("not planar: corner {} lies {:e} off the plane of the others", worst + 1, height * size),
            "move the corners into one plane, or write the polygon as triangles".to_owned(),
        ));
    }

    Ok(normal)
}

/// The triangles of planar `corners`; none where the fan from the first corner is right.
pub(super) fn cut(corners: &[DVec3]) -> Result<Vec<[u32; 3]>, Fault> {
    let remedy = || "order the corners along the border, or write the polygon as several".to_owned();
    match triangulate::cut(corners) {
        Ok(Cut::Fan) => Ok(Vec::new()),
        Ok(Cut::Triangles(triangles)) => Ok(triangles),
        Err(triangulate::Fault::NoArea) => Err(no_area()),
        Err(triangulate::Fault::Crosses(a, b)) => {
            let message = format!(
                "the border crosses itself: the side from corner {} meets the side from corner {}",
                a + 1,
                b + 1
            );
            Err((message, remedy()))
        }
        Err(triangulate::Fault::Overlaps(at)) => {
            Err((format!("the border overlaps itself near corner {}", at + 1), remedy()))
        }
    }
}

fn no_area() -> Fault {
    (
        "a polygon without area".to_owned(),
        "move a corner off the line through the others, or remove the polygon".to_owned(),
    )
}

/// Takes out each corner that repeats the one before it (the last one: the first); true if there was one.
pub(super) fn drop_repeated(corners: &mut Vec<DVec3>) -> bool {
    let before = corners.len();
    corners.dedup();
    while corners.len() > 1 && corners.first() == corners.last() {
        corners.pop();
    }
    corners.len() < before
}

impl Polygon {
    /// A convex polygon, cut into a fan from its first corner.
    pub fn fan(vertices: Vec<DVec3>, normal: DVec3, material: usize) -> Polygon {
        Polygon { vertices, normal, cut: Vec::new(), material }
    }

    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        if self.cut.is_empty() { self.vertices.len() - 2 } else { self.cut.len() }
    }

    /// Corners of triangle `k`, as indices into `vertices`, counter-clockwise about the normal. The side from
    /// the second corner to the third is one of the border if any of the three is.
    pub fn triangle(&self, k: usize) -> [usize; 3] {
        self.cut.get(k).map_or([0, k + 1, k + 2], |t| t.map(|i| i as usize))
    }

    /// The corners of all triangles, metres.
    pub fn triangles(&self) -> impl Iterator<Item = [DVec3; 3]> {
        (0..self.triangle_count()).map(|k| self.triangle(k).map(|i| self.vertices[i]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn star(step: usize) -> Vec<DVec3> {
        (0..5)
            .map(|i| 2.0 * PI * (i * step) as f64 / 5.0)
            .map(|a| DVec3::new(a.cos(), a.sin(), 0.0))
            .collect()
    }

    /// The fault of corners in the plane z = 0.
    fn fault(corners: &[[f64; 2]]) -> Option<String> {
        let corners: Vec<DVec3> = corners.iter().map(|c| DVec3::new(c[0], c[1], 0.0)).collect();
        normal(&corners).and_then(|_| cut(&corners)).err().map(|(message, _)| message)
    }

    #[test]
    fn pentagon_but_no_pentagram() {
        assert!(normal(&star(1)).unwrap().distance(DVec3::Z) < 1e-15);
        assert_eq!(cut(&star(1)), Ok(Vec::new()));
        assert!(cut(&star(2)).unwrap_err().0.contains("crosses itself: the side from corner 1"));
    }

    #[test]
    fn scale_and_place_do_not_matter() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        for scale in [1e-60, 1e-3, 1.0, 1e6, 1e60] {
            for away in [0.0, 1.0, 1e6] {
                let place = |bump: f64| -> Vec<DVec3> {
                    let corner = |c: [f64; 2], z| DVec3::new(c[0] + away, c[1], z) * scale;
                    square.iter().zip([0.0, 0.0, bump, 0.0]).map(|(c, z)| corner(*c, z)).collect()
                };
                assert_eq!(normal(&place(0.0)).unwrap(), DVec3::Z, "{scale} {away}");
                assert!(normal(&place(1e-6)).is_ok(), "{scale} {away}");
                assert!(normal(&place(1e-3)).unwrap_err().0.contains("planar"), "{scale} {away}");
            }
        }
    }

    #[test]
    fn dents_are_cut_and_crossings_refused() {
        assert!(fault(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]).unwrap().contains("without area"));
        assert!(fault(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]).unwrap().contains("without area"));
        let bow_tie = fault(&[[0.0, 0.0], [4.0, 4.0], [4.0, 0.0], [1.0, 3.0]]).unwrap();
        assert!(bow_tie.contains("the side from corner 1 meets the side from corner 3"), "{bow_tie}");
        for corners in [
            &[[0.0, 0.0], [2.0, 0.0], [0.5, 0.5], [0.0, 2.0]][..],
            // A sliver is a triangle nevertheless.
            &[[0.0, 0.0], [1.0, 0.0], [1.0, 1e-9]],
            // A corner in the middle of a straight side is allowed.
            &[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [0.0, 2.0]],
        ] {
            assert_eq!(fault(corners), None, "{corners:?}");
        }
    }

    #[test]
    fn repeated_corners_count_once() {
        let mut corners = vec![DVec3::X, DVec3::X, DVec3::Y, DVec3::Z, DVec3::X, DVec3::X];
        assert!(drop_repeated(&mut corners));
        assert_eq!(corners, [DVec3::X, DVec3::Y, DVec3::Z]);
        assert!(!drop_repeated(&mut corners));
    }
}

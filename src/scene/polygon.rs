//! Checks that a list of corners is a planar convex polygon.

use super::table::unit;
use glam::DVec3;
use std::f64::consts::PI;

/// How far a corner may lie off the plane, in extents of the polygon. Corners written with six
/// significant digits (C's `%g`) are off by up to 5e-6 of a coordinate, so sqrt(3) * 5e-6 in space; the
/// plane is fitted to corners that are off as much, and its fit may double and tilt may double that.
const PLANARITY: f64 = 4.0 * 1.732_050_807_568_877_2 * 5e-6;

/// How far (as a sine) a written normal may lean from the corners' own: normals written with three
/// decimals are off by sqrt(3) * 5e-4 in space; twice as much again for each end.
pub(super) const NORMAL_LEAN: f64 = 4.0 * 1.732_050_807_568_877_2 * 5e-4;

/// Why corners are no polygon: message and remedy.
pub(super) type Fault = (String, String);

/// The unit normal of planar, convex `corners`, which are counter-clockwise about it.
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
    let zero_area = || {
        (
            "a polygon without area".to_owned(),
            "move a corner off the line through the others, or remove the polygon".to_owned(),
        )
    };
    if size == 0.0 {
        return Err(zero_area());
    }
    let local: Vec<DVec3> = corners.iter().map(|c| (*c - corners[0]) / size).collect();
    let far = corners.iter().map(|c| c.abs().max_element()).fold(0.0, f64::max) / size;
    // A coordinate read from decimals and its difference to another are off by half an ulp each.
    let rounding = f64::EPSILON * far;

    if let Some(i) = (0..n).find(|&i| local[i] == local[(i + 1) % n]) {
        return Err((
            format!("corners {} and {} are the same point", i + 1, (i + 1) % n + 1),
            "remove one of the two".to_owned(),
        ));
    }
    // Newell's sum: twice the area, as a vector. Each term errs by `rounding` on two vectors no longer
    // than sqrt(3).
    let area: DVec3 = (1..n - 1).map(|i| local[i].cross(local[i + 1])).sum();
    let slack = 4.0 * n as f64 * (rounding + f64::EPSILON);
    if area.length() <= slack {
        return Err(zero_area());
    }
    let normal = unit(area).ok_or_else(zero_area)?;

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

    let mut turned = 0.0;
    for i in 0..n {
        let here = local[(i + 1) % n];
        let (a, b) = (here - local[i], local[(i + 2) % n] - here);
        let (sine, cosine) = (a.cross(b).dot(normal), a.dot(b));
        let dent = sine < -(PLANARITY * a.length() * b.length() + slack);
        let spike = sine <= slack && cosine < 0.0;
        if n > 3 && (dent || spike) {
            return Err((
                format!("not convex at corner {}", (i + 1) % n + 1),
                "order the corners along the border, or cut the polygon into convex ones".to_owned(),
            ));
        }
        turned += sine.atan2(cosine);
    }
    // A convex border turns once (2 pi), a star's twice or more.
    if turned > 3.0 * PI {
        return Err((
            "not convex: the border crosses itself".to_owned(),
            "order the corners along the border, or cut the polygon into convex ones".to_owned(),
        ));
    }
    Ok(normal)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn star(step: usize) -> Vec<DVec3> {
        (0..5)
            .map(|i| 2.0 * PI * (i * step) as f64 / 5.0)
            .map(|a| DVec3::new(a.cos(), a.sin(), 0.0))
            .collect()
    }

    #[test]
    fn pentagon_but_no_pentagram() {
        assert!(normal(&star(1)).unwrap().distance(DVec3::Z) < 1e-15);
        assert!(normal(&star(2)).unwrap_err().0.contains("crosses itself"));
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
    fn spikes_dents_and_lines_are_refused() {
        let corners =
            |c: &[[f64; 2]]| -> Vec<DVec3> { c.iter().map(|c| DVec3::new(c[0], c[1], 0.0)).collect() };
        let fault = |c: &[[f64; 2]]| normal(&corners(c)).unwrap_err().0;
        assert!(fault(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]).contains("without area"));
        assert!(fault(&[[0.0, 0.0], [2.0, 0.0], [0.5, 0.5], [0.0, 2.0]]).contains("not convex at corner 3"));
        assert!(fault(&[[0.0, 0.0], [3.0, 0.0], [1.0, 0.0], [0.0, 1.0]]).contains("not convex"));
        assert!(fault(&[[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [0.0, 1.0]]).contains("same point"));
        assert!(fault(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]).contains("without area"));
        // A sliver is a triangle nevertheless.
        assert!(normal(&corners(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1e-9]])).is_ok());
        // A corner in the middle of a straight side is allowed.
        assert!(normal(&corners(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [0.0, 2.0]])).is_ok());
    }
}

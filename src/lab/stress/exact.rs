//! Expected hits of rays, computed in f64 from the rounded inputs of the kernels.

use super::case::Harness;
use crate::scene::Scene;
use glam::DVec3;

/// Corners of a triangle in local coordinates, rounded.
pub type Corners = [DVec3; 3];

/// All triangles in scene order, rounded as in the kernels.
pub fn local_triangles(h: &Harness<'_>, scene: &Scene) -> Vec<Corners> {
    // Computed once, since it visits every vertex.
    let frame = h.local_frame(scene);
    let local = |v: &DVec3| h.round(frame.point(*v));
    let mut all = Vec::with_capacity(scene.triangle_count());
    for p in &scene.polygons {
        all.extend(p.triangles().map(|t| t.each_ref().map(local)));
    }
    for m in &scene.meshes {
        all.extend(m.faces.iter().map(|f| f.vertices.map(|i| local(&m.vertices[i as usize]))));
    }
    all
}

/// Result of exact arithmetic for a ray and a triangle, where the rounding of the kernel cannot
/// change it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Verdict {
    /// Inside by more than the error of the kernel, at this t.
    Hit(f64),
    /// Outside by more than the error of the kernel, or behind.
    Miss,
    /// Too close to an edge to decide.
    Doubtful,
}

/// Woop's test at unit roundoff `u`. A sheared coordinate `a - s az` of a corner carries u |a| from
/// the subtraction of the origin, 5u + u from a 2.5-ulp quotient and its product, 2u from the last
/// subtraction: 9u A with A the largest component of corner - origin, so an edge moves by at most
/// 18 sqrt 2 u A < 26 u A; the edge function `c x b` adds 2u |b| |c| over the edge's length,
/// tripled since lengths across the ray are up to sqrt 3 shorter than sheared ones.
pub fn verdict(tri: &Corners, o: DVec3, d: DVec3, u: f64) -> Verdict {
    let [a, b, c] = *tri;
    let n = (b - a).cross(c - a);
    let det = d.dot(n);
    let unit = d.normalize();
    let across = |p: DVec3| {
        let f = p - o;
        (f - f.dot(unit) * unit).length()
    };
    let reach = tri.iter().map(|p| (*p - o).abs().max_element()).fold(0.0, f64::max);
    let mut certain = true;
    for (p, q) in [(a, b), (b, c), (c, a)] {
        let normal = (q - p).cross(d);
        let wide = normal.length() / d.length();
        // Signed distance of the ray from the edge's line, positive inside.
        let distance = (p - o).dot(normal) / normal.length() * det.signum();
        let band = u * (26.0 * reach + 6.0 * across(p) * across(q) / wide);
        if distance < -band {
            return Verdict::Miss;
        }
        // Also false for NaN: an edge seen end on.
        certain &= distance > band;
    }
    let t = (a - o).dot(n) / det;
    match (certain, t > 0.0) {
        (true, true) => Verdict::Hit(t),
        (true, false) => Verdict::Miss,
        _ => Verdict::Doubtful,
    }
}

/// t of a hit with edges and corners inclusive; exact where no operation rounds, as for small
/// dyadic coordinates.
pub fn inclusive(tri: &Corners, o: DVec3, d: DVec3) -> Option<f64> {
    let [a, b, c] = tri.map(|p| p - o);
    let (u, v, w) = (d.dot(c.cross(b)), d.dot(a.cross(c)), d.dot(b.cross(a)));
    let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
    let det = u + v + w;
    let n = (tri[1] - tri[0]).cross(tri[2] - tri[0]);
    let t = a.dot(n) / d.dot(n);
    (inside && det != 0.0 && t > 0.0).then_some(t)
}

//! Is a point inside a closed triangle shell?

use glam::DVec3;
use rayon::prelude::*;

/// Faces that one thread adds up; a constant, so that the sum does not depend on their number.
const CHUNK: usize = 1 << 12;

/// True if the shell of `count` faces winds around `p`: the generalised winding number (Jacobson, Kavan,
/// Sorkine-Hornung, SIGGRAPH 2013), a sum of signed solid angles (Van Oosterom and Strackee, IEEE
/// Trans. Biomed. Eng. 30(2), 1983), is nearer to +-1 than to 0. Needs one orientation throughout,
/// not an outward one; small holes do no harm.
pub fn contains(count: usize, face: impl Fn(usize) -> [DVec3; 3] + Sync, p: DVec3) -> bool {
    let angle = |corners: [DVec3; 3]| {
        let [a, b, c] = corners.map(|v| v - p);
        let (la, lb, lc) = (a.length(), b.length(), c.length());
        let numerator = a.dot(b.cross(c));
        let denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        2.0 * numerator.atan2(denominator)
    };
    let chunk = |i: usize| (i * CHUNK..count.min((i + 1) * CHUNK)).map(|f| angle(face(f))).sum();
    let sums: Vec<f64> = (0..count.div_ceil(CHUNK)).into_par_iter().map(chunk).collect();
    sums.iter().sum::<f64>().abs() > 2.0 * std::f64::consts::PI
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tetrahedron() {
        let v = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]].map(|f: [usize; 3]| f.map(|i| v[i]));
        assert!(contains(4, |i| faces[i], DVec3::splat(0.1)));
        assert!(!contains(4, |i| faces[i], DVec3::splat(0.4)));
        assert!(!contains(4, |i| faces[i], DVec3::new(-0.1, 0.1, 0.1)));
        let reversed = faces.map(|[a, b, c]| [a, c, b]);
        assert!(contains(4, |i| reversed[i], DVec3::splat(0.1)));
    }
}

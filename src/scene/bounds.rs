//! Axis-aligned boxes in the scene's own coordinates.

use glam::DVec3;

/// Axis-aligned box, f64.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Least corner.
    pub lo: DVec3,
    /// Greatest corner.
    pub hi: DVec3,
}

impl Bounds {
    /// Contains nothing.
    pub const EMPTY: Bounds = Bounds { lo: DVec3::INFINITY, hi: DVec3::NEG_INFINITY };

    /// Smallest box with `p` as well.
    pub fn with(self, p: DVec3) -> Bounds {
        Bounds { lo: self.lo.min(p), hi: self.hi.max(p) }
    }

    /// Smallest box around both.
    pub fn union(self, other: Bounds) -> Bounds {
        Bounds { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    /// A sphere's box.
    pub fn of_sphere(center: DVec3, radius: f64) -> Bounds {
        Bounds { lo: center - DVec3::splat(radius), hi: center + DVec3::splat(radius) }
    }

    /// True if it contains no point.
    pub fn is_empty(&self) -> bool {
        self.lo.cmpgt(self.hi).any()
    }

    /// True if the boxes share a point.
    pub fn touches(&self, other: &Bounds) -> bool {
        self.lo.cmple(other.hi).all() && other.lo.cmple(self.hi).all()
    }

    /// The eight corners.
    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            let pick = |axis: usize| if i >> axis & 1 == 0 { self.lo[axis] } else { self.hi[axis] };
            DVec3::new(pick(0), pick(1), pick(2))
        })
    }
}

//! The binary hierarchy that is built first, and what the builder keeps of a primitive.

use crate::kernel::abi::LEAF_BIT;
use crate::scene::bounds::Bounds;
use bytemuck::{Pod, Zeroable};
use glam::Vec3A;

/// A primitive's box in f32, its place in the scene, and its kind: all that splitting looks at, and what
/// it sorts, so that it reads memory in order.
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Prim {
    /// Least corner.
    pub lo: [f32; 3],
    /// Number of the item.
    pub index: u32,
    /// Greatest corner.
    pub hi: [f32; 3],
    /// 1 for a sphere, 0 for a triangle.
    pub kind: u32,
}

impl Prim {
    /// Of item `index`, and whether f32 holds its box as it is; where not, boxes are to be fitted again.
    pub fn of(index: u32, bounds: &Bounds, is_sphere: bool) -> (Prim, bool) {
        let (lo, hi) = (bounds.lo.to_array(), bounds.hi.to_array());
        let narrow = |x: f64| x as f32;
        let mut prim = Prim { lo: lo.map(narrow), index, hi: hi.map(narrow), kind: u32::from(is_sphere) };
        let same = (0..3).all(|a| f64::from(prim.lo[a]) == lo[a] && f64::from(prim.hi[a]) == hi[a]);
        if !same {
            // Outward. A box beyond f32's range still has a place in it.
            let down = |x: f64| if f64::from(x as f32) > x { (x as f32).next_down() } else { x as f32 };
            let within = |x: f32| x.clamp(f32::MIN, f32::MAX);
            prim.lo = lo.map(|x| within(down(x)));
            prim.hi = hi.map(|x| within(-down(-x)));
        }
        (prim, same)
    }

    pub(super) fn bounds(&self) -> Box3 {
        Box3 { lo: Vec3A::from_array(self.lo), hi: Vec3A::from_array(self.hi) }
    }
}

/// A box in f32.
#[derive(Debug, Clone, Copy)]
pub(super) struct Box3 {
    pub lo: Vec3A,
    pub hi: Vec3A,
}

impl Box3 {
    pub const EMPTY: Box3 = Box3 { lo: Vec3A::INFINITY, hi: Vec3A::NEG_INFINITY };

    pub fn union(self, other: Box3) -> Box3 {
        Box3 { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    pub fn with(self, p: Vec3A) -> Box3 {
        Box3 { lo: self.lo.min(p), hi: self.hi.max(p) }
    }

    /// Halves first: the sum of two large coordinates must not overflow.
    pub fn center(self) -> Vec3A {
        self.lo * 0.5 + self.hi * 0.5
    }
}

/// A child in the binary hierarchy: an inner node's index or a leaf as in `abi::Node`, and its box.
#[derive(Debug, Clone, Copy)]
pub(super) struct Child {
    pub link: u32,
    pub lo: [f32; 3],
    pub hi: [f32; 3],
}

impl Child {
    /// An absent child: an inverted box, which no ray enters.
    pub const ABSENT: Child = Child { link: LEAF_BIT, lo: [f32::MAX; 3], hi: [f32::MIN; 3] };

    pub fn new(link: u32, b: Box3) -> Child {
        Child { link, lo: b.lo.to_array(), hi: b.hi.to_array() }
    }

    /// In f64, whose range holds the product of any two f32.
    pub fn half_area(&self) -> f64 {
        let [x, y, z] = [0, 1, 2].map(|a| f64::from(self.hi[a]) - f64::from(self.lo[a]));
        x * y + y * z + z * x
    }
}

/// A node of the binary hierarchy.
pub(super) type Pair = [Child; 2];

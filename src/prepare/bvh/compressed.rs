//! Nodes of eight children in 128 bytes, their boxes on a grid of the node's own (Ylitie, Karras, Laine,
//! "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", HPG 2017): what a packet of
//! rays reads, each lane one child.

use super::pairs::Child;
use crate::kernel::abi::NONE;
use crate::kernel::abi::single::CompressedChild;

/// Children of a compressed node at most: lanes of a packet.
pub const CHILDREN: usize = 8;
/// Bits of a step.
const BITS: u32 = 10;
const STEPS: u32 = (1 << BITS) - 1;

/// A compressed node.
pub type CompressedNode = [CompressedChild; CHILDREN];

/// One axis of a node's grid.
#[derive(Clone, Copy)]
struct Grid {
    origin: f32,
    step: f32,
}

impl Grid {
    /// From the least to the greatest coordinate; both finite.
    fn around(lo: f32, hi: f32) -> Grid {
        let extent = f64::from(hi) - f64::from(lo);
        let mut grid = Grid { origin: lo, step: ((extent / f64::from(STEPS)) as f32).max(f32::MIN_POSITIVE) };
        let mut more = f32::EPSILON;
        while grid.at(STEPS) < hi {
            grid.step *= 1.0 + more;
            more *= 2.0;
        }
        grid
    }

    /// A coordinate, operation by operation as the kernels have it: it grows with `steps`.
    fn at(self, steps: u32) -> f32 {
        self.origin + steps as f32 * self.step
    }

    /// The last step that is not above `x`.
    fn below(self, x: f32) -> u32 {
        let mut steps = self.about(x);
        while steps > 0 && self.at(steps) > x {
            steps -= 1;
        }
        steps
    }

    /// The first that is not below.
    fn above(self, x: f32) -> u32 {
        let mut steps = self.about(x).saturating_sub(1);
        while steps < STEPS && self.at(steps) < x {
            steps += 1;
        }
        steps
    }

    fn about(self, x: f32) -> u32 {
        let steps = (f64::from(x) - f64::from(self.origin)) / f64::from(self.step);
        (steps + 1.0).clamp(0.0, f64::from(STEPS)) as u32
    }
}

/// The grid of a node's first six children's words.
fn grids(node: &CompressedNode) -> [Grid; 3] {
    let number = |k: usize| f32::from_bits(node[k].grid);
    [0, 1, 2].map(|a| Grid { origin: number(a), step: number(3 + a) })
}

/// A node of up to eight children, whose boxes hold the given ones.
pub(super) fn compressed(children: &[Child]) -> CompressedNode {
    let mut node = [CompressedChild { link: NONE, ..CompressedChild::default() }; CHILDREN];
    let present = || children.iter().filter(|c| c.lo[0] <= c.hi[0]);
    if present().next().is_none() {
        return node;
    }
    let grids = [0, 1, 2].map(|a| {
        let lo = present().map(|c| c.lo[a]).fold(f32::INFINITY, f32::min);
        let hi = present().map(|c| c.hi[a]).fold(f32::NEG_INFINITY, f32::max);
        Grid::around(lo, hi)
    });
    for (slot, child) in node.iter_mut().zip(present()) {
        let word = |steps: [u32; 3]| steps[0] | steps[1] << BITS | steps[2] << (2 * BITS);
        slot.link = child.link;
        slot.lo = word([0, 1, 2].map(|a| grids[a].below(child.lo[a])));
        slot.hi = word([0, 1, 2].map(|a| grids[a].above(child.hi[a])));
    }
    for (a, grid) in grids.iter().enumerate() {
        node[a].grid = grid.origin.to_bits();
        node[3 + a].grid = grid.step.to_bits();
    }
    node
}

/// Children of a node that are there: link, least and greatest corner as the kernels see them.
pub(super) fn children(node: &CompressedNode) -> impl Iterator<Item = (u32, [f64; 3], [f64; 3])> {
    let grids = grids(node);
    let corner =
        move |word: u32| [0, 1, 2].map(|a| f64::from(grids[a].at(word >> (a as u32 * BITS) & STEPS)));
    node.iter().filter(|c| c.link != NONE).map(move |c| (c.link, corner(c.lo), corner(c.hi)))
}

//! Nodes as the kernels read them, of more children, out of the binary hierarchy.

use super::collapse::Collapse;
use super::compressed::{self, CompressedNode};
use super::pairs::{Child, Pair};
use crate::kernel::abi::double::Node;
use crate::kernel::abi::single::CompressedChild;
use crate::kernel::abi::{LEAF_BIT, NONE, PACKET_STACK_SIZE, STACK_SIZE};
use rayon::prelude::*;

/// A form of node.
pub(super) trait Form: Clone + Send {
    /// Children at most.
    const WIDTH: usize;
    /// Entries of the stack that walks over it have.
    const STACK: usize;
    /// A node of these.
    fn of(children: &[Child]) -> Self;
    /// Children that are there: link, least and greatest corner of the box as a ray sees it.
    fn children(&self) -> impl Iterator<Item = (u32, [f64; 3], [f64; 3])>;
    /// Links of the same, to change.
    fn links_mut(&mut self) -> impl Iterator<Item = &mut u32>;
}

impl Form for Node {
    const WIDTH: usize = 4;
    const STACK: usize = STACK_SIZE as usize;
    fn of(children: &[Child]) -> Node {
        node(children)
    }
    fn children(&self) -> impl Iterator<Item = (u32, [f64; 3], [f64; 3])> {
        Node::children(self)
    }
    fn links_mut(&mut self) -> impl Iterator<Item = &mut u32> {
        self.children_mut().map(|(link, ..)| link)
    }
}

impl Form for CompressedNode {
    const WIDTH: usize = compressed::CHILDREN;
    const STACK: usize = PACKET_STACK_SIZE as usize;
    fn of(children: &[Child]) -> CompressedNode {
        compressed::compressed(children)
    }
    fn children(&self) -> impl Iterator<Item = (u32, [f64; 3], [f64; 3])> {
        compressed::children(self)
    }
    fn links_mut(&mut self) -> impl Iterator<Item = &mut u32> {
        self.iter_mut().map(|c: &mut CompressedChild| &mut c.link).filter(|link| **link != NONE)
    }
}

/// A hierarchy of nodes of one form.
pub(super) struct Widened<N> {
    /// Root first.
    pub nodes: Vec<N>,
    /// Levels.
    pub depth: usize,
    /// Entries of a traversal's stack that it can take.
    pub stack: usize,
}

fn node(children: &[Child]) -> Node {
    let child = |k: usize| children.get(k).copied().unwrap_or(Child::ABSENT);
    let (lo, hi) = (|k: usize| child(k).lo.map(f64::from), |k: usize| child(k).hi.map(f64::from));
    Node {
        lo_0: lo(0),
        hi_0: hi(0),
        lo_1: lo(1),
        hi_1: hi(1),
        lo_2: lo(2),
        hi_2: hi(2),
        lo_3: lo(3),
        hi_3: hi(3),
        child_0: child(0).link,
        child_1: child(1).link,
        child_2: child(2).link,
        child_3: child(3).link,
    }
}

/// A child of a node: its link, and its box to change.
pub(super) type Slot<'a> = (&'a mut u32, &'a mut [f64; 3], &'a mut [f64; 3]);

impl Node {
    /// Its children that are there: link, least and greatest corner.
    pub fn children(&self) -> impl Iterator<Item = (u32, [f64; 3], [f64; 3])> {
        [
            (self.child_0, self.lo_0, self.hi_0),
            (self.child_1, self.lo_1, self.hi_1),
            (self.child_2, self.lo_2, self.hi_2),
            (self.child_3, self.lo_3, self.hi_3),
        ]
        .into_iter()
        .filter(|(_, lo, hi)| lo[0] <= hi[0])
    }

    /// The same, to change.
    pub(super) fn children_mut(&mut self) -> impl Iterator<Item = Slot<'_>> {
        [
            (&mut self.child_0, &mut self.lo_0, &mut self.hi_0),
            (&mut self.child_1, &mut self.lo_1, &mut self.hi_1),
            (&mut self.child_2, &mut self.lo_2, &mut self.hi_2),
            (&mut self.child_3, &mut self.lo_3, &mut self.hi_3),
        ]
        .into_iter()
        .filter(|(_, lo, hi)| lo[0] <= hi[0])
    }
}

/// A node that is still to be made.
#[derive(Clone, Copy)]
struct Work {
    /// Of the binary hierarchy.
    pair: usize,
    /// Where its node goes.
    at: usize,
    level: usize,
    /// Entries of the stack above it.
    above: usize,
}

/// Subtrees that are made side by side; a constant, so that the nodes' order depends on the scene alone.
const PARTS: usize = 64;

/// Nodes of up to `width` children from the binary ones. Root first.
fn widened<N: Form>(pairs: &[Pair], width: usize) -> Widened<N> {
    let mut bvh = Widened { nodes: vec![N::of(&[])], depth: 0, stack: 0 };
    // Level by level down to enough subtrees, then each of them.
    let collapse = Collapse::new(pairs, width);
    let mut front = std::collections::VecDeque::from([Work { pair: 0, at: 0, level: 1, above: 0 }]);
    while front.len() < PARTS {
        let Some(work) = front.pop_front() else { break };
        bvh.widen(&collapse, work, |below| front.push_back(below));
    }
    let parts: Vec<Widened<N>> = front
        .par_iter()
        .with_max_len(1)
        .map(|root| {
            let mut part = Widened { nodes: vec![N::of(&[])], depth: 0, stack: 0 };
            let mut stack = vec![Work { at: 0, ..*root }];
            while let Some(work) = stack.pop() {
                part.widen(&collapse, work, |below| stack.push(below));
            }
            part
        })
        .collect();
    bvh.nodes.reserve_exact(parts.iter().map(|p| p.nodes.len() - 1).sum());
    for (root, part) in front.iter().zip(parts) {
        bvh.depth = bvh.depth.max(part.depth);
        bvh.stack = bvh.stack.max(part.stack);
        // Node 0 of the part takes the place kept for it, node 1 comes next here.
        let base = bvh.nodes.len() as u32 - 1;
        let moved = part.nodes.into_iter().map(|mut node| {
            for link in node.links_mut() {
                *link += if *link & LEAF_BIT == 0 { base } else { 0 };
            }
            node
        });
        let mut moved = moved;
        if let Some(first) = moved.next() {
            bvh.nodes[root.at] = first;
        }
        bvh.nodes.extend(moved);
    }
    bvh
}

impl<N: Form> Widened<N> {
    /// Of as many children as fit the stack, the first of `widths` that does.
    pub fn fitting(pairs: &[Pair], widths: &[usize]) -> Option<Widened<N>> {
        let fits = |width: usize| Some(widened(pairs, width)).filter(|w: &Widened<N>| w.stack <= N::STACK);
        widths.iter().filter(|width| **width <= N::WIDTH).find_map(|width| fits(*width))
    }

    /// Makes one node, keeps places for its children and hands them on.
    fn widen(&mut self, collapse: &Collapse, work: Work, mut hand_on: impl FnMut(Work)) {
        let (mut children, count) = collapse.children(work.pair);
        let above = work.above + count - 1;
        self.depth = self.depth.max(work.level);
        self.stack = self.stack.max(above);
        for child in &mut children[..count] {
            if child.link & LEAF_BIT == 0 {
                let at = self.nodes.len();
                self.nodes.push(N::of(&[]));
                hand_on(Work { pair: child.link as usize, at, level: work.level + 1, above });
                child.link = at as u32;
            }
        }
        self.nodes[work.at] = N::of(&children[..count]);
    }
}

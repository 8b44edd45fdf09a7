//! Subtrees moved to where they cost less (Meister and Bittner, "Parallel Reinsertion for Bounding Volume
//! Hierarchy Optimization", 2018): the best place of each is looked for on all cores, and the moves are
//! made in the order of their gain, those that would meet left for the next round.

use super::pairs::{Box3, Child, Pair};
use crate::kernel::abi::LEAF_BIT;
use glam::Vec3A;
use rayon::prelude::*;
use std::collections::BinaryHeap;

/// How far to go.
#[derive(Clone, Copy)]
pub(super) struct Effort {
    /// Nodes that take part, the largest of the tree; what is below them moves along.
    pub nodes: usize,
    /// Rounds of looking and moving.
    pub rounds: usize,
    /// One part in so many of the nodes, the largest, is looked at in each.
    pub share: usize,
}

const NONE: u32 = u32::MAX;

#[derive(Clone, Copy)]
struct Node {
    lo: Vec3A,
    hi: Vec3A,
    parent: u32,
    /// NONE for a node whose inside is left as it is.
    children: [u32; 2],
    /// In the binary hierarchy.
    link: u32,
}

/// A move of a subtree, beside the node `to`.
#[derive(Clone, Copy)]
struct Move {
    from: u32,
    to: u32,
    /// Area that the tree loses by it.
    gain: f32,
}

fn area(lo: Vec3A, hi: Vec3A) -> f32 {
    let e = hi - lo;
    e.x * e.y + e.y * e.z + e.z * e.x
}

impl Node {
    fn area(&self) -> f32 {
        area(self.lo, self.hi)
    }
}

struct Tree {
    /// The root first.
    nodes: Vec<Node>,
}

/// Moves subtrees until the rounds are over or nothing is to be gained. Gives the pairs that it changed as they
/// were, with their places.
pub(super) fn improve(pairs: &mut [Pair], effort: Effort) -> Vec<(usize, Pair)> {
    let mut tree = Tree::of(pairs, effort.nodes);
    for _ in 0..effort.rounds {
        if !tree.round(effort.share) {
            break;
        }
    }
    tree.write(pairs)
}

/// Orders nodes by their area.
#[derive(PartialEq)]
struct Largest(f32, u32);

impl Eq for Largest {}

impl Ord for Largest {
    fn cmp(&self, other: &Largest) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0).then(other.1.cmp(&self.1))
    }
}

impl PartialOrd for Largest {
    fn partial_cmp(&self, other: &Largest) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Tree {
    /// The `count` largest inner nodes of the hierarchy, and their children.
    fn of(pairs: &[Pair], count: usize) -> Tree {
        let new = |child: &Child, parent: u32| {
            let b = Box3 { lo: Vec3A::from_array(child.lo), hi: Vec3A::from_array(child.hi) };
            Node { lo: b.lo, hi: b.hi, parent, children: [NONE; 2], link: child.link }
        };
        let [left, right] = pairs[0].map(|c| Box3 { lo: c.lo.into(), hi: c.hi.into() });
        let all = left.union(right);
        let mut nodes = vec![new(&Child::new(0, all), NONE)];
        // No child is larger than its parent, so that they come in the order of their area.
        let mut front = BinaryHeap::from([Largest(nodes[0].area(), 0)]);
        for _ in 0..count {
            let Some(Largest(_, at)) = front.pop() else { break };
            for (side, child) in pairs[nodes[at as usize].link as usize].iter().enumerate() {
                let index = nodes.len() as u32;
                nodes[at as usize].children[side] = index;
                nodes.push(new(child, at));
                if child.link & LEAF_BIT == 0 {
                    front.push(Largest(nodes[index as usize].area(), index));
                }
            }
        }
        Tree { nodes }
    }

    fn node(&self, at: u32) -> &Node {
        &self.nodes[at as usize]
    }

    fn sibling(&self, at: u32) -> u32 {
        let [left, right] = self.node(self.node(at).parent).children;
        if left == at { right } else { left }
    }

    /// Looks for moves and makes them; false if there were none.
    fn round(&mut self, share: usize) -> bool {
        let mut largest: Vec<Largest> =
            self.nodes.iter().enumerate().skip(1).map(|(i, n)| Largest(n.area(), i as u32)).collect();
        let count = (largest.len() / share).max(1);
        if count < largest.len() {
            largest.select_nth_unstable_by(count - 1, |a, b| b.cmp(a));
            largest.truncate(count);
        }
        let mut moves: Vec<Move> = largest.par_iter().filter_map(|l| self.best_move(l.1)).collect();
        moves.par_sort_unstable_by(|a, b| b.gain.total_cmp(&a.gain).then(a.from.cmp(&b.from)));
        let mut touched = vec![false; self.nodes.len()];
        let mut made = false;
        for m in moves {
            let parent = self.node(m.from).parent;
            let meets = [m.from, m.to, parent, self.sibling(m.from), self.node(m.to).parent];
            if parent == 0 || meets.iter().any(|at| touched[*at as usize]) || self.is_above(m.from, m.to) {
                continue;
            }
            meets.iter().for_each(|at| touched[*at as usize] = true);
            self.make(m);
            made = true;
        }
        made
    }

    /// An earlier move of the round may have put `to` below `from`.
    fn is_above(&self, from: u32, to: u32) -> bool {
        let mut at = to;
        while at != NONE {
            if at == from {
                return true;
            }
            at = self.node(at).parent;
        }
        false
    }

    /// The place that saves most, if any does. Branch and bound: upward from the subtree, and from each
    /// sibling on the way down.
    fn best_move(&self, from: u32) -> Option<Move> {
        let node = self.node(from);
        let parent = node.parent;
        if parent == 0 {
            return None;
        }
        let own = node.area();
        let mut best = Move { from, to: NONE, gain: 0.0 };
        // What the tree loses where the subtree goes, up to the pivot.
        let mut lost = self.node(parent).area();
        let mut sibling = self.sibling(from);
        let (mut lo, mut hi) = (self.node(sibling).lo, self.node(sibling).hi);
        let mut pivot = parent;
        let mut work = Vec::with_capacity(64);
        loop {
            work.push((lost, sibling));
            while let Some((lost, at)) = work.pop() {
                if lost - own <= best.gain {
                    continue;
                }
                let place = self.node(at);
                let gain = lost - area(place.lo.min(node.lo), place.hi.max(node.hi));
                if gain > best.gain {
                    best = Move { to: at, gain, ..best };
                }
                if place.children[0] != NONE {
                    let below = gain + place.area();
                    work.extend(place.children.map(|child| (below, child)));
                }
            }
            // The root's box stays as it is: beyond its children there is no place to look.
            if pivot == 0 {
                break;
            }
            if pivot != parent {
                let other = self.node(sibling);
                (lo, hi) = (lo.min(other.lo), hi.max(other.hi));
                lost += self.node(pivot).area() - area(lo, hi);
            }
            sibling = self.sibling(pivot);
            pivot = self.node(pivot).parent;
        }
        let stays = best.to == NONE || best.to == self.sibling(from) || best.to == parent;
        (!stays).then_some(best)
    }

    /// The parent of `from` goes, to become that of `from` and `to`.
    fn make(&mut self, m: Move) {
        let parent = self.node(m.from).parent;
        let (sibling, above) = (self.sibling(m.from), self.node(parent).parent);
        self.replace(above, parent, sibling);
        let target = self.node(m.to).parent;
        self.replace(target, m.to, parent);
        self.nodes[parent as usize].children = [m.from, m.to];
        self.nodes[m.to as usize].parent = parent;
        self.fit(above);
        self.fit(parent);
    }

    fn replace(&mut self, parent: u32, old: u32, new: u32) {
        for child in &mut self.nodes[parent as usize].children {
            if *child == old {
                *child = new;
            }
        }
        self.nodes[new as usize].parent = parent;
    }

    /// Boxes from `at` to the root.
    fn fit(&mut self, mut at: u32) {
        while at != NONE {
            let [a, b] = self.node(at).children.map(|c| *self.node(c));
            let node = &mut self.nodes[at as usize];
            (node.lo, node.hi) = (a.lo.min(b.lo), a.hi.max(b.hi));
            at = node.parent;
        }
    }

    /// Every inner node keeps its place in the hierarchy. Gives what was there.
    fn write(&self, pairs: &mut [Pair]) -> Vec<(usize, Pair)> {
        let child = |at: u32| {
            let child = self.node(at);
            Child::new(child.link, Box3 { lo: child.lo, hi: child.hi })
        };
        let inner = self.nodes.iter().filter(|n| n.children[0] != NONE);
        inner
            .map(|node| {
                let at = node.link as usize;
                (at, std::mem::replace(&mut pairs[at], node.children.map(child)))
            })
            .collect()
    }
}

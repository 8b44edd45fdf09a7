//! A bounding-volume hierarchy: a binary one by the binned surface-area heuristic (Wald, "On fast
//! Construction of SAH-based Bounding Volume Hierarchies", 2007), made into one of four or eight children a
//! node, that never needs more than the kernels' stack. Built on all cores; the same whatever their number.

mod cache;
mod collapse;
mod compressed;
mod pairs;
mod reinsert;
mod split;
mod validate;
mod wide;

pub use cache::{Cache, decode};
pub use pairs::Prim;

use crate::kernel::abi::double::Node;
use crate::kernel::abi::{LEAF_BIT, LEAF_FIRST_BITS, LEAF_MAX, STACK_SIZE};
use crate::scene::bounds::Bounds;
use crate::settings::Hierarchy;
pub use compressed::CompressedNode;
use pairs::{Box3, Child, Pair};
use rayon::prelude::*;
use wide::Widened;

/// What the builder knows of a primitive.
#[derive(Debug, Clone, Copy)]
pub struct Item {
    /// Local bounds, padded and rounded exactly as the kernels do for a primitive's own box, so that
    /// every node's box contains those below it.
    pub bounds: Bounds,
    /// A leaf holds triangles or spheres, never both.
    pub is_sphere: bool,
}

/// A built hierarchy.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Bvh {
    /// Root first; at least one node, where they are wanted.
    pub nodes: Vec<Node>,
    /// The same for packets, eight children a node; root first.
    pub compressed: Vec<CompressedNode>,
    /// Item stored at each place: all triangles in leaf order, then all spheres.
    pub order: Vec<u32>,
    /// Levels of inner nodes, of the form with more.
    pub depth: usize,
    /// Entries of a traversal's stack that `nodes` can take.
    pub stack: usize,
    /// Entries of a packet's stack that `compressed` can take.
    pub packet_stack: usize,
}

/// Bins an axis, and among few primitives: a bin then holds one or none all the same.
const BINS: usize = 16;
const FEW_BINS: usize = 8;
/// Primitives up to which they are few.
const FEW: usize = 24;
/// Primitives per leaf at which splitting stops even if it pays: a leaf is one run of loads.
const LEAF_TARGET: usize = 2;
/// Two primitives are parted where their surfaces are less than this share of what a leaf of both would show twice:
/// measured, spheres beside each other gain by it, and triangles that share an edge seldom do
/// (docs/design/decisions/024-leaf-size.md).
const LEAF_SHARE: f64 = 0.65;
/// Subtrees of at most one part in this many of all primitives are one thread's work.
const TASKS: usize = 64;
/// Primitives below which a subtree is not worth another thread.
const TASK_LEAST: usize = 4096;

/// Boxes grow by this on every side: Woop's own enlargement is at most 20u in a frame of radius 1,
/// 32u = 2^-19 covers it (numerics.md, Boxes).
pub const PADDING: f64 = 1.0 / 524_288.0;

/// The forms of nodes that a hierarchy is made into.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Forms {
    /// Both that there are.
    #[default]
    Both,
    /// [`Bvh::nodes`] alone: each ray walks by itself.
    Nodes,
    /// [`Bvh::compressed`] alone: rays walk in packets.
    Compressed,
}

/// What a hierarchy is to be.
#[derive(Debug, Clone, Copy, Default)]
pub struct Wanted<'a> {
    /// Triangles, spheres stay outside, in their own order.
    pub outside: [bool; 2],
    /// The work that goes into it.
    pub quality: Hierarchy,
    /// The nodes that are asked for.
    pub forms: Forms,
    /// Where it may be found or kept.
    pub cache: Option<&'a Cache>,
}

/// Builds over `items` (triangles and spheres in any order).
pub fn build(items: &[Item], wanted: &Wanted) -> Bvh {
    let made: Vec<(Prim, bool)> = items
        .par_iter()
        .enumerate()
        .map(|(i, item)| Prim::of(i as u32, &item.bounds, item.is_sphere))
        .collect();
    let exact = made.iter().all(|(_, same)| *same);
    let prims = made.into_iter().map(|(prim, _)| prim).collect();
    let boxes = |i: u32| items[i as usize].bounds;
    build_prims(prims, wanted, if exact { None } else { Some(&boxes) })
}

/// Boxes of items by number.
pub type Boxes<'a> = &'a (dyn Fn(u32) -> Bounds + Sync);

/// Builds over `prims`. Where f32 does not hold their boxes as they are, `exact` gives them: the tree is
/// then chosen by the boxes in f32, and its nodes take theirs from the exact ones.
pub fn build_prims(prims: Vec<Prim>, wanted: &Wanted, exact: Option<Boxes>) -> Bvh {
    // Files hold boxes in f32.
    let cache = wanted.cache.filter(|_| exact.is_none());
    let entry = cache.and_then(|c| c.file(&prims, wanted));
    if let Some(found) = entry.as_ref().and_then(|e| e.load()) {
        return found;
    }
    let mut bvh = built(prims, wanted);
    if let Some(boxes) = exact {
        bvh.refit(boxes);
    }
    if let Some(entry) = entry {
        entry.store(&bvh);
    }
    bvh
}

fn built(prims: Vec<Prim>, wanted: &Wanted) -> Bvh {
    let triangles = prims.iter().filter(|p| p.kind == 0).count();
    let (mut order, mut prims) = apart(prims, wanted.outside);
    // Triangles come first.
    let spheres_outside = order.split_off(order.partition_point(|p| p.kind == 0));
    let kinds = [0, 1].map(|kind| prims.iter().any(|p| p.kind == kind));
    let task = (prims.len() / TASKS).max(TASK_LEAST);
    let builder = Builder { mixed: kinds == [true; 2], task };
    let mut pairs = match prims.len() {
        0 => vec![[Child::ABSENT; 2]],
        _ if builder.leaf_fits(&prims) => vec![[leaf(&prims, 0), Child::ABSENT]],
        _ => builder.build(&mut prims),
    };
    if kinds[1] {
        // Leaves hold places among all; kernels want them by kind.
        let mut next = [order.len() as u32, (triangles + spheres_outside.len()) as u32];
        let place = |p: &Prim| {
            let place = &mut next[p.kind as usize];
            *place += 1;
            *place - 1
        };
        let places: Vec<u32> = prims.iter().map(place).collect();
        for child in pairs.iter_mut().flatten().filter(|c| c.link & LEAF_BIT != 0 && c.lo[0] <= c.hi[0]) {
            let first = child.link & FIRST_MASK;
            child.link = child.link & !FIRST_MASK | places[first as usize];
        }
    }
    let mut before = Vec::new();
    for effort in efforts(wanted.quality, pairs.len()) {
        before.extend(reinsert::improve(&mut pairs, effort));
    }
    let mut bvh = Bvh::default();
    if !bvh.widen(&pairs, wanted.forms, &[8, 4]) {
        before.into_iter().rev().for_each(|(at, pair)| pairs[at] = pair);
        // A level of the binary hierarchy as it is built leaves one entry on the stack, so that two wide fits.
        bvh.widen(&pairs, wanted.forms, &[8, 4, 2]);
    }
    drop(pairs);
    let of_kind = |kind: u32| prims.iter().filter(move |p| p.kind == kind);
    bvh.order = Vec::with_capacity(order.len() + spheres_outside.len() + prims.len());
    bvh.order.extend(order.iter().chain(of_kind(0)).map(|p| p.index));
    bvh.order.extend(spheres_outside.iter().chain(of_kind(1)).map(|p| p.index));
    bvh
}

/// What to improve in a hierarchy of so many nodes. Most is to be gained among the largest: few, they are
/// met by every ray, and where walls stand around a mesh they are what binning does worst
/// (docs/design/decisions/011-reinsertion.md).
fn efforts(quality: Hierarchy, nodes: usize) -> Vec<reinsert::Effort> {
    let top = reinsert::Effort { nodes: 1024, rounds: 8, share: 1 };
    let all = reinsert::Effort { nodes, rounds: 8, share: 4 };
    match quality {
        _ if nodes < 3 => Vec::new(),
        Hierarchy::Balanced => vec![top],
        Hierarchy::Best => vec![top, all],
    }
}

/// The primitives outside the hierarchy, triangles first, and those in it.
fn apart(prims: Vec<Prim>, outside: [bool; 2]) -> (Vec<Prim>, Vec<Prim>) {
    if outside == [false; 2] {
        return (Vec::new(), prims);
    }
    let (mut out, within): (Vec<Prim>, Vec<Prim>) = prims.into_iter().partition(|p| outside[p.kind as usize]);
    out.sort_by_key(|p| p.kind);
    (out, within)
}

const FIRST_MASK: u32 = (1 << LEAF_FIRST_BITS) - 1;

/// A leaf of all `prims`, the first of which is at place `first`.
fn leaf(prims: &[Prim], first: usize) -> Child {
    let link = LEAF_BIT | (prims.len() as u32 - 1) << LEAF_FIRST_BITS | first as u32;
    Child::new(link, split::bounds(prims))
}

struct Builder {
    /// Triangles and spheres are both there.
    mixed: bool,
    /// Primitives that one thread takes at once, at most.
    task: usize,
}

/// The upper part of the hierarchy, down to what one thread built.
enum Top {
    Node(Box3, Box<[Top; 2]>),
    /// Its root, and its inner nodes as numbered there.
    Task(Child, Vec<Pair>),
}

impl Top {
    /// Joins all in one list.
    fn place(self, pairs: &mut Vec<Pair>) -> Child {
        match self {
            Top::Node(bounds, children) => {
                let at = pairs.len();
                pairs.push([Child::ABSENT; 2]);
                pairs[at] = children.map(|child| child.place(pairs));
                Child::new(at as u32, bounds)
            }
            Top::Task(root, inner) => {
                let base = pairs.len() as u32;
                let moved =
                    |c: Child| Child { link: c.link + if c.link & LEAF_BIT == 0 { base } else { 0 }, ..c };
                pairs.extend(inner.into_iter().map(|pair| pair.map(moved)));
                moved(root)
            }
        }
    }
}

impl Builder {
    /// Root first.
    fn build(&self, prims: &mut [Prim]) -> Vec<Pair> {
        let mut pairs = Vec::new();
        let bounds = split::bounds(prims);
        self.top(prims, 0, 1, bounds).place(&mut pairs);
        pairs
    }

    fn top(&self, prims: &mut [Prim], first: usize, level: usize, bounds: Box3) -> Top {
        if prims.len() <= self.task {
            let mut inner = Vec::with_capacity(prims.len());
            let root = self.subtree(prims, first, level, bounds, &mut inner);
            inner.shrink_to_fit();
            return Top::Task(root, inner);
        }
        let (middle, [a, b]) = self.partition(prims, level);
        let (left, right) = prims.split_at_mut(middle);
        let (left, right) = rayon::join(
            || self.top(left, first, level + 1, a),
            || self.top(right, first + middle, level + 1, b),
        );
        Top::Node(bounds, Box::new([left, right]))
    }

    /// True if `prims` make one leaf: few, of one kind, and close.
    fn leaf_fits(&self, prims: &[Prim]) -> bool {
        let surface = |b: Box3| Child::new(0, b).half_area();
        match prims {
            _ if prims.len() > LEAF_TARGET || (self.mixed && are_mixed(prims)) => false,
            [a, b] => {
                let (a, b) = (a.bounds(), b.bounds());
                surface(a) + surface(b) >= LEAF_SHARE * 2.0 * surface(a.union(b))
            }
            _ => true,
        }
    }

    /// A subtree over `prims`, whose parent is at level `level - 1`.
    fn subtree(
        &self,
        prims: &mut [Prim],
        first: usize,
        level: usize,
        bounds: Box3,
        pairs: &mut Vec<Pair>,
    ) -> Child {
        if self.leaf_fits(prims) {
            return leaf(prims, first);
        }
        let at = pairs.len();
        pairs.push([Child::ABSENT; 2]);
        let (middle, [a, b]) = self.partition(prims, level);
        let (left, right) = prims.split_at_mut(middle);
        let a = self.subtree(left, first, level + 1, a, pairs);
        let b = self.subtree(right, first + middle, level + 1, b, pairs);
        pairs[at] = [a, b];
        Child::new(at as u32, bounds)
    }

    /// Reorders `prims` and says where to cut, with the boxes of both sides: the best binned SAH plane if
    /// both sides can still be finished by halving within the stack, else the median.
    fn partition(&self, prims: &mut [Prim], level: usize) -> (usize, [Box3; 2]) {
        let n = prims.len();
        let centers = split::centers(prims);
        // Levels that halving still needs: to single items, and one to part kinds.
        let needs = |n: usize| n.next_power_of_two().trailing_zeros() as usize + 1;
        let plane = match n {
            ..=FEW => split::best_plane::<FEW_BINS>(prims, &centers),
            _ => split::best_plane::<BINS>(prims, &centers),
        };
        if let Some((plane, sides)) = plane {
            let middle = partition_by(prims, |p| plane.is_left(p));
            let larger = middle.max(n - middle);
            if middle > 0 && middle < n && level + needs(larger) < STACK_SIZE as usize {
                return (middle, sides);
            }
        }
        let middle = if self.mixed && n <= LEAF_MAX as usize && are_mixed(prims) {
            partition_by(prims, |p| p.kind == 0)
        } else {
            let extent = (centers.hi - centers.lo).to_array();
            let axis = (0..3).max_by(|a, b| extent[*a].total_cmp(&extent[*b])).unwrap_or(0);
            let center = |p: &Prim| p.lo[axis] * 0.5 + p.hi[axis] * 0.5;
            prims.select_nth_unstable_by(n / 2, |a, b| {
                center(a).total_cmp(&center(b)).then(a.index.cmp(&b.index))
            });
            n / 2
        };
        (middle, [split::bounds(&prims[..middle]), split::bounds(&prims[middle..])])
    }
}

fn are_mixed(prims: &[Prim]) -> bool {
    prims.iter().any(|p| p.kind != prims[0].kind)
}

/// A two-pointer partition whose result depends on the input alone. It swaps whether or not: which side
/// a primitive goes to, no branch predictor knows.
fn partition_by(prims: &mut [Prim], left: impl Fn(&Prim) -> bool) -> usize {
    let mut at = 0;
    for i in 0..prims.len() {
        let goes_left = left(&prims[i]);
        prims.swap(at, i);
        at += usize::from(goes_left);
    }
    at
}

impl Bvh {
    /// Makes nodes out of the binary hierarchy, of the first of `widths` that keeps the stack. False if none does.
    fn widen(&mut self, pairs: &[Pair], forms: Forms, widths: &[usize]) -> bool {
        self.depth = 0;
        if forms != Forms::Compressed {
            let Some(made) = Widened::fitting(pairs, widths) else { return false };
            (self.nodes, self.stack, self.depth) = (made.nodes, made.stack, made.depth);
        }
        if forms != Forms::Nodes {
            let Some(made) = Widened::fitting(pairs, widths) else { return false };
            (self.compressed, self.packet_stack) = (made.nodes, made.stack);
            self.depth = self.depth.max(made.depth);
        }
        true
    }

    /// What a line that meets the root's box meets below it on average, if lines are spread evenly: nodes, and
    /// primitives' boxes with each counted where its leaf is (Goldsmith and Salmon, "Automatic Creation of
    /// Object Hierarchies for Ray Tracing", 1987). The root counts as one.
    pub fn expected(&self) -> (f64, f64) {
        let half_area = |lo: [f64; 3], hi: [f64; 3]| {
            let e = [0, 1, 2].map(|a| hi[a] - lo[a]);
            e[0] * e[1] + e[1] * e[2] + e[2] * e[0]
        };
        let root = self.nodes[0]
            .children()
            .fold(Bounds::EMPTY, |b, (_, lo, hi)| b.union(Bounds { lo: lo.into(), hi: hi.into() }));
        let whole = half_area(root.lo.to_array(), root.hi.to_array());
        let (mut nodes, mut primitives) = (1.0, 0.0);
        for (link, lo, hi) in self.nodes.iter().flat_map(Node::children) {
            let chance = half_area(lo, hi) / whole;
            match link & LEAF_BIT {
                0 => nodes += chance,
                _ => primitives += chance * f64::from(((link & !LEAF_BIT) >> LEAF_FIRST_BITS) + 1),
            }
        }
        (nodes, primitives)
    }

    /// Gives every node the boxes of what is below it.
    fn refit(&mut self, boxes: Boxes) {
        let mut whole = vec![Bounds::EMPTY; self.nodes.len()];
        // Children come after their parents.
        for at in (0..self.nodes.len()).rev() {
            let mut node = self.nodes[at];
            for (link, lo, hi) in node.children_mut() {
                let bounds = if *link & LEAF_BIT == 0 {
                    whole[*link as usize]
                } else {
                    let first = (*link & FIRST_MASK) as usize;
                    let count = ((*link & !LEAF_BIT) >> LEAF_FIRST_BITS) as usize + 1;
                    let items = &self.order[first..first + count];
                    items.iter().fold(Bounds::EMPTY, |b, i| b.union(boxes(*i)))
                };
                (*lo, *hi) = (bounds.lo.to_array(), bounds.hi.to_array());
                whole[at] = whole[at].union(bounds);
            }
            self.nodes[at] = node;
        }
    }
}

#[cfg(test)]
mod tests;

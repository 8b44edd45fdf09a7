//! A bounding-volume hierarchy: a binary one by the binned surface-area heuristic (Wald, "On fast
//! Construction of SAH-based Bounding Volume Hierarchies", 2007), made into one of four children a node,
//! that never needs more than the kernels' stack. Built on all cores; the same whatever their number.

mod pairs;
mod split;
mod validate;
mod wide;

pub use pairs::Prim;

use crate::abi::double::Node;
use crate::abi::{LEAF_BIT, LEAF_FIRST_BITS, LEAF_MAX, STACK_SIZE};
use crate::frame::Bounds;
use pairs::{Box3, Child, Pair};
use rayon::prelude::*;
use wide::{WIDTH, widened};

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
#[derive(Debug, Clone, Default)]
pub struct Bvh {
    /// Root first; at least one node.
    pub nodes: Vec<Node>,
    /// Item stored at each place: all triangles in leaf order, then all spheres.
    pub order: Vec<u32>,
    /// Levels of inner nodes.
    pub depth: usize,
    /// Entries of a traversal's stack that it can take.
    pub stack: usize,
}

/// Bins an axis, and among few primitives: a bin then holds one or none all the same.
const BINS: usize = 16;
const FEW_BINS: usize = 8;
/// Primitives up to which they are few.
const FEW: usize = 24;
/// Primitives per leaf at which splitting stops even if it pays: a leaf is one run of loads.
const LEAF_TARGET: usize = 2;
/// Subtrees of at most one part in this many of all primitives are one thread's work.
const TASKS: usize = 64;
/// Primitives below which a subtree is not worth another thread.
const TASK_LEAST: usize = 4096;

/// Boxes grow by this on every side: Woop's own enlargement is at most 20u in a frame of radius 1,
/// 32u = 2^-19 covers it (numerics.md, Boxes).
pub const PADDING: f64 = 1.0 / 524_288.0;

/// Builds over `items` (triangles and spheres in any order). `loose`: triangles, spheres stay outside, in
/// their own order.
pub fn build(items: &[Item], loose: [bool; 2]) -> Bvh {
    let made: Vec<(Prim, bool)> = items
        .par_iter()
        .enumerate()
        .map(|(i, item)| Prim::of(i as u32, &item.bounds, item.is_sphere))
        .collect();
    let exact = made.iter().all(|(_, same)| *same);
    let prims = made.into_iter().map(|(prim, _)| prim).collect();
    let boxes = |i: u32| items[i as usize].bounds;
    build_prims(prims, loose, if exact { None } else { Some(&boxes) })
}

/// Boxes of items by number.
pub type Boxes<'a> = &'a (dyn Fn(u32) -> Bounds + Sync);

/// Builds over `prims`. Where f32 does not hold their boxes as they are, `exact` gives them: the tree is
/// then chosen by the boxes in f32, and its nodes take theirs from the exact ones.
pub fn build_prims(prims: Vec<Prim>, loose: [bool; 2], exact: Option<Boxes>) -> Bvh {
    let triangles = prims.iter().filter(|p| p.kind == 0).count();
    let (mut order, mut prims) = apart(prims, loose);
    // A loose kind is not in the tree, so that these are all of it.
    let spheres_first = order.iter().position(|p| p.kind == 1).unwrap_or(order.len());
    let loose_spheres = order.split_off(spheres_first);
    let kinds = [prims.iter().any(|p| p.kind == 0), prims.iter().any(|p| p.kind == 1)];
    let task = (prims.len() / TASKS).max(TASK_LEAST);
    let builder = Builder { mixed: kinds == [true; 2], task };
    let mut pairs = match prims.len() {
        0 => vec![[Child::ABSENT; 2]],
        _ if builder.leaf_fits(&prims) => vec![[leaf(&prims, 0), Child::ABSENT]],
        _ => builder.build(&mut prims),
    };
    // Leaves hold places among all; kernels want them by kind.
    let mut places = [order.len() as u32, (triangles + loose_spheres.len()) as u32];
    if kinds[1] {
        let place_of: Vec<u32> = prims
            .iter()
            .map(|p| {
                let place = &mut places[p.kind as usize];
                *place += 1;
                *place - 1
            })
            .collect();
        for child in pairs.iter_mut().flatten().filter(|c| c.link & LEAF_BIT != 0 && c.lo[0] <= c.hi[0]) {
            let first = child.link & FIRST_MASK;
            child.link = child.link & !FIRST_MASK | place_of[first as usize];
        }
    }
    // A level of the binary hierarchy leaves one entry on the stack, so that two wide always fits.
    let fits = |width| Some(widened(&pairs, width)).filter(|b| b.stack <= STACK_SIZE as usize);
    let mut bvh = fits(WIDTH).unwrap_or_else(|| widened(&pairs, 2));
    drop(pairs);
    let of_kind = |kind: u32| prims.iter().filter(move |p| p.kind == kind).map(|p| p.index);
    let loose_of = |prims: Vec<Prim>| prims.into_iter().map(|p| p.index);
    let mut numbers: Vec<u32> = Vec::with_capacity(order.len() + loose_spheres.len() + prims.len());
    numbers.extend(loose_of(order).chain(of_kind(0)));
    numbers.extend(loose_of(loose_spheres).chain(of_kind(1)));
    bvh.order = numbers;
    if let Some(boxes) = exact {
        bvh.refit(boxes);
    }
    bvh
}

/// The primitives outside the hierarchy, triangles first, and those in it.
fn apart(prims: Vec<Prim>, loose: [bool; 2]) -> (Vec<Prim>, Vec<Prim>) {
    if loose == [false; 2] {
        return (Vec::new(), prims);
    }
    let (mut out, within): (Vec<Prim>, Vec<Prim>) = prims.into_iter().partition(|p| loose[p.kind as usize]);
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

    /// True if `prims` make one leaf: few, and of one kind.
    fn leaf_fits(&self, prims: &[Prim]) -> bool {
        prims.len() <= LEAF_TARGET && !(self.mixed && are_mixed(prims))
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
mod tests {
    use super::*;
    use crate::sampler::pcg4d;
    use glam::DVec3;

    const NONE_LOOSE: [bool; 2] = [false; 2];

    fn boxes(n: u32, spheres: u32, spread: f64) -> Vec<Item> {
        (0..n)
            .map(|i| {
                let h = pcg4d([i, 1, 2, 3]).map(|c| f64::from(c) / f64::from(u32::MAX) - 0.5);
                let lo = DVec3::new(h[0], h[1], h[2]) * spread;
                Item {
                    bounds: Bounds { lo, hi: lo + DVec3::splat(h[3].abs() * 0.01) },
                    is_sphere: i < spheres,
                }
            })
            .collect()
    }

    #[test]
    fn sound_for_all_sizes() {
        for n in [0, 1, 2, 3, 5, 17, 100, 3000] {
            let items = boxes(n, n / 3, 1.0);
            build(&items, NONE_LOOSE).validate(&items).unwrap();
        }
    }

    #[test]
    fn coincident_and_clustered_items_stay_within_the_stack() {
        let same = vec![Item { bounds: Bounds::EMPTY.with(DVec3::ZERO), is_sphere: false }; 100_000];
        build(&same, NONE_LOOSE).validate(&same).unwrap();
        // Each item half as far out as the last: SAH would peel them off one by one.
        let cluster: Vec<Item> = (0..500)
            .map(|i| Item {
                bounds: Bounds::of_sphere(DVec3::splat(2f64.powi(-i)), 2f64.powi(-i - 2)),
                is_sphere: true,
            })
            .collect();
        build(&cluster, NONE_LOOSE).validate(&cluster).unwrap();
    }

    /// Boxes that defeat heuristics: flat, equal, denormal, huge, nested, in geometric progressions of
    /// either kind, and all of them together.
    #[test]
    fn odd_boxes_stay_within_the_stack() {
        let item = |lo: DVec3, size: DVec3, i: usize| Item {
            bounds: Bounds { lo, hi: lo + size },
            is_sphere: i.is_multiple_of(3),
        };
        let row = |n: usize, f: &dyn Fn(usize) -> (DVec3, DVec3)| -> Vec<Item> {
            (0..n)
                .map(|i| {
                    let (lo, size) = f(i);
                    item(lo, size, i)
                })
                .collect()
        };
        let power = |i: usize| 2f64.powi(-(i as i32 % 1000));
        let sets: Vec<Vec<Item>> = vec![
            row(1000, &|i| (DVec3::X * power(i), DVec3::ZERO)),
            row(1000, &|i| (DVec3::splat(-power(i)), DVec3::splat(2.0 * power(i)))),
            row(700, &|i| (DVec3::splat(5.693442e-39 * (i % 7) as f64), DVec3::X * 5.693442e-39)),
            row(500, &|i| (DVec3::Y * 1e38 * (i % 2) as f64, DVec3::Z * 1e37)),
            row(4096, &|i| {
                (DVec3::new((i % 16) as f64, (i / 16 % 16) as f64, (i / 256) as f64), DVec3::ZERO)
            }),
            // One far from a great many at one place.
            row(50_000, &|i| (DVec3::X * if i == 0 { 1e30 } else { 0.0 }, DVec3::ZERO)),
            // Two places a denormal apart.
            row(333, &|i| (DVec3::X * if i % 2 == 0 { 0.0 } else { f64::from_bits(1) }, DVec3::ZERO)),
        ];
        let all: Vec<Item> = sets.concat();
        for items in sets.iter().chain([&all]) {
            let built = build(items, NONE_LOOSE);
            built.validate(items).unwrap();
            assert!(built.stack <= STACK_SIZE as usize, "{}", built.stack);
        }
    }

    #[test]
    fn validate_catches_defects() {
        let items = boxes(300, 100, 1.0);
        let good = build(&items, NONE_LOOSE);
        let mut shrunk = good.clone();
        shrunk.nodes[0].hi_0[1] = shrunk.nodes[0].lo_0[1];
        assert!(shrunk.validate(&items).unwrap_err().contains("sticks out"));
        let mut lost = good.clone();
        lost.order[7] = lost.order[8];
        assert!(lost.validate(&items).is_err());
        let mut deep = good;
        deep.depth = 2;
        assert!(deep.validate(&items).unwrap_err().contains("deeper"));
    }
}

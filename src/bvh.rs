//! A bounding-volume hierarchy: a binary one by the binned surface-area heuristic (Wald, "On fast
//! Construction of SAH-based Bounding Volume Hierarchies", 2007), made into one of four children a node,
//! that never needs more than the kernels' stack.

use crate::abi::double::Node;
use crate::abi::{LEAF_BIT, LEAF_FIRST_BITS, LEAF_MAX, STACK_SIZE};
use crate::frame::Bounds;
use glam::DVec3;

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

const BINS: usize = 16;
/// Primitives per leaf at which splitting stops even if it pays: a leaf is one run of loads.
const LEAF_TARGET: usize = 2;

/// Boxes grow by this on every side: Woop's own enlargement is at most 20u in a frame of radius 1,
/// 32u = 2^-19 covers it (numerics.md, Boxes).
pub const PADDING: f64 = 1.0 / 524_288.0;

struct Builder<'a> {
    items: &'a [Item],
    pairs: Vec<Pair>,
    triangles: Vec<u32>,
    spheres: Vec<u32>,
    triangle_total: u32,
}

/// Builds over `items` (triangles and spheres in any order). `loose`: triangles, spheres stay outside, in
/// their own order.
pub fn build(items: &[Item], loose: [bool; 2]) -> Bvh {
    let is_loose = |i: &u32| loose[usize::from(items[*i as usize].is_sphere)];
    let (out, mut indices): (Vec<u32>, Vec<u32>) = (0..items.len() as u32).partition(is_loose);
    let (spheres, triangles) = out.into_iter().partition(|i| items[*i as usize].is_sphere);
    let triangle_total = items.iter().filter(|i| !i.is_sphere).count() as u32;
    let mut builder = Builder { items, pairs: Vec::new(), triangles, spheres, triangle_total };
    builder.pairs.push([ABSENT; 2]);
    let (left, right) = match indices.len() {
        0 => (ABSENT, ABSENT),
        _ if builder.leaf_fits(&indices) => (builder.leaf(&indices), ABSENT),
        _ => builder.split(&mut indices, 1),
    };
    builder.pairs[0] = [left, right];
    // A level of the binary hierarchy leaves one entry on the stack, so that two wide always fits.
    let fits = |width| Some(widened(&builder.pairs, width)).filter(|b| b.stack <= STACK_SIZE as usize);
    let wide = fits(WIDTH).unwrap_or_else(|| widened(&builder.pairs, 2));
    let mut order = builder.triangles;
    order.extend(builder.spheres);
    Bvh { order, ..wide }
}

type Child = (u32, Bounds);

/// A node of the binary hierarchy that is built first.
type Pair = [Child; 2];

/// Children of a node at most.
const WIDTH: usize = 4;

/// An absent child: an inverted box, which no ray enters.
const ABSENT: Child =
    (LEAF_BIT, Bounds { lo: DVec3::splat(f32::MAX as f64), hi: DVec3::splat(f32::MIN as f64) });

fn node(children: &[Child]) -> Node {
    let child = |k: usize| children.get(k).copied().unwrap_or(ABSENT);
    let (lo, hi) = (|k: usize| child(k).1.lo.to_array(), |k: usize| child(k).1.hi.to_array());
    Node {
        lo_0: lo(0),
        hi_0: hi(0),
        lo_1: lo(1),
        hi_1: hi(1),
        lo_2: lo(2),
        hi_2: hi(2),
        lo_3: lo(3),
        hi_3: hi(3),
        child_0: child(0).0,
        child_1: child(1).0,
        child_2: child(2).0,
        child_3: child(3).0,
    }
}

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
}

/// Nodes of up to `width` children from the binary ones: a node takes the children of its child with the
/// largest surface until it is full (Wald, Benthin, Boulos, "Getting Rid of Packets", 2008). Root first.
fn widened(pairs: &[Pair], width: usize) -> Bvh {
    let mut bvh = Bvh { nodes: vec![Node::default()], order: Vec::new(), depth: 0, stack: 0 };
    // Pair, node, level, entries of the stack above it.
    let mut work = vec![(0usize, 0usize, 1usize, 0usize)];
    while let Some((pair, at, level, above)) = work.pop() {
        let mut children: Vec<Child> = pairs[pair].to_vec();
        while children.len() < width {
            let inner = children.iter().enumerate().filter(|(_, c)| c.0 & LEAF_BIT == 0);
            let largest = inner.max_by(|a, b| half_area(&a.1.1).total_cmp(&half_area(&b.1.1)));
            let Some((i, (link, _))) = largest.map(|(i, c)| (i, *c)) else { break };
            children.splice(i..=i, pairs[link as usize]);
        }
        let stack = above + children.len() - 1;
        bvh.depth = bvh.depth.max(level);
        bvh.stack = bvh.stack.max(stack);
        for child in &mut children {
            if child.0 & LEAF_BIT == 0 {
                let new = bvh.nodes.len();
                bvh.nodes.push(Node::default());
                work.push((child.0 as usize, new, level + 1, stack));
                child.0 = new as u32;
            }
        }
        bvh.nodes[at] = node(&children);
    }
    bvh
}

impl Builder<'_> {
    /// True if `indices` make one leaf: few, and of one kind.
    fn leaf_fits(&self, indices: &[u32]) -> bool {
        let first = self.items[indices[0] as usize].is_sphere;
        indices.len() <= LEAF_TARGET && indices.iter().all(|i| self.items[*i as usize].is_sphere == first)
    }

    fn bounds(&self, indices: &[u32]) -> Bounds {
        indices.iter().fold(Bounds::EMPTY, |b, i| b.union(self.items[*i as usize].bounds))
    }

    fn leaf(&mut self, indices: &[u32]) -> Child {
        let bounds = self.bounds(indices);
        let spheres = self.items[indices[0] as usize].is_sphere;
        let (list, base) =
            if spheres { (&mut self.spheres, self.triangle_total) } else { (&mut self.triangles, 0) };
        let first = base + list.len() as u32;
        list.extend_from_slice(indices);
        (LEAF_BIT | (indices.len() as u32 - 1) << LEAF_FIRST_BITS | first, bounds)
    }

    /// A subtree over `indices`, whose parent is at level `level - 1`.
    fn subtree(&mut self, indices: &mut [u32], level: usize) -> Child {
        if self.leaf_fits(indices) {
            return self.leaf(indices);
        }
        let at = self.pairs.len();
        self.pairs.push([ABSENT; 2]);
        let bounds = self.bounds(indices);
        let (left, right) = self.split(indices, level);
        self.pairs[at] = [left, right];
        (at as u32, bounds)
    }

    fn split(&mut self, indices: &mut [u32], level: usize) -> (Child, Child) {
        let middle = self.partition(indices, level);
        let (left, right) = indices.split_at_mut(middle);
        let a = self.subtree(left, level + 1);
        let b = self.subtree(right, level + 1);
        (a, b)
    }

    /// Reorders `indices` and says where to cut: the best binned SAH plane if both sides can still
    /// be finished by halving within the stack, else the median.
    fn partition(&self, indices: &mut [u32], level: usize) -> usize {
        let n = indices.len();
        let center = |i: u32| {
            let b = self.items[i as usize].bounds;
            b.lo * 0.5 + b.hi * 0.5
        };
        let centers = indices.iter().fold(Bounds::EMPTY, |b, i| b.with(center(*i)));
        let extent = centers.hi - centers.lo;
        // Levels that halving still needs: to single items, and one to part kinds.
        let needs = |n: usize| n.next_power_of_two().trailing_zeros() as usize + 1;
        if let Some((axis, cut)) = self.best_plane(indices, &centers) {
            let scale = BINS as f64 / extent[axis];
            let bin = |i: u32| (((center(i)[axis] - centers.lo[axis]) * scale) as usize).min(BINS - 1);
            let middle = partition_by(indices, |i| bin(i) < cut);
            let larger = middle.max(n - middle);
            if middle > 0 && middle < n && level + needs(larger) < STACK_SIZE as usize {
                return middle;
            }
        }
        let mixed = indices.iter().any(|i| self.items[*i as usize].is_sphere)
            && indices.iter().any(|i| !self.items[*i as usize].is_sphere);
        if mixed && n <= LEAF_MAX as usize {
            return partition_by(indices, |i| !self.items[i as usize].is_sphere);
        }
        let axis = (0..3).max_by(|a, b| extent[*a].total_cmp(&extent[*b])).unwrap_or(0);
        indices.select_nth_unstable_by(n / 2, |a, b| {
            center(*a)[axis].total_cmp(&center(*b)[axis]).then(a.cmp(b))
        });
        n / 2
    }

    /// Axis and first bin of the right side with the least SAH cost.
    fn best_plane(&self, indices: &[u32], centers: &Bounds) -> Option<(usize, usize)> {
        let mut best: Option<(f64, usize, usize)> = None;
        for axis in 0..3 {
            let extent = centers.hi[axis] - centers.lo[axis];
            // Not positive: all centres coincide on this axis; an overflowing scale splits nothing.
            let scale = BINS as f64 / extent;
            if !(extent > 0.0 && scale.is_finite()) {
                continue;
            }
            let mut bins = [(0usize, Bounds::EMPTY); BINS];
            for i in indices {
                let b = self.items[*i as usize].bounds;
                let c = b.lo[axis] * 0.5 + b.hi[axis] * 0.5;
                let slot = &mut bins[(((c - centers.lo[axis]) * scale) as usize).min(BINS - 1)];
                *slot = (slot.0 + 1, slot.1.union(b));
            }
            let mut right_cost = [0.0; BINS];
            let (mut count, mut bounds) = (0, Bounds::EMPTY);
            for cut in (1..BINS).rev() {
                count += bins[cut].0;
                bounds = bounds.union(bins[cut].1);
                right_cost[cut] = half_area(&bounds) * count as f64;
            }
            let (mut count, mut bounds) = (0, Bounds::EMPTY);
            for cut in 1..BINS {
                count += bins[cut - 1].0;
                bounds = bounds.union(bins[cut - 1].1);
                let cost = half_area(&bounds) * count as f64 + right_cost[cut];
                if count > 0 && count < indices.len() && best.is_none_or(|b| cost < b.0) {
                    best = Some((cost, axis, cut));
                }
            }
        }
        best.map(|(_, axis, cut)| (axis, cut))
    }
}

fn half_area(b: &Bounds) -> f64 {
    if b.is_empty() {
        return 0.0;
    }
    let e = b.hi - b.lo;
    e.x * e.y + e.y * e.z + e.z * e.x
}

/// Stable enough for determinism: a two-pointer partition whose result depends on the input alone.
fn partition_by(indices: &mut [u32], left: impl Fn(u32) -> bool) -> usize {
    let mut at = 0;
    for i in 0..indices.len() {
        if left(indices[i]) {
            indices.swap(at, i);
            at += 1;
        }
    }
    at
}

impl Bvh {
    /// Checks the structure: every item in exactly one leaf, leaves of one kind, every box around
    /// its items, levels within the stack.
    pub fn validate(&self, items: &[Item]) -> Result<(), String> {
        if self.stack > STACK_SIZE as usize {
            return Err(format!("{} entries pass the stack of {STACK_SIZE}", self.stack));
        }
        let mut seen = vec![false; items.len()];
        let mut work = vec![(0u32, 1usize)];
        while let Some((at, level)) = work.pop() {
            if level > self.depth {
                return Err(format!("node {at} lies at level {level}, deeper than {}", self.depth));
            }
            let n = self.nodes.get(at as usize).ok_or(format!("node {at} does not exist"))?;
            for (child, lo, hi) in n.children() {
                for item in self.items_below(child)? {
                    let b = items[item as usize].bounds;
                    if (0..3).any(|a| b.lo[a] < lo[a] || b.hi[a] > hi[a]) {
                        return Err(format!("item {item} sticks out of its box below node {at}"));
                    }
                }
                if child & LEAF_BIT == 0 {
                    work.push((child, level + 1));
                    continue;
                }
                let mut kinds = [false; 2];
                for item in self.items_below(child)? {
                    kinds[usize::from(items[item as usize].is_sphere)] = true;
                    if std::mem::replace(&mut seen[item as usize], true) {
                        return Err(format!("item {item} is in two leaves"));
                    }
                }
                if kinds == [true; 2] {
                    return Err(format!("a leaf below node {at} mixes kinds"));
                }
            }
        }
        match seen.iter().position(|s| !s) {
            Some(item) => Err(format!("item {item} is in no leaf")),
            None => Ok(()),
        }
    }

    fn items_below(&self, child: u32) -> Result<Vec<u32>, String> {
        let (mut found, mut work) = (Vec::new(), vec![child]);
        while let Some(c) = work.pop() {
            if c & LEAF_BIT != 0 {
                let first = (c & ((1 << LEAF_FIRST_BITS) - 1)) as usize;
                let count = ((c & !LEAF_BIT) >> LEAF_FIRST_BITS) as usize + 1;
                let run = self.order.get(first..first + count).ok_or("a leaf reaches past the items")?;
                found.extend_from_slice(run);
            } else {
                let n = self.nodes.get(c as usize).ok_or(format!("node {c} does not exist"))?;
                work.extend(n.children().map(|(child, ..)| child));
            }
        }
        Ok(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::pcg4d;

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

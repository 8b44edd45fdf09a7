//! Twin of `glsl/lib/traverse/count_tests.glsl`. What is tested depends on the order of a traversal, and in a packet on
//! all its rays: unlike `traverse.rs`, this follows the kernels node by node, the rays of a subgroup together.

use super::super::real::{Real, Real3, float, is_not_finite, real};
use super::super::structs::{Hit, Node, Path, Push};
use super::r#box::{SLAB_GROW, enter_box};
use super::traverse::{Shapes, TraversalRay};
use crate::kernel::abi::single::CompressedChild;
use crate::kernel::abi::{COUNTERS, LEAF_BIT, LEAF_FIRST_BITS, NONE, RAY_KINDS, STACK_SIZE, TEST_WORDS};

const FAR: Real = super::super::real::FAR;
/// No node and no leaf.
const DONE: u32 = u32::MAX;
/// Key of a child that no ray meets.
const UNMET: i32 = 0x7fff_fff8;

/// A traversal that a kernel makes: ray, limit, and whether any hit will do. A limit of 0 stands for a lane without a
/// ray.
#[derive(Debug, Clone, Copy)]
pub struct Query {
    /// Ray.
    pub ray: TraversalRay,
    /// Greatest t.
    pub limit: Real,
    /// True for shadow rays.
    pub any: bool,
    /// Sample.
    pub sample_index: u32,
    /// `RAY_…`.
    pub kind: u32,
}

/// A query in progress.
struct Running<'a> {
    query: &'a Query,
    best: Hit,
    /// It looks for a hit.
    looks: bool,
    /// Boxes, primitives.
    tests: [u32; 2],
}

impl Running<'_> {
    fn of(query: &Query) -> Running<'_> {
        let finite = !(is_not_finite(query.ray.origin) || is_not_finite(query.ray.direction));
        let looks = finite && query.limit > 0.0;
        let best = Hit { t: if finite { query.limit } else { 0.0 }, u: 0.0, v: 0.0, primitive: NONE };
        Running { query, best, looks, tests: [0; 2] }
    }

    /// Tests one primitive, if it looks.
    fn test(&mut self, shapes: &Shapes<'_>, primitive: u32) {
        if !self.looks {
            return;
        }
        self.tests[1] += 1;
        if primitive < shapes.spec.triangle_count {
            shapes.test_triangle(primitive, &self.query.ray, &mut self.best);
        } else {
            shapes.test_sphere(primitive, &self.query.ray, &mut self.best);
        }
        self.looks = !(self.query.any && self.best.primitive != NONE);
    }
}

/// First primitive of a leaf, and how many it has.
fn leaf(link: u32) -> (u32, u32) {
    (link & ((1 << LEAF_FIRST_BITS) - 1), ((link & !LEAF_BIT) >> LEAF_FIRST_BITS) + 1)
}

impl Shapes<'_> {
    /// Box and primitive tests of the queries of one subgroup, or of one ray where each is on its own.
    fn tests(&self, group: &[Query]) -> Vec<[u32; 2]> {
        let mut rays: Vec<Running<'_>> = group.iter().map(Running::of).collect();
        if self.spec.use_bvh == 0 {
            let all = self.spec.triangle_count + self.spec.sphere_count;
            rays.iter_mut().filter(|r| r.looks).for_each(|r| r.tests[1] = all);
        } else if self.spec.lanes == 0 {
            rays.iter_mut().filter(|r| r.looks).for_each(|r| self.alone(r));
        } else {
            self.together(&mut rays);
        }
        rays.iter().map(|r| r.tests).collect()
    }

    /// Primitives outside the hierarchy.
    fn outside(&self) -> Vec<u32> {
        let (triangles, spheres) = (self.spec.triangle_count, self.spec.sphere_count);
        let of_triangles = if self.spec.triangles_outside != 0 { 0..triangles } else { 0..0 };
        let of_spheres = if self.spec.spheres_outside != 0 { triangles..triangles + spheres } else { 0..0 };
        of_triangles.chain(of_spheres).collect()
    }

    /// As `hierarchy.glsl`.
    fn alone(&self, r: &mut Running<'_>) {
        // All filters are run.
        r.tests[1] += self.outside().len() as u32;
        self.test_outside(&r.query.ray, &mut r.best);
        r.looks = !(r.query.any && r.best.primitive != NONE);
        let (mut stack, mut current) = (vec![DONE], 0);
        while r.looks && current != DONE {
            if current & LEAF_BIT != 0 {
                let (first, count) = leaf(current);
                (first..first + count).for_each(|primitive| r.test(self, primitive));
                current = stack.pop().unwrap_or(DONE);
                continue;
            }
            let n = &self.nodes[current as usize];
            r.tests[0] += present(n);
            let mut children = entries(n, &r.query.ray, r.best.t);
            for (a, b) in [(0, 1), (2, 3), (0, 2), (1, 3), (1, 2)] {
                if children[b].0 < children[a].0 {
                    children.swap(a, b);
                }
            }
            let mut entered = children[1..].iter().filter(|c| c.0 < FAR).count();
            if stack.len() + entered > STACK_SIZE as usize + 1 {
                entered = 0;
            }
            stack.extend(children[1..=entered].iter().rev().map(|c| c.1));
            current = if children[0].0 < FAR { children[0].1 } else { stack.pop().unwrap_or(DONE) };
        }
    }

    /// As `packet.glsl`.
    fn together(&self, rays: &mut [Running<'_>]) {
        for primitive in self.outside() {
            rays.iter_mut().for_each(|r| r.test(self, primitive));
        }
        let (mut stack, mut current) = (vec![DONE], 0);
        while current != DONE {
            let children = &self.compressed_nodes[8 * current as usize..][..8];
            let there = children.iter().filter(|c| c.link != NONE).count() as u32;
            rays.iter_mut().filter(|r| r.looks).for_each(|r| r.tests[0] += there);
            let mut keys = keys(children, rays);
            keys.sort_unstable();
            let met: Vec<u32> = keys
                .iter()
                .filter(|key| **key < UNMET)
                .map(|key| children[(*key & 7) as usize].link)
                .collect();
            let farther = met.get(1..).unwrap_or_default();
            if stack.len() + farther.len() <= self.spec.stack_size as usize + 1 {
                stack.extend(farther.iter().rev());
            }
            current = met.first().copied().unwrap_or_else(|| stack.pop().unwrap_or(DONE));
            while current & LEAF_BIT != 0 && current != DONE {
                let (first, count) = leaf(current);
                for primitive in first..first + count {
                    rays.iter_mut().for_each(|r| r.test(self, primitive));
                }
                current = stack.pop().unwrap_or(DONE);
                // Shadow rays end once none of them looks.
                if rays.iter().any(|r| r.query.any) && !rays.iter().any(|r| r.looks) {
                    current = DONE;
                }
            }
        }
    }
}

/// Children of a node that are there.
fn present(n: &Node) -> u32 {
    let boxes = [(n.lo_0, n.hi_0), (n.lo_1, n.hi_1), (n.lo_2, n.hi_2), (n.lo_3, n.hi_3)];
    boxes.iter().filter(|(lo, hi)| lo[0] <= hi[0]).count() as u32
}

/// Where a ray enters the children of a node, FAR if it misses them, and their links.
fn entries(n: &Node, r: &TraversalRay, limit: Real) -> [(Real, u32); 4] {
    [
        (n.lo_0, n.hi_0, n.child_0),
        (n.lo_1, n.hi_1, n.child_1),
        (n.lo_2, n.hi_2, n.child_2),
        (n.lo_3, n.hi_3, n.child_3),
    ]
    .map(|(lo, hi, child)| {
        let t = enter_box(lo.into(), hi.into(), r.origin, r.inverse, limit);
        (if t >= 0.0 { t } else { FAR }, child)
    })
}

/// Keys to sort the children of a node by: distance of ray 0 if any ray meets the child, with the child's number.
fn keys(children: &[CompressedChild], rays: &[Running<'_>]) -> Vec<i32> {
    let grid = |k: usize| real(f32::from_bits(children[k].grid));
    let origin = Real3::new(grid(0), grid(1), grid(2));
    let pace = Real3::new(grid(3), grid(4), grid(5));
    let corner = |steps: u32| {
        let axis = |shift: u32| real((steps >> shift & 1023) as f32);
        origin + Real3::new(axis(0), axis(10), axis(20)) * pace
    };
    let key = |(number, child): (usize, &CompressedChild)| {
        let (lo, hi) = (corner(child.lo), corner(child.hi));
        let (mut met, mut first) = (false, 0.0);
        for (i, r) in rays.iter().enumerate() {
            let limit = if r.looks { r.best.t } else { -1.0 };
            let (by_ray, near) = meets(lo, hi, &r.query.ray, limit * SLAB_GROW);
            met |= by_ray;
            first = if i == 0 { near } else { first };
        }
        let met = met && child.link != NONE;
        (if met { float(first).to_bits() as i32 & UNMET } else { UNMET }) | number as i32
    };
    children.iter().enumerate().map(key).collect()
}

fn lesser(a: Real, b: Real) -> Real {
    if a < b { a } else { b }
}

fn greater(a: Real, b: Real) -> Real {
    if a > b { a } else { b }
}

fn meets(lo: Real3, hi: Real3, r: &TraversalRay, limit: Real) -> (bool, Real) {
    let (o, inv) = (r.origin, r.inverse);
    let (x0, x1) = ((lo.x - o.x) * inv.x, (hi.x - o.x) * inv.x);
    let (y0, y1) = ((lo.y - o.y) * inv.y, (hi.y - o.y) * inv.y);
    let (z0, z1) = ((lo.z - o.z) * inv.z, (hi.z - o.z) * inv.z);
    let near = greater(greater(lesser(x0, x1), lesser(y0, y1)), greater(lesser(z0, z1), 0.0));
    let far = lesser(lesser(greater(x0, x1), greater(y0, y1)), greater(z0, z1)) * SLAB_GROW;
    (near <= lesser(far, limit), near)
}

/// Adds to a number of two words, low word first.
fn add_count(words: &mut [u32], n: u32) {
    let (low, carry) = words[0].overflowing_add(n);
    words[0] = low;
    words[1] += u32::from(carry);
}

/// Adds the tests of `queries`, `rounds` of each ray in the order of the queue, to those of this depth and their kinds,
/// and of their samples in a survey.
pub fn note_tests(
    shapes: &Shapes<'_>,
    push: &Push,
    queries: &[Query],
    rounds: usize,
    paths: &mut [Path],
    counters: &mut [u32],
) {
    let lanes = shapes.spec.lanes.max(1) as usize;
    for group in queries.chunks(lanes * rounds.max(1)) {
        for round in 0..rounds {
            let queries: Vec<Query> = group.iter().skip(round).step_by(rounds).copied().collect();
            for (query, tests) in queries.iter().zip(shapes.tests(&queries)) {
                let at = COUNTERS + TEST_WORDS * (RAY_KINDS * (push.depth - 1) + query.kind);
                let words = &mut counters[at as usize..];
                add_count(words, tests[0]);
                add_count(&mut words[2..], tests[1]);
                if shapes.spec.survey != 0 {
                    let rays = &mut paths[query.sample_index as usize].rays;
                    *rays = rays.wrapping_add(tests[0] + tests[1]);
                }
            }
        }
    }
}

//! Ear clipping: cuts off corners whose triangle is inside the border, until a triangle is left.

use super::box_tree::{BoxTree, Rectangle};
use super::{NEARLY_FLAT, Point, is_sliver, squared};
use robust::orient2d;
use std::collections::VecDeque;

/// What may be cut off, from the best to the least.
#[derive(Clone, Copy, PartialEq)]
enum Choice {
    /// An ear that is no sliver, with no other corner near its open side.
    Good,
    /// Any ear that no other corner touches.
    Strict,
    /// An ear with other corners on its sides at most: the border touches itself there.
    Touching,
}

/// The border as a ring of the corners that are left.
struct Ring<'a> {
    border: &'a [Point],
    before: Vec<u32>,
    after: Vec<u32>,
    alive: Vec<bool>,
    count: usize,
    tree: BoxTree,
    triangles: Vec<[u32; 3]>,
}

/// The triangles of a border that is counter-clockwise and does not cross itself; or a corner where nothing can be cut.
pub(super) fn clip(border: &[Point]) -> Result<Vec<[u32; 3]>, usize> {
    let mut ring = Ring::new(border);
    let mut queue = VecDeque::new();
    ring.remove_spikes(ring.corners(), &mut queue);
    queue = ring.corners().into();
    loop {
        ring.clip_queued(&mut queue);
        if ring.count <= 3 {
            break;
        }
        // No good ear is next to what was cut last. Look everywhere, and then for less good ones.
        let corners = ring.corners();
        let before = ring.count;
        for choice in [Choice::Good, Choice::Strict, Choice::Touching] {
            for &corner in &corners {
                if ring.count > 3 && ring.alive[corner] && ring.is_ear(corner, choice) {
                    ring.clip(corner, &mut queue);
                }
            }
            if ring.count < before {
                break;
            }
        }
        if ring.count == before {
            return Err(corners[0]);
        }
    }
    ring.finish()
}

impl Ring<'_> {
    fn new(border: &[Point]) -> Ring<'_> {
        let n = border.len();
        Ring {
            border,
            before: (0..n as u32).map(|i| if i == 0 { n as u32 - 1 } else { i - 1 }).collect(),
            after: (0..n as u32).map(|i| if i as usize == n - 1 { 0 } else { i + 1 }).collect(),
            alive: vec![true; n],
            count: n,
            tree: BoxTree::new(n, |i| [border[i].x, border[i].y, border[i].x, border[i].y]),
            triangles: Vec::with_capacity(n - 2),
        }
    }

    /// The corners that are left, in order.
    fn corners(&self) -> Vec<usize> {
        (0..self.alive.len()).filter(|i| self.alive[*i]).collect()
    }

    fn neighbours(&self, corner: usize) -> [usize; 2] {
        [self.before[corner] as usize, self.after[corner] as usize]
    }

    fn take_out(&mut self, corner: usize) {
        let [u, w] = self.neighbours(corner);
        self.after[u] = w as u32;
        self.before[w] = u as u32;
        self.alive[corner] = false;
        self.tree.remove(corner);
        self.count -= 1;
    }

    /// Cuts off good ears until none is left among those queued and their new neighbours.
    fn clip_queued(&mut self, queue: &mut VecDeque<usize>) {
        while let Some(corner) = queue.pop_front() {
            if self.count > 3 && self.alive[corner] && self.is_ear(corner, Choice::Good) {
                self.clip(corner, queue);
            }
        }
    }

    /// Cuts off an ear, and spikes that are left beside it. Queues the corners whose neighbours are new.
    fn clip(&mut self, corner: usize, queue: &mut VecDeque<usize>) {
        let [u, w] = self.neighbours(corner);
        self.triangles.push(self.turned([u, corner, w]));
        self.take_out(corner);
        queue.extend([u, w]);
        self.remove_spikes(vec![u, w], queue);
    }

    /// Takes out those of `corners` where the border turns back along itself, and what turns back then.
    fn remove_spikes(&mut self, mut corners: Vec<usize>, queue: &mut VecDeque<usize>) {
        while let Some(corner) = corners.pop() {
            if self.count > 3 && self.alive[corner] && self.is_spike(corner) {
                let [u, w] = self.neighbours(corner);
                self.take_out(corner);
                queue.extend([u, w]);
                corners.extend([u, w]);
            }
        }
    }

    /// True if the sides at `corner` lie in one line, on the same side of it; or if it repeats the one before.
    fn is_spike(&self, corner: usize) -> bool {
        let [u, w] = self.neighbours(corner).map(|i| self.border[i]);
        let v = self.border[corner];
        u == v || (orient2d(u, v, w) == 0.0 && (u.x - v.x) * (w.x - v.x) + (u.y - v.y) * (w.y - v.y) > 0.0)
    }

    /// The corners so that the side from the second to the third is one of the border, if any is.
    fn turned(&self, [a, b, c]: [usize; 3]) -> [u32; 3] {
        let n = self.border.len();
        let of_border = |a: usize, b: usize| (a + 1) % n == b;
        let turned = match (of_border(b, c), of_border(a, b), of_border(c, a)) {
            (true, ..) => [a, b, c],
            (_, true, _) => [c, a, b],
            (_, _, true) => [b, c, a],
            _ => [a, b, c],
        };
        turned.map(|i| i as u32)
    }

    /// True if `corner` may be cut off by that `choice`.
    fn is_ear(&self, corner: usize, choice: Choice) -> bool {
        let [iu, iw] = self.neighbours(corner);
        let [u, v, w] = [iu, corner, iw].map(|i| self.border[i]);
        let area = orient2d(u, v, w);
        if area <= 0.0 || (choice == Choice::Good && is_sliver(area, u, v, w)) {
            return false;
        }
        // How far behind the open side, in double area, no corner may be.
        let open = squared(u, w);
        let margin = if choice == Choice::Good { NEARLY_FLAT * open } else { 0.0 };
        let wide = if choice == Choice::Good { NEARLY_FLAT * open.sqrt() } else { 0.0 };
        let bounds: Rectangle = [
            u.x.min(v.x).min(w.x) - wide,
            u.y.min(v.y).min(w.y) - wide,
            u.x.max(v.x).max(w.x) + wide,
            u.y.max(v.y).max(w.y) + wide,
        ];
        let blocks = |i: usize| {
            let z = self.border[i];
            if [iu, corner, iw].contains(&i) || z == u || z == w {
                return false;
            }
            if z == v {
                // Another part of the border passes through the corner: it must not go on inside the ear.
                let inside = |p: Point| orient2d(u, v, p) > 0.0 && orient2d(v, w, p) > 0.0;
                return self.neighbours(i).into_iter().any(|k| inside(self.border[k]));
            }
            let (along_u, along_w, across) = (orient2d(u, v, z), orient2d(v, w, z), orient2d(w, u, z));
            match choice {
                Choice::Touching => along_u > 0.0 && along_w > 0.0 && across >= 0.0,
                _ => along_u >= 0.0 && along_w >= 0.0 && across >= -margin,
            }
        };
        self.tree.find(&bounds, 0, blocks).is_none()
    }

    /// The last triangle and all those before.
    fn finish(mut self) -> Result<Vec<[u32; 3]>, usize> {
        if let [a, b, c] = self.corners()[..] {
            let area = orient2d(self.border[a], self.border[b], self.border[c]);
            if area < 0.0 {
                return Err(a);
            }
            if area > 0.0 {
                self.triangles.push(self.turned([a, b, c]));
            }
        }
        Ok(self.triangles)
    }
}

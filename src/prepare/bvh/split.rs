//! Where to cut: the plane of least cost by the surface-area heuristic among those between bins of
//! centres (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007).

use super::pairs::{Box3, Prim};
use glam::Vec3A;
use rayon::prelude::*;

/// Primitives from which on several threads fill the bins; also how many each takes at a time.
const TOGETHER: usize = 1 << 16;

/// A cut: on `axis`, primitives of bins below `bin` go left.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plane {
    axis: usize,
    bin: usize,
    grid: Grid,
}

/// Bins over the centres' box.
#[derive(Debug, Clone, Copy)]
struct Grid {
    origin: Vec3A,
    /// Bins to the unit; 0 on an axis that cannot be cut.
    scale: Vec3A,
    last: i32,
}

impl Grid {
    fn bins(&self, p: &Prim) -> [usize; 3] {
        let at = (p.bounds().center() - self.origin) * self.scale;
        at.to_array().map(|x| (x as i32).clamp(0, self.last) as usize)
    }
}

impl Plane {
    pub fn is_left(&self, p: &Prim) -> bool {
        self.grid.bins(p)[self.axis] < self.bin
    }
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: Box3,
    count: usize,
}

type Bins<const N: usize> = [[Bin; N]; 3];

const NONE: Bin = Bin { bounds: Box3::EMPTY, count: 0 };

fn fill<const N: usize>(prims: &[Prim], grid: &Grid, bins: &mut Bins<N>) {
    for p in prims {
        let b = p.bounds();
        for (axis, bin) in grid.bins(p).into_iter().enumerate() {
            let slot = &mut bins[axis][bin];
            *slot = Bin { bounds: slot.bounds.union(b), count: slot.count + 1 };
        }
    }
}

/// The box of centres; the same whatever the number of threads.
pub(super) fn centers(prims: &[Prim]) -> Box3 {
    let part = |prims: &[Prim]| prims.iter().fold(Box3::EMPTY, |b, p| b.with(p.bounds().center()));
    if prims.len() < 2 * TOGETHER {
        return part(prims);
    }
    let parts: Vec<Box3> = prims.par_chunks(TOGETHER).map(part).collect();
    parts.into_iter().fold(Box3::EMPTY, Box3::union)
}

/// The box of all.
pub(super) fn bounds(prims: &[Prim]) -> Box3 {
    let part = |prims: &[Prim]| prims.iter().fold(Box3::EMPTY, |b, p| b.union(p.bounds()));
    if prims.len() < 2 * TOGETHER {
        return part(prims);
    }
    let parts: Vec<Box3> = prims.par_chunks(TOGETHER).map(part).collect();
    parts.into_iter().fold(Box3::EMPTY, Box3::union)
}

/// The best plane among `N` bins an axis, if any parts the primitives; with the boxes of both sides.
pub(super) fn best_plane<const N: usize>(prims: &[Prim], centers: &Box3) -> Option<(Plane, [Box3; 2])> {
    let extent = centers.hi - centers.lo;
    let scale = Vec3A::splat(N as f32) / extent;
    // Not positive: all centres coincide on this axis; an overflowing scale splits nothing.
    let cut = extent.cmpgt(Vec3A::ZERO) & scale.is_finite_mask();
    if !cut.any() {
        return None;
    }
    let grid = Grid { origin: centers.lo, scale: Vec3A::select(cut, scale, Vec3A::ZERO), last: N as i32 - 1 };
    let mut bins = [[NONE; N]; 3];
    if prims.len() < 2 * TOGETHER {
        fill(prims, &grid, &mut bins);
    } else {
        let parts: Vec<Box<Bins<N>>> = prims
            .par_chunks(TOGETHER)
            .map(|part| {
                let mut bins = Box::new([[NONE; N]; 3]);
                fill(part, &grid, &mut bins);
                bins
            })
            .collect();
        for part in parts {
            for (into, from) in bins.as_flattened_mut().iter_mut().zip(part.as_flattened()) {
                *into = Bin { bounds: into.bounds.union(from.bounds), count: into.count + from.count };
            }
        }
    }
    let all = bins[0].iter().fold(Box3::EMPTY, |b, bin| b.union(bin.bounds));
    // Areas in units of the largest side, so that no product leaves f32.
    let unit = (all.hi - all.lo).max_element().max(f32::MIN_POSITIVE).recip();
    let mut best: Option<(f32, usize, usize)> = None;
    for axis in 0..3 {
        if !cut.test(axis) {
            continue;
        }
        let row = &bins[axis];
        let mut right_cost = [0.0f32; N];
        let mut right = NONE;
        for bin in (1..N).rev() {
            right = right.and(&row[bin]);
            right_cost[bin] = right.cost(unit);
        }
        let mut left = NONE;
        for bin in 1..N {
            left = left.and(&row[bin - 1]);
            let cost = left.cost(unit) + right_cost[bin];
            let parts = left.count > 0 && left.count < prims.len();
            if parts && cost.is_finite() && best.is_none_or(|b| cost < b.0) {
                best = Some((cost, axis, bin));
            }
        }
    }
    let (_, axis, bin) = best?;
    let side = |bins: &[Bin]| bins.iter().fold(Box3::EMPTY, |b, bin| b.union(bin.bounds));
    let row = &bins[axis];
    Some((Plane { axis, bin, grid }, [side(&row[..bin]), side(&row[bin..])]))
}

impl Bin {
    fn and(&self, other: &Bin) -> Bin {
        Bin { bounds: self.bounds.union(other.bounds), count: self.count + other.count }
    }

    /// Half the area times the primitives.
    fn cost(&self, unit: f32) -> f32 {
        if self.count == 0 {
            return 0.0;
        }
        let e = (self.bounds.hi - self.bounds.lo) * unit;
        (e.x * e.y + e.y * e.z + e.z * e.x) * self.count as f32
    }
}

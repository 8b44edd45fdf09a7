//! Twin of `glsl/scan.comp`.

use super::structs::{DepthCount, Push, Queue};
use crate::abi::{COUNTER_QUEUE_OVERFLOW, GROUPS_PER_ROW, Specialisation};

/// Exclusive prefix sum of the workgroups' children, and the size of the next queue.
pub fn scan(
    spec: &Specialisation,
    push: &Push,
    queue: &[Queue],
    totals: &[u32],
    offsets: &mut [u32],
    next_queue: &mut [Queue],
    depth_counts: &mut [DepthCount],
    counters: &mut [u32],
) {
    let groups = queue[0].count.div_ceil(spec.workgroup) as usize;
    let (mut l, mut r) = (0, 0);
    for g in 0..groups {
        offsets[g] = l + r;
        l += totals[g] >> 16;
        r += totals[g] & 0xffff;
    }
    let mut count = l + r;
    if count > push.capacity {
        counters[COUNTER_QUEUE_OVERFLOW as usize] = 1;
        (l, r, count) = (0, 0, 0);
    }
    let next = count.div_ceil(spec.workgroup);
    next_queue[0] = Queue {
        groups_x: next.min(GROUPS_PER_ROW),
        groups_y: next.div_ceil(GROUPS_PER_ROW),
        groups_z: 1,
        count,
        reflections: l,
    };
    let counts = &mut depth_counts[push.depth as usize];
    counts.traced += count;
    counts.reflections += l;
    counts.refractions += r;
}

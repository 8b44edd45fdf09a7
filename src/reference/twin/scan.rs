//! Twin of `glsl/scan.comp`.

use super::structs::{DepthCount, Push, Queue};
use crate::kernel::abi::{COUNTER_QUEUE_OVERFLOW, GROUPS_PER_ROW, Specialisation};

/// Exclusive prefix sum of the workgroups' children, and the size of the next queue.
pub fn scan(
    spec: &Specialisation,
    push: &Push,
    queue: &[Queue],
    child_counts: &[u32],
    child_masks: &[u32],
    offsets: &mut [u32],
    next_queue: &mut [Queue],
    depth_counts: &mut [DepthCount],
    counters: &mut [u32],
) {
    let groups = queue[0].count.div_ceil(spec.workgroup) as usize;
    let (mut l, mut r) = (0, 0);
    let masks = if spec.fused == 0 { 0 } else { (spec.workgroup / spec.lanes) as usize };
    let children = |g: usize| match masks {
        0 => (child_counts[g] >> 16, child_counts[g] & 0xffff),
        _ => child_masks[g * masks..(g + 1) * masks]
            .iter()
            .fold((0, 0), |(l, r), mask| (l + (mask & 0xffff).count_ones(), r + (mask >> 16).count_ones())),
    };
    for g in 0..groups {
        offsets[g] = l + r;
        let (reflections, refractions) = children(g);
        l += reflections;
        r += refractions;
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

//! Twin of `glsl/place.comp`.

use super::structs::Queue;
use crate::kernel::abi::Specialisation;

/// Where the rays of the next depth are, in the order of their parents.
pub fn place(
    spec: &Specialisation,
    queue: &[Queue],
    next_queue: &[Queue],
    child_masks: &[u32],
    offsets: &[u32],
    ray_indices: &mut [u32],
) {
    if next_queue[0].count == 0 {
        return;
    }
    let (lanes, most) = (spec.lanes as usize, 1 + u32::from(spec.branching != 0));
    let mut to = 0;
    for i in 0..queue[0].count {
        if i % spec.workgroup == 0 {
            to = offsets[(i / spec.workgroup) as usize] as usize;
        }
        let mask = child_masks[i as usize / lanes] >> (i as usize % lanes) & 0x1_0001;
        for child in 0..mask.count_ones() {
            ray_indices[to] = i * most + child;
            to += 1;
        }
    }
}

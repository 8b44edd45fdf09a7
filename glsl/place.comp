// Where the rays of the next depth are, in the order of their parents, reflection first:
// `fused_depth` left a ray's children at places of its own.
// Reads queue, next_queue, child_masks, offsets. Writes ray_indices.
// One invocation per parent ray.
#version 460
#include "base/prelude.glsl"
#include "base/children.glsl"
layout(local_size_x_id = 0) in;

READS(queue)
READS(next_queue)
READS(child_masks)
READS(offsets)
WRITES(ray_indices)

void main() {
    uint i = item_index(), lane = gl_SubgroupInvocationID, own = gl_LocalInvocationID.x / lanes;
    uint group = min(group_index(), (queue[0].count - 1u) / workgroup);
    uint before = offsets[group], mask = 0u;
    // The lanes load a word each of the workgroup's, and hand it round.
    [[unroll]] for (uint k = 0u; k < MASKS; k += lanes) {
        uint word = child_masks[group * MASKS + min(k + lane, MASKS - 1u)];
        uint count = k + lane < own ? bitCount(word) : 0u;
        [[unroll]] for (uint l = 0u; l < lanes; l++) before += subgroupShuffle(count, l);
        mask = own / lanes == k / lanes ? subgroupShuffle(word, own % lanes) : mask;
    }
    if (i >= queue[0].count || next_queue[0].count == 0u) return;
    uint bits = (REFLECTED_BIT | REFRACTED_BIT) << lane;
    uint to = before + bitCount(mask & (bits - (REFLECTED_BIT | REFRACTED_BIT)));
    uint children = bitCount(mask & bits);
    if (children > 0u) ray_indices[to] = i * CHILDREN_MOST;
    if (children > 1u) ray_indices[to + 1u] = i * CHILDREN_MOST + 1u;
}

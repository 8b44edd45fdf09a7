// Where the rays of the next depth are, in the order of their parents, reflection first: `trace` left a ray's children
// at places of its own.
// Reads queue, next_queue, totals, offsets. Writes places.
// One invocation per parent ray.
#version 460
#include "prelude.glsl"
#include "children.glsl"
layout(local_size_x_id = 0) in;

READS(queue)
READS(next_queue)
READS(totals)
READS(offsets)
WRITES(places)

void main() {
    uint i = item_index();
    uint group = min(group_index(), (queue[0].count - 1u) / workgroup);
    uint first = group * MASKS, own = gl_LocalInvocationID.x / lanes, lane = gl_LocalInvocationID.x % lanes;
    uint before = offsets[group], mask = 0u;
    // All at addresses that all invocations share.
    [[unroll]] for (uint k = 0u; k < MASKS; k++) {
        uint other = totals[first + k];
        before += k < own ? bitCount(other) : 0u;
        mask = k == own ? other : mask;
    }
    if (i >= queue[0].count || next_queue[0].count == 0u) return;
    uint bits = (REFLECTED_BIT | REFRACTED_BIT) << lane;
    uint to = before + bitCount(mask & (bits - (REFLECTED_BIT | REFRACTED_BIT)));
    uint children = bitCount(mask & bits);
    if (children > 0u) places[to] = i * CHILDREN_MOST;
    if (children > 1u) places[to + 1u] = i * CHILDREN_MOST + 1u;
}

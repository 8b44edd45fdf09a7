// Exclusive prefix sum of the workgroups' children: the next queue keeps the order of this one, so
// nothing depends on which workgroup ran first. Sizes the next depth's dispatches.
// Reads queue, child_counts, child_masks. Writes offsets, next_queue. Counts rays by kind, and a queue too small.
// One workgroup; each invocation walks the counts of a run of workgroups.
#version 460
#include "base/prelude.glsl"
#include "base/children.glsl"
layout(local_size_x = SCAN_WIDTH) in;

READS(queue)
READS(child_counts)
READS(child_masks)
WRITES(offsets)
WRITES(next_queue)
UPDATES(depth_counts)
UPDATES(counters)

shared uint reflections[SCAN_WIDTH];
shared uint refractions[SCAN_WIDTH];

// Reflection and refraction rays of a workgroup's rays.
uvec2 children(uint g) {
    if (fused == 0u) return uvec2(child_counts[g] >> 16, child_counts[g] & 0xffffu);
    uvec2 sum = uvec2(0u);
    [[unroll]] for (uint k = 0u; k < MASKS; k++) {
        uint mask = child_masks[g * MASKS + k];
        sum += uvec2(bitCount(mask & (REFRACTED_BIT - 1u)), bitCount(mask / REFRACTED_BIT));
    }
    return sum;
}

void main() {
    uint local = gl_LocalInvocationID.x;
    uint groups = (queue[0].count + workgroup - 1u) / workgroup;
    uint run = (groups + SCAN_WIDTH - 1u) / SCAN_WIDTH;
    uint begin = min(local * run, groups), end = min(begin + run, groups);
    uint sum_l = 0u, sum_r = 0u;
    for (uint g = begin; g < end; g++) {
        uvec2 sum = children(g);
        sum_l += sum.x;
        sum_r += sum.y;
    }
    reflections[local] = sum_l;
    refractions[local] = sum_r;
    barrier();
    // Hillis and Steele, CACM 29(12), 1986.
    for (uint step_ = 1u; step_ < SCAN_WIDTH; step_ *= 2u) {
        uint l = local >= step_ ? reflections[local - step_] : 0u;
        uint r = local >= step_ ? refractions[local - step_] : 0u;
        barrier();
        reflections[local] += l;
        refractions[local] += r;
        barrier();
    }
    uint at = (reflections[local] - sum_l) + (refractions[local] - sum_r);
    for (uint g = begin; g < end; g++) {
        offsets[g] = at;
        uvec2 sum = children(g);
        at += sum.x + sum.y;
    }
    if (local == SCAN_WIDTH - 1u) {
        uint l = reflections[local], r = refractions[local], count = l + r;
        if (count > push.capacity) {
            counters[COUNTER_QUEUE_OVERFLOW] = 1u;
            l = r = count = 0u;
        }
        uint next = (count + workgroup - 1u) / workgroup;
        next_queue[0] = Queue(min(next, GROUPS_PER_ROW), (next + GROUPS_PER_ROW - 1u) / GROUPS_PER_ROW, 1u, count, l);
        depth_counts[push.depth].traced += count;
        depth_counts[push.depth].reflections += l;
        depth_counts[push.depth].refractions += r;
    }
}

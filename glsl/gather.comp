// Adds the contributions of all rays of one sample at this depth, from 2 on, to the sample, in queue order. The
// queue keeps a sample's rays together, so the first of them adds up all.
// Reads queue, contributions. Updates sample_radiance.
// One invocation per ray; all but the first of a sample leave at once.
#version 460
#include "base/prelude.glsl"
#include "base/numeric.glsl"
layout(local_size_x_id = 0) in;

READS(queue)
READS(contributions)
UPDATES(sample_radiance)
UPDATES(counters)

void main() {
    uint i = item_index();
    uint count = queue[0].count;
    if (i >= count) return;
    uint sample_index = contributions[i].sample_index;
    if (i > 0u && contributions[i - 1u].sample_index == sample_index) return;
    vec3 sum = contributions[i].light, compensation = vec3(0.0);
    uint j = i + 1u;
    for (; j < count && j - i < LOOP_CAP && contributions[j].sample_index == sample_index; j++) {
        neumaier(sum, compensation, contributions[j].light);
    }
    if (j - i == LOOP_CAP) atomicAdd(counters[COUNTER_LOOP_CAP], 1u);
    sample_radiance[sample_index] += sum + compensation;
}

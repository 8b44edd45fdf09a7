// Closest hit of every ray in the queue.
// Reads queue, rays and the scene's shapes. Writes hits. Counts NaN rays, stack and loop overflows.
// One invocation per ray.
#version 460
#include "prelude.glsl"
layout(local_size_x_id = 0) in;

READS(triangles)
READS(triangle_infos)
READS(spheres)
READS(wide_spheres)
READS(sphere_infos)
READS(nodes)
READS(rays)
READS(queue)
WRITES(hits)
UPDATES(counters)
#include "trace.glsl"

void main() {
    // The last group's spare invocations do its last ray again: a return would put all loads under a mask.
    uint i = min(item_index(), queue[0].count - 1u);
    TraceRay r = make_trace_ray(rays[i].origin, rays[i].direction, rays[i].skip);
    hits[i] = closest_hit(r, FAR, false);
}

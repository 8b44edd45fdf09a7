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
    uint item = item_index();
    bool mine = item < queue[0].count;
    // The last group's spare invocations take its last ray, to the limit 0, and write and count nothing:
    // a return would put all loads under a mask.
    uint i = min(item, queue[0].count - 1u);
    TraceRay r = make_trace_ray(rays[i].origin, rays[i].direction, rays[i].skip);
    Hit h = closest_hit(r, mine ? FAR : real(0.0), false);
    if (mine) hits[i] = h;
}

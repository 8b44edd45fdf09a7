// Closest hit of every ray in the queue.
// Reads queue, rays and the scene's shapes. Writes hits. Counts NaN rays, stack and loop overflows; box and primitive tests where
// that is asked for, in a survey also in paths.
// One invocation per ray.
#version 460
#include "base/prelude.glsl"
#include "base/fetch.glsl"
layout(local_size_x_id = 0) in;

FETCHES_4(triangles)
FETCHES_2(spheres)
READS(extended_spheres)
FETCHES_NODES
FETCHES_3(rays)
READS(queue)
STORES_1(hits)
UPDATES(paths)
UPDATES(counters)
#include "traverse/traverse.glsl"

void main() {
    uint item = item_index();
    bool mine = item < queue[0].count;
    // The last group's spare invocations take its last ray, to the limit 0, and write and count nothing:
    // a return would put all loads under a mask.
    uint i = min(item, queue[0].count - 1u);
    Ray ray = load_rays(i);
    TraversalRay r = make_traversal_ray(ray.origin, ray.direction, ray.skip);
    Hit h = closest_hit(r, mine ? FAR : real(0.0), false);
    if (mine) {
        store_hits(i, h);
        note_tests(ray.sample_index, ray.kind);
    }
}

// Reflection and refraction rays of the next depth, in the order of their parents, reflection first.
// Reads queue, rays, media, surfaces, materials, offsets, camera (for a fixed origin shift). Writes next_rays, next_media. Counts rays
// that are in more solids than their list holds.
// One invocation per parent ray. Whitted, CACM 23(6), 1980.
#version 460
#include "base/prelude.glsl"
#include "base/numeric.glsl"
#include "base/fetch.glsl"
layout(local_size_x_id = 0) in;

READS(camera)
READS(materials)
FETCHES_3(rays)
READS(media)
READS(queue)
READS(next_queue)
FETCHES_4(surfaces)
READS(offsets)
STORES_3(next_rays)
WRITES(next_media)
UPDATES(counters)
#include "optics/spawn.glsl"

void main() {
    uint i = item_index();
    if (i >= queue[0].count || next_queue[0].count == 0u) return;
    Surface s = load_surfaces(i);
    if (s.primitive == NONE || (s.flags & (CHILD_REFLECTED | CHILD_REFRACTED)) == 0u) return;
    uint to = offsets[group_index()] + (s.flags >> PREFIX_SHIFT);
    spawn(s, load_rays(i), materials[s.material].secondary, i, to);
}

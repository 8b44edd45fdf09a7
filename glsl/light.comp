// What `shadow` does where `walk` has searched for occluders: own colour of every struck surface.
// Reads queue, rays, surfaces, the answers in hits, and the scene's lights, materials and ids. Writes contributions or
// sample_radiance. Counts shadow rays. A survey notes in paths what `shadow` notes there.
// One invocation per ray and pass; a pass takes the lights [light_begin, light_end).
#version 460
#define ANSWERED
#include "base/prelude.glsl"
#include "base/fetch.glsl"
layout(local_size_x_id = 0) in;

READS(camera)
FETCHES_4(triangles)
FETCHES_2(spheres)
FETCHES_2(materials)
READS(lights)
FETCHES_3(rays)
READS(queue)
READS(hits)
FETCHES_4(surfaces)
UPDATES(contributions)
UPDATES(sample_radiance)
UPDATES(paths)
UPDATES(depth_counts)
UPDATES(counters)
#include "base/sampler.glsl"
#include "base/numeric.glsl"
#include "shape/triangle.glsl"
#include "shape/sphere.glsl"
#include "shape/box.glsl"
#include "traverse/traversal_ray.glsl"
#include "traverse/count_tests.glsl"
#include "optics/light.glsl"

void main() {
    uint item = item_index();
    bool mine = item < queue[0].count;
    // The last group's spare invocations take its last ray, face no light, and write and count nothing.
    uint i = min(item, queue[0].count - 1u);
    Surface s = load_surfaces(i);
    Ray ray = load_rays(i);
    Material m = load_materials(s.primitive != NONE ? s.material : 0u);
    light_up(i, mine, ray, s, m, push.light_begin == 0u, push.light_end == light_count);
}

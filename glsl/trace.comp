// Closest hit, surface and own colour of every ray in the queue: `intersect`, `shade` and `shadow` in one.
// Reads queue, rays, media and the scene. Writes surfaces, totals, contributions or slots.
// One invocation per ray.
#version 460
#include "prelude.glsl"
#include "fetch.glsl"
layout(local_size_x_id = 0) in;

READS(camera)
FETCHES_4(triangles)
FETCHES_1(flat_normals)
READS(corner_normals)
FETCHES_2(spheres)
READS(wide_spheres)
FETCHES_7(nodes)
FETCHES_2(materials)
READS(lights)
READS(solid_iors)
READS(solid_priorities)
FETCHES_3(rays)
READS(media)
READS(queue)
STORES_4(surfaces)
WRITES(totals)
UPDATES(contributions)
UPDATES(slots)
UPDATES(paths)
UPDATES(depth_counts)
UPDATES(counters)
#include "sampler.glsl"
#include "trace.glsl"
#include "strike.glsl"
#include "light.glsl"

shared uint reflected_mask[WORKGROUP_MAX / 32u];
shared uint refracted_mask[WORKGROUP_MAX / 32u];

void main() {
    uint item = item_index();
    bool mine = item < queue[0].count;
    uint i = min(item, queue[0].count - 1u);
    Ray ray = load_rays(i);
    TraceRay r = make_trace_ray(ray.origin, ray.direction, ray.skip);
    Hit h = closest_hit(r, mine ? FAR : real(0.0), false);
    Material m;
    Surface s = strike(i, ray, h, m);
    light_up(i, mine, ray, s, m, true, true);
    uint local = gl_LocalInvocationID.x;
    uint word = local / 32u, bit = 1u << (local % 32u);
    if (local < WORKGROUP_MAX / 32u) {
        reflected_mask[local] = 0u;
        refracted_mask[local] = 0u;
    }
    barrier();
    if (mine) {
        if ((s.flags & CHILD_REFLECTED) != 0u) atomicOr(reflected_mask[word], bit);
        if ((s.flags & CHILD_REFRACTED) != 0u) atomicOr(refracted_mask[word], bit);
    }
    barrier();
    uint before = 0u, reflections = 0u, refractions = 0u;
    for (uint w = 0u; w < (workgroup + 31u) / 32u; w++) {
        uint lower = w < word ? 0xffffffffu : (w == word ? bit - 1u : 0u);
        before += bitCount(reflected_mask[w] & lower) + bitCount(refracted_mask[w] & lower);
        reflections += bitCount(reflected_mask[w]);
        refractions += bitCount(refracted_mask[w]);
    }
    if (mine) {
        s.flags |= before << PREFIX_SHIFT;
        store_surfaces(i, s);
    }
    if (local == 0u && mine) totals[group_index()] = reflections << 16 | refractions;
}

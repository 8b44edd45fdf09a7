// Turns hits into surfaces: position, normal, medium change, share of reflection, and which
// children the ray has. Counts the children of each workgroup, so that `scan` can place them.
// Reads queue, rays, hits, media and the scene. Writes surfaces, child_counts. A survey notes the throughput
// of children that are not traced in paths.
// One invocation per ray. Whitted, CACM 23(6), 1980.
#version 460
#include "base/prelude.glsl"
#include "base/numeric.glsl"
#include "base/fetch.glsl"
layout(local_size_x_id = 0) in;

FETCHES_4(triangles)
FETCHES_1(flat_normals)
READS(corner_normals)
FETCHES_2(spheres)
READS(extended_spheres)
FETCHES_2(materials)
READS(solid_iors)
READS(solid_priorities)
FETCHES_3(rays)
READS(media)
READS(queue)
FETCHES_1(hits)
STORES_4(surfaces)
WRITES(child_counts)
UPDATES(paths)
#include "optics/strike.glsl"

shared uint reflected_mask[WORKGROUP_MAX / 32u];
shared uint refracted_mask[WORKGROUP_MAX / 32u];

void main() {
    uint i = item_index();
    uint local = gl_LocalInvocationID.x;
    uint word = local / 32u, bit = 1u << (local % 32u);
    if (local < WORKGROUP_MAX / 32u) {
        reflected_mask[local] = 0u;
        refracted_mask[local] = 0u;
    }
    barrier();
    Surface s;
    bool live = i < queue[0].count;
    if (live) {
        Hit h = load_hits(i);
        Ray ray;
        if (h.primitive != NONE) ray = load_rays(i);
        Material m;
        s = strike(i, ray, h, m);
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
    if (live) {
        s.flags |= before << PREFIX_SHIFT;
        store_surfaces(i, s);
    }
    // Rows of a folded dispatch may end in groups without rays; they have no total.
    if (local == 0u && live) child_counts[group_index()] = reflections << 16 | refractions;
}

// A part of the walks of some rays: what `intersect` and `shadow` search for, in as many dispatches as it takes. For
// batches in which a walk has taken more steps than one dispatch may take.
// Reads queue, rays, surfaces and the scene. Keeps in walks where a walk is, in hits what it has found: the closest
// hit, or of the shadow rays of a surface a bit for each light of the pass [light_begin, ...) that is hidden.
// Counts NaN rays, stack overflows and walks that have to go on; box and primitive tests where that is asked for, in
// a survey also in paths.
// One invocation per ray of the queue from walk_first on, `items` of them. light_end = 0: closest hits; else shadow
// rays to light number light_end - 1. walk_round = 0: the walks begin.
#version 460
#define IN_PARTS
#include "base/prelude.glsl"
#include "base/fetch.glsl"
layout(local_size_x_id = 0) in;

READS(camera)
FETCHES_4(triangles)
FETCHES_2(spheres)
READS(extended_spheres)
FETCHES_NODES
FETCHES_2(materials)
READS(lights)
FETCHES_3(rays)
READS(queue)
FETCHES_4(surfaces)
UPDATES(hits)
UPDATES(walks)
UPDATES(paths)
UPDATES(counters)
#include "base/sampler.glsl"
#include "traverse/traverse.glsl"
#include "optics/light.glsl"

void main() {
    uint item = push.walk_first + item_index();
    bool mine = item < queue[0].count;
    // Spare invocations take the last ray, to the limit 0, and write no hit.
    uint i = min(item, queue[0].count - 1u);
    Ray ray = load_rays(i);
    bool closest = push.light_end == 0u, begin = push.walk_round == 0u;
    TraversalRay r = make_traversal_ray(ray.origin, ray.direction, ray.skip);
    real limit = FAR;
    uint bit = 0u, hidden = 0u;
    Best best = Best(0.0, 0.0, 0.0, NONE, NONE);
    if (closest) {
        if (!begin) {
            Hit h = hits[i];
            best = Best(h.t, h.u, h.v, h.primitive, id_of(h.primitive));
        }
    } else {
        Surface s = load_surfaces(i);
        Material m = load_materials(s.primitive != NONE ? s.material : 0u);
        uint l = push.light_end - 1u;
        ShadowRay to = shadow_ray(s, may_be_lit(own_share(s, m), m), lights[l]);
        r = to.ray;
        limit = to.limit;
        bit = 1u << (l - push.light_begin);
        hidden = begin && l == push.light_begin ? 0u : hits[i].primitive;
        if (!begin) best = Best(limit, 0.0, 0.0, (hidden & bit) != 0u ? 0u : NONE, 0u);
    }
    limit = mine ? limit : real(0.0);
    search(r, limit, !closest, begin, best);
    if (!mine) return;
    if (closest) {
        hits[i] = Hit(best.t, best.u, best.v, best.primitive);
    } else {
        hits[i].primitive = hidden | (best.primitive != NONE ? bit : 0u);
    }
    note_tests(ray.sample_index, closest ? ray.kind : RAY_SHADOW);
}

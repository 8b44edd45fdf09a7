// Closest hit and occlusion over all primitives. Primitives are numbered triangles first, then
// spheres.
//
// Which traversal is taken, by specialisation constants that the plan sets (src/plan/mod.rs):
// - without a hierarchy brute force (brute_force.glsl): up to UNROLL_MAX primitives behind a
//   filter, more in a plain loop;
// - with a hierarchy first what is outside it, one by one (the kind of which the scene has few),
//   then the nodes: each ray alone (hierarchy.glsl), or in the form `packet` all rays of a subgroup
//   together (packet.glsl).
//
// All of them find the same hits, bit for bit (numerics.md, Boxes).
//
// A walk of the hierarchy takes as long as it takes, a dispatch may not: lavapipe ends every loop of an
// invocation after 65,535 iterations in all, silently. So walks count their steps, and one that has taken
// `loop_cap` of them stops and counts itself as unfinished. Its result is worth nothing then: the host does the
// batch again, with walks that go on from dispatch to dispatch (walk.comp, which defines IN_PARTS).
//
// Needs FETCHES_4(triangles), FETCHES_2(spheres), READS(extended_spheres), FETCHES_NODES, UPDATES(paths),
// UPDATES(counters).
#include "base/numeric.glsl"
#include "shape/triangle.glsl"
#include "shape/sphere.glsl"
#include "shape/box.glsl"
#ifdef LANES
#include "base/lanes.glsl"
#endif
#include "traverse/traversal_ray.glsl"
#include "traverse/best_hit.glsl"
#include "traverse/count_tests.glsl"

// What is tested one by one: everything, or the kind of which there are few.
const uint outside_triangle_count = !by_hierarchy || triangles_outside != 0u ? triangle_count : 0u;
const uint outside_sphere_count = !by_hierarchy || spheres_outside != 0u ? sphere_count : 0u;

// Kinds in the hierarchy: a traversal has no code for one that is not.
const bool triangles_in_hierarchy = triangle_count != 0u && triangles_outside == 0u;
const bool spheres_in_hierarchy = sphere_count != 0u && spheres_outside == 0u;

// No node and no leaf: the end of a traversal.
const uint DONE = 0xffffffffu;

// Iterations of the traversals' loops, of all walks of this invocation together.
uint steps = 0u;

#ifdef IN_PARTS
#include "traverse/parts.glsl"
#endif
#include "traverse/filter.glsl"
#include "traverse/brute_force.glsl"
#ifdef LANES
#include "traverse/packet.glsl"
#else
#include "traverse/hierarchy.glsl"
#endif

// Closest hit with 0 < t < limit, or any where `any`, from what `best` holds; `begin`: it holds nothing yet. A ray
// that is not finite is counted and hits nothing.
void search(TraversalRay r, real limit, bool any, bool begin, inout Best best) {
    bool finite = !(is_not_finite(r.origin) || is_not_finite(r.direction));
    if (begin) {
        if (!finite && limit > 0.0) atomicAdd(counters[COUNTER_NAN_RAYS], 1u);
        // Nothing lies before t = 0, so a limit of 0 finds nothing.
        best = Best(finite ? limit : real(0.0), 0.0, 0.0, NONE, NONE);
    }
    uvec2 before = tests;
    if (!by_hierarchy) {
#ifdef IN_PARTS
        go_on_by_brute_force(r, any, begin, best);
#else
        traverse_brute_force(r, any, best);
#endif
        if (counting != 0u && !(finite && limit > 0.0)) tests = before;
        return;
    }
#ifdef LANES
    if (begin) test_outside(r, finite && limit > 0.0, any, best);
    traverse_packet(r, finite && limit > 0.0 && !(any && best.primitive != NONE), any, best);
#else
    if (begin && outside_triangle_count + outside_sphere_count != 0u) filtered_brute_force(r, any, best);
    if (!(any && best.primitive != NONE)) traverse_hierarchy(r, any, best);
#endif
    if (counting != 0u && !(finite && limit > 0.0)) tests = before;
}

// Closest hit with 0 < t < limit, or any.
Hit closest_hit(TraversalRay r, real limit, bool any) {
    Best best = Best(0.0, 0.0, 0.0, NONE, NONE);
    search(r, limit, any, true, best);
    return Hit(best.t, best.u, best.v, best.primitive);
}

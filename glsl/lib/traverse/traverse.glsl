// Closest hit and occlusion over all primitives. Primitives are numbered triangles first, then
// spheres. Needs FETCHES_4(triangles), FETCHES_2(spheres), READS(extended_spheres), FETCHES_NODES,
// UPDATES(counters).
#include "base/numeric.glsl"
#include "shape/triangle.glsl"
#include "shape/sphere.glsl"
#include "shape/box.glsl"
#ifdef LANES
#include "base/lanes.glsl"
#endif

// Larger than any t in the local frame, yet finite.
const real FAR = 3.0e38;

struct TraversalRay {
    real3 origin;
    real3 direction;
    real3 inverse; // of the direction, bounded
    Shear shear;
    uint skip; // primitive the ray starts on, or NONE
};

TraversalRay make_traversal_ray(real3 origin, real3 direction, uint skip) {
    return TraversalRay(origin, direction, safe_reciprocal(direction), make_shear(direction), skip);
}

// The nearest hit so far, with the primitive's position in the scene's own order: ties go to the smallest,
// whatever the storage order.
struct Best {
    real t, u, v;
    uint primitive;
    uint id;
};

// True if a hit near a triangle's plane is an artefact: t is off by some 40u over the triangle's
// height (slivers), so that a ray which leaves a surface may seem to meet a neighbour in its plane.
// The origin's side of the plane is what the spawn offset keeps clear of doubt. Where rounding could
// have made either sign (4u a component), the hit stands: meshes stay closed.
bool recedes(Triangle t, real3 normal, TraversalRay r, real distance) {
    real3 e1 = t.b - t.a, e2 = t.c - t.a, to = t.a - r.origin;
    real m1 = max_component(e1), m2 = max_component(e2);
    bool is_far = distance * max_component(r.direction) > (m1 > m2 ? m1 : m2);
    real height = dot3(normal, to), along = dot3(normal, r.direction);
    real unsure = (8.0 * U) * max_component(to), parallel = (8.0 * U) * max_component(r.direction);
    return !is_far && ((height < -unsure && along > parallel) || (height > unsure && along < -parallel));
}

// Takes a hit into `best` if it is nearer. It must lie in the primitive's own box, and its t is
// confined to the box's interval: whatever rounding did to t, no node around the primitive is culled
// then, and the hierarchy finds what brute force finds, bit for bit (numerics.md, Boxes).
void take_hit(Best h, bool hit, real3 lo, real3 hi, TraversalRay r, inout Best best) {
    // One condition and no early return: lavapipe would keep the values of each way out.
    if (robust != 0u) {
        real near, far;
        box_interval(lo, hi, r.origin, r.inverse, near, far);
        hit = hit && !(near > far);
        h.t = h.t < near ? near : (h.t > far ? far : h.t);
    }
    // A tie with the limit itself is no hit: `best.primitive` is still NONE then.
    bool wins_tie = h.t == best.t && best.primitive != NONE && h.id < best.id;
    bool take = hit && (h.t < best.t || wins_tie);
    best.t = take ? h.t : best.t;
    best.u = take ? h.u : best.u;
    best.v = take ? h.v : best.v;
    best.primitive = take ? h.primitive : best.primitive;
    best.id = take ? h.id : best.id;
}

// `may`: the ray is to be tested at all.
void try_triangle(Triangle t, uint primitive, bool may, TraversalRay r, inout Best best) {
    Best h;
    h.primitive = primitive;
    h.id = t.id;
    bool hit = hit_triangle(t, r.origin, r.direction, r.shear, h.t, h.u, h.v);
    // Only a ray that leaves a surface starts in doubt about a plane.
    bool false_hit = robust != 0u && r.skip != NONE && recedes(t, geometric_normal(t), r, h.t);
    real3 lo, hi;
    triangle_box(t, lo, hi);
    take_hit(h, may && hit && primitive != r.skip && !false_hit, lo, hi, r, best);
}

void test_triangle(uint primitive, TraversalRay r, inout Best best) {
    try_triangle(load_triangles(primitive), primitive, true, r, best);
}

void try_sphere(Sphere s, uint primitive, bool may, TraversalRay r, inout Best best) {
    Best h = Best(0.0, 0.0, 0.0, primitive, s.id);
    bool hit;
    if (extended_spheres_used != 0u && s.radius < 0.0) {
        s.radius = -s.radius;
        ExtendedSphere w = extended_spheres[s.wide];
        hit = hit_extended_sphere(w, r.origin, r.direction, primitive == r.skip, h.t);
    } else {
        hit = hit_sphere(s, r.origin, r.direction, primitive == r.skip, h.t);
    }
    real3 lo, hi;
    sphere_box(s, lo, hi);
    take_hit(h, may && hit, lo, hi, r, best);
}

void test_sphere(uint primitive, TraversalRay r, inout Best best) {
    try_sphere(load_spheres(primitive - triangle_count), primitive, true, r, best);
}

const bool by_tree = use_bvh != 0u;

// What is tested one by one: everything, or the kind of which there are few.
const uint few_triangles = !by_tree || triangles_outside != 0u ? triangle_count : 0u;
const uint few_spheres = !by_tree || spheres_outside != 0u ? sphere_count : 0u;

uint filter_triangle(uint i, TraversalRay r) {
#ifdef LANES
    Triangle t = gather_triangle(i);
#else
    Triangle t;
    t.a = triangles[i].a;
    t.b = triangles[i].b;
    t.c = triangles[i].c;
#endif
    bool may = i != r.skip && may_hit_triangle(t, r.origin, r.shear);
    return may ? 1u << i : 0u;
}

uint filter_sphere(uint i, TraversalRay r) {
#ifdef LANES
    Sphere s = gather_sphere(i);
#else
    Sphere s = spheres[i];
#endif
    bool may = may_hit_sphere(s, r.origin, r.direction, triangle_count + i == r.skip);
    return may ? 1u << (few_triangles + i) : 0u;
}

// Few primitives: first a filter that is a handful of operations and no branch, written out
// for each of them, then the whole test for what it lets through. Outside all control flow lavapipe
// loads an address that all lanes share once, and it runs both sides of a branch
// (docs/design/decisions/005-brute-force-filter.md); a GPU does not diverge.
void walk_few(TraversalRay r, bool any, inout Best best) {
    uint candidates = 0u;
    [[unroll]] for (uint i = 0u; i < few_triangles; i++) candidates |= filter_triangle(i, r);
    [[unroll]] for (uint i = 0u; i < few_spheres; i++) candidates |= filter_sphere(i, r);
    const uint are_triangles = few_triangles < 32u ? (1u << few_triangles) - 1u : 0xffffffffu;
#ifdef LANES
    // The lanes take each candidate of any of them together, so that one fetch serves all. Loops end in their
    // conditions (packet.glsl), so each body runs once at least, for nobody if need be.
    if (few_triangles != 0u) {
        uint of_any = any_lane(candidates & are_triangles);
        do {
            uint i = min(uint(findLSB(of_any)), few_triangles - 1u);
            bool mine = (candidates >> i & 1u) != 0u && !(any && best.primitive != NONE);
            try_triangle(gather_triangle(i), i, mine, r, best);
            of_any &= of_any - 1u;
        } while (of_any != 0u);
    }
    if (few_spheres != 0u) {
        uint of_any = any_lane(candidates & ~are_triangles);
        do {
            uint i = min(uint(findLSB(of_any)) - few_triangles, few_spheres - 1u);
            bool mine = (candidates >> (few_triangles + i) & 1u) != 0u && !(any && best.primitive != NONE);
            try_sphere(gather_sphere(i), triangle_count + i, mine, r, best);
            of_any &= of_any - 1u;
        } while (of_any != 0u);
    }
#else
    uint left = candidates & are_triangles;
    while (left != 0u) {
        test_triangle(findLSB(left), r, best);
        left = any && best.primitive != NONE ? 0u : left & (left - 1u);
    }
    left = any && best.primitive != NONE ? 0u : candidates & ~are_triangles;
    while (left != 0u) {
        test_sphere(triangle_count + findLSB(left) - few_triangles, r, best);
        left = any && best.primitive != NONE ? 0u : left & (left - 1u);
    }
#endif
}

void walk_brute(TraversalRay r, bool any, inout Best best) {
    if (triangle_count + sphere_count <= UNROLL_MAX) {
        walk_few(r, any, best);
    } else {
        [[dont_unroll]] for (uint i = 0u; i < triangle_count; i++) test_triangle(i, r, best);
        [[dont_unroll]] for (uint i = 0u; i < sphere_count; i++) test_sphere(triangle_count + i, r, best);
    }
}

// Kinds in the hierarchy: the walk has no code for one that is not.
const bool tree_triangles = triangle_count != 0u && triangles_outside == 0u;
const bool tree_spheres = sphere_count != 0u && spheres_outside == 0u;

// No node and no leaf: the end of a walk.
const uint DONE = 0xffffffffu;

#ifdef LANES
#include "traverse/packet.glsl"
#else
// False only where the test of a primitive finds no hit.
bool may_hit(uint primitive, TraversalRay r) {
    bool may = true;
    if (tree_triangles && primitive < triangle_count) {
        may = primitive != r.skip && may_hit_triangle(load_triangles(primitive), r.origin, r.shear);
    }
    if (tree_spheres && primitive >= triangle_count) {
        may = may_hit_sphere(load_spheres(primitive - triangle_count), r.origin, r.direction, primitive == r.skip);
    }
    return may;
}

// Entry distance into a child's box, or FAR if the ray misses it.
real entry(real3 lo, real3 hi, TraversalRay r, real limit) {
    real t = enter_box(lo, hi, r.origin, r.inverse, limit);
    return t >= 0.0 ? t : FAR;
}

// Two children, the nearer first.
void order(inout real t0, inout uint c0, inout real t1, inout uint c1) {
    bool swap = t1 < t0;
    real t = swap ? t1 : t0;
    uint c = swap ? c1 : c0;
    t1 = swap ? t0 : t1;
    c1 = swap ? c0 : c1;
    t0 = t;
    c0 = c;
}

// Three loops within one, each as short as can be, so that lanes which have something to do seldom wait
// for others at something else (Aila and Laine, "Understanding the Efficiency of Ray Traversal on GPUs",
// HPG 2009, "while-while"): down to a leaf, through the leaf to a primitive that passes the filter, and
// the whole test when each lane has one or is done.
void walk_bvh(TraversalRay r, bool any, inout Best best) {
    uint stack[STACK_SIZE + 4u]; // below all DONE, above all what is written and not kept
    stack[0] = DONE;
    uint top = 1u, steps = 0u;
    uint current = 0u;      // the root is node 0
    uint at = 0u, end = 0u; // what is left of the leaf in hand
    while (current != DONE || at < end) {
        uint candidate = NONE;
        while (candidate == NONE && (current != DONE || at < end)) {
            while (at == end && (current & LEAF_BIT) == 0u) {
                Node n = load_nodes(current);
                real t0 = entry(n.lo_0, n.hi_0, r, best.t), t1 = entry(n.lo_1, n.hi_1, r, best.t);
                real t2 = entry(n.lo_2, n.hi_2, r, best.t), t3 = entry(n.lo_3, n.hi_3, r, best.t);
                uint c0 = n.child_0, c1 = n.child_1, c2 = n.child_2, c3 = n.child_3;
                // Nearest first, what the ray misses last.
                order(t0, c0, t1, c1);
                order(t2, c2, t3, c3);
                order(t0, c0, t2, c2);
                order(t1, c1, t3, c3);
                order(t1, c1, t2, c2);
                uint entered = (t1 < FAR ? 1u : 0u) + (t2 < FAR ? 1u : 0u) + (t3 < FAR ? 1u : 0u);
                if (top + entered > STACK_SIZE + 1u) {
                    atomicAdd(counters[COUNTER_STACK_OVERFLOW], 1u);
                    entered = 0u;
                }
                // Farthest below; what is above the top is written over by the next.
                stack[top] = entered > 2u ? c3 : (entered > 1u ? c2 : c1);
                stack[top + 1u] = entered > 2u ? c2 : c1;
                stack[top + 2u] = c1;
                top += entered;
                if (t0 < FAR) {
                    current = c0;
                } else {
                    current = stack[--top];
                }
                steps++;
            }
            if (at == end && current != DONE) {
                at = current & ((1u << LEAF_FIRST_BITS) - 1u);
                end = at + ((current & ~LEAF_BIT) >> LEAF_FIRST_BITS) + 1u;
                current = stack[--top];
            }
            while (candidate == NONE && at < end) {
                candidate = may_hit(at, r) ? at : NONE;
                at++;
                steps++;
            }
            steps++; // of this loop too: lavapipe's limit is on the iterations of all
            if (steps > loop_cap) break;
        }
        steps++;
        if (steps > loop_cap) {
            atomicAdd(counters[COUNTER_LOOP_CAP], 1u);
            break;
        }
        if (candidate != NONE) {
            if (tree_triangles && candidate < triangle_count) test_triangle(candidate, r, best);
            if (tree_spheres && candidate >= triangle_count) test_sphere(candidate, r, best);
            if (any && best.primitive != NONE) break;
        }
    }
}

#endif

// Closest hit with 0 < t < limit. A ray that is not finite is counted and hits nothing.
Hit closest_hit(TraversalRay r, real limit, bool any) {
    bool finite = !(is_not_finite(r.origin) || is_not_finite(r.direction));
    if (!finite && limit > 0.0) atomicAdd(counters[COUNTER_NAN_RAYS], 1u);
    // Nothing lies before t = 0, so a limit of 0 finds nothing.
    Best best = Best(finite ? limit : real(0.0), 0.0, 0.0, NONE, NONE);
    if (!by_tree) {
        walk_brute(r, any, best);
        return Hit(best.t, best.u, best.v, best.primitive);
    }
#ifdef LANES
    test_outside(r, finite && limit > 0.0, any, best);
    walk_packet(r, finite && limit > 0.0 && !(any && best.primitive != NONE), any, best);
#else
    if (few_triangles + few_spheres != 0u) walk_few(r, any, best);
    if (!(any && best.primitive != NONE)) walk_bvh(r, any, best);
#endif
    return Hit(best.t, best.u, best.v, best.primitive);
}

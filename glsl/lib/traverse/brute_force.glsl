// Primitives one by one: all of them where there is no hierarchy, else those outside it.

// First the filter for each of at most 32 primitives, written out, then the whole test for what
// passes. lavapipe loads an address that all lanes share once if the load is outside all control
// flow, and it runs both sides of a branch (docs/design/decisions/005-brute-force-filter.md); on a
// GPU the lanes do not diverge.
// Where there are more, drivers unroll the loops before they see that nothing calls them.
const uint unrolled_triangles = outside_triangle_count <= UNROLL_MAX ? outside_triangle_count : 0u;
const uint unrolled_spheres = outside_sphere_count <= UNROLL_MAX ? outside_sphere_count : 0u;

void filtered_brute_force(TraversalRay r, bool any, inout Best best) {
    uint candidates = 0u;
    count_primitives(outside_triangle_count + outside_sphere_count);
    [[unroll]] for (uint i = 0u; i < unrolled_triangles; i++) candidates |= filter_triangle(i, r);
    [[unroll]] for (uint i = 0u; i < unrolled_spheres; i++) candidates |= filter_sphere(i, r);
    const bool has_other_bits = outside_triangle_count < 32u;
    const uint are_triangles = has_other_bits ? (1u << outside_triangle_count) - 1u : 0xffffffffu;
#ifdef LANES
    // The lanes test each candidate of any of them together, so that one fetch serves all. A loop
    // ends in its condition (packet.glsl), so its body runs at least once, for no lane if there is
    // no candidate.
    if (outside_triangle_count != 0u) {
        uint of_any = any_lane(candidates & are_triangles);
        do {
            uint i = min(uint(findLSB(of_any)), outside_triangle_count - 1u);
            bool mine = (candidates >> i & 1u) != 0u && !(any && best.primitive != NONE);
            try_triangle(gather_triangle(i), i, mine, r, best);
            of_any &= of_any - 1u;
        } while (of_any != 0u);
    }
    if (outside_sphere_count != 0u) {
        uint of_any = any_lane(candidates & ~are_triangles);
        do {
            uint i = min(uint(findLSB(of_any)) - outside_triangle_count, outside_sphere_count - 1u);
            bool is_candidate = (candidates >> (outside_triangle_count + i) & 1u) != 0u;
            bool mine = is_candidate && !(any && best.primitive != NONE);
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
        test_sphere(triangle_count + findLSB(left) - outside_triangle_count, r, best);
        left = any && best.primitive != NONE ? 0u : left & (left - 1u);
    }
#endif
}

void traverse_brute_force(TraversalRay r, bool any, inout Best best) {
    if (triangle_count + sphere_count <= UNROLL_MAX) {
        filtered_brute_force(r, any, best);
    } else if (triangle_count + sphere_count <= LOOP_CAP) {
        count_primitives(triangle_count + sphere_count);
        [[dont_unroll]] for (uint i = 0u; i < triangle_count; i++) test_triangle(i, r, best);
        [[dont_unroll]] for (uint i = 0u; i < sphere_count; i++) test_sphere(triangle_count + i, r, best);
    } else {
        // More than the loops of one invocation may have (traverse.glsl).
        atomicAdd(counters[COUNTER_UNFINISHED], 1u);
    }
}

#ifdef IN_PARTS
// The same, LOOP_CAP primitives a dispatch.
void go_on_by_brute_force(TraversalRay r, bool any, bool begin, inout Best best) {
    const uint all = triangle_count + sphere_count;
    if (all <= LOOP_CAP) {
        if (begin) traverse_brute_force(r, any, best);
        return;
    }
    uint first = begin ? 0u : kept(0u);
    uint end = first + min(all - first, LOOP_CAP);
    count_primitives(end - first);
    [[dont_unroll]] for (uint i = first; i < min(end, triangle_count); i++) test_triangle(i, r, best);
    [[dont_unroll]] for (uint i = max(first, triangle_count); i < end; i++) test_sphere(i, r, best);
    keep(0u, end);
    if (end < all) atomicAdd(counters[COUNTER_UNFINISHED], 1u);
}
#endif

#ifdef LANES
// What is outside the hierarchy, by the whole test: at most eight primitives, fetched by the lanes
// together. `alive`: the ray looks for hits.
void test_outside(TraversalRay r, bool alive, bool any, inout Best best) {
    for (uint i = 0u; i < outside_triangle_count; i++) {
        bool looks = alive && !(any && best.primitive != NONE);
        count_primitives(looks ? 1u : 0u);
        try_triangle(gather_triangle(i), i, looks, r, best);
    }
    for (uint i = 0u; i < outside_sphere_count; i++) {
        bool looks = alive && !(any && best.primitive != NONE);
        count_primitives(looks ? 1u : 0u);
        try_sphere(gather_sphere(i), triangle_count + i, looks, r, best);
    }
}
#endif

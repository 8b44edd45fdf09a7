// One walk over the hierarchy for all rays of a subgroup (Wald, Slusallek, Benthin, Wagner, "Interactive
// Rendering with Coherent Ray Tracing", 2001): at each step the lanes fetch one node between them, a texel
// each, and hand the words round; the stack lies in the lanes too, entry i with lane i % lanes. Nothing
// is loaded or stored lane by lane, and nothing but the full test of a primitive diverges. For devices
// on which a vector of a few lanes is the whole machine (src/plan.rs, `walks_in_packets`); the hits are those of
// `walk_bvh`, bit for bit, since neither nodes nor order decide them (numerics.md, Boxes).
// All lanes of the subgroup must call it together.

// Whether the ray meets the box within its limit; where it is entered, or would be.
bool meets(real3 lo, real3 hi, TraceRay r, real limit, out real near) {
    real far;
    box_interval(lo, hi, r.origin, r.inverse, near, far);
    return near <= far && near <= limit;
}

// Two children by the bits of their distances, which are not negative; the nearer first.
void order_bits(inout uint t0, inout uint c0, inout uint t1, inout uint c1) {
    bool swap = t1 < t0;
    uint t = swap ? t1 : t0;
    uint c = swap ? c1 : c0;
    t1 = swap ? t0 : t1;
    c1 = swap ? c0 : c1;
    t0 = t;
    c0 = c;
}

#define EACH_KEPT(X) X(0) X(1) X(2) X(3) X(4) X(5) X(6) X(7) X(8) X(9) X(10) X(11) X(12) X(13) X(14) X(15) X(16)
#define IS_KEPT(k) (uint(k) * lanes <= stack_size)

// The kind outside the hierarchy, one after the other.
void test_loose(TraceRay r, bool alive, bool any, inout Best best) {
    for (uint i = 0u; i < few_triangles; i++) {
        try_triangle(gather_triangle(i), i, alive && !(any && best.primitive != NONE), r, best);
    }
    for (uint i = 0u; i < few_spheres; i++) {
        try_sphere(gather_sphere(i), triangle_count + i, alive && !(any && best.primitive != NONE), r, best);
    }
}

#define PUT(k) if (IS_KEPT(k)) { \
        uint place = uint(k) * lanes + lane - top; \
        kept_##k = place < entered ? (place == 0u ? v0 : (place == 1u ? v1 : c1)) : kept_##k; \
    }
#define TAKE(k) if (IS_KEPT(k)) popped = top >= uint(k) * lanes ? kept_##k : popped;
#define POP(into) { \
        uint popped = kept_0; \
        EACH_KEPT(TAKE) \
        into = subgroupShuffle(popped, top & (lanes - 1u)); \
    }

// `alive`: the ray looks for hits up to best.t. Loops end in their conditions, for lavapipe runs what
// follows a break once more for nobody; it runs both sides of a branch, and skips nothing else.
void walk_packet(TraceRay r, bool alive, bool any, inout Best best) {
#define DECLARE(k) uint kept_##k = DONE;
    EACH_KEPT(DECLARE)
    uint lane = gl_SubgroupInvocationID;
    uint top = 1u, steps = 0u;
    uint current = 0u; // the root is node 0
    bool overflowed = false;
    // Below 0 once a ray is done: then it meets no box.
    real limit = alive ? best.t : real(-1.0);
    do {
        do {
            Pieces p = GATHER(nodes, current * 7u, 6u);
            Node n;
            unpack(LOW_PIECE(p, 0u), LOW_PIECE(p, 1u), LOW_PIECE(p, 2u), LOW_PIECE(p, 3u), HIGH_PIECE(p, 4u, 0u),
                   HIGH_PIECE(p, 5u, 1u), HIGH_PIECE(p, 6u, 2u), n);
            real n0, n1, n2, n3, grown = limit * SLAB_GROW;
            uint met = (meets(n.lo_0, n.hi_0, r, grown, n0) ? 1u : 0u) | (meets(n.lo_1, n.hi_1, r, grown, n1) ? 2u : 0u) |
                       (meets(n.lo_2, n.hi_2, r, grown, n2) ? 4u : 0u) | (meets(n.lo_3, n.hi_3, r, grown, n3) ? 8u : 0u);
            met = any_lane(met);
            // The first ray's order, what no ray meets last. A NaN's bits are below that.
            uint t0 = (met & 1u) != 0u ? floatBitsToUint(subgroupShuffle(n0, 0u)) : NONE;
            uint t1 = (met & 2u) != 0u ? floatBitsToUint(subgroupShuffle(n1, 0u)) : NONE;
            uint t2 = (met & 4u) != 0u ? floatBitsToUint(subgroupShuffle(n2, 0u)) : NONE;
            uint t3 = (met & 8u) != 0u ? floatBitsToUint(subgroupShuffle(n3, 0u)) : NONE;
            uint c0 = n.child_0, c1 = n.child_1, c2 = n.child_2, c3 = n.child_3;
            order_bits(t0, c0, t1, c1);
            order_bits(t2, c2, t3, c3);
            order_bits(t0, c0, t2, c2);
            order_bits(t1, c1, t3, c3);
            order_bits(t1, c1, t2, c2);
            uint entered = (t1 < NONE ? 1u : 0u) + (t2 < NONE ? 1u : 0u) + (t3 < NONE ? 1u : 0u);
            bool full = top + entered > (defect == DEFECT_SHORT_STACK ? 4u : stack_size + 1u);
            overflowed = overflowed || full;
            entered = full ? 0u : entered;
            // Farthest below.
            uint v0 = entered > 2u ? c3 : (entered > 1u ? c2 : c1);
            uint v1 = entered > 2u ? c2 : c1;
            EACH_KEPT(PUT)
            top += entered;
            bool down = met != 0u;
            top -= down ? 0u : 1u;
            uint below;
            POP(below)
            current = down ? c0 : below;
            steps++;
            current = steps > loop_cap ? DONE : current;
        } while ((current & LEAF_BIT) == 0u);
        do {
            uint at = current & ((1u << LEAF_FIRST_BITS) - 1u);
            uint more = (current & ~LEAF_BIT) >> LEAF_FIRST_BITS;
            bool leaf = current != DONE;
            if (tree_triangles) {
                bool mine = leaf && limit >= 0.0 && (!tree_spheres || at < triangle_count);
                try_triangle(gather_triangle(leaf ? at : 0u), at, mine, r, best);
            }
            if (tree_spheres) {
                bool sphere = leaf && at >= triangle_count;
                try_sphere(gather_sphere(sphere ? at - triangle_count : 0u), at, sphere && limit >= 0.0, r, best);
            }
            limit = limit >= 0.0 ? (any && best.primitive != NONE ? real(-1.0) : best.t) : limit;
            top -= more == 0u && leaf ? 1u : 0u;
            uint below;
            POP(below)
            current = leaf && more != 0u ? current + 1u - (1u << LEAF_FIRST_BITS) : (leaf ? below : DONE);
            if (any) current = any_lane(limit >= 0.0 ? 1u : 0u) == 0u ? DONE : current;
            steps++;
        } while ((current & LEAF_BIT) != 0u && current != DONE);
        steps++; // lavapipe's limit is on the iterations of all loops
    } while (current != DONE);
    if (overflowed && alive) atomicAdd(counters[COUNTER_STACK_OVERFLOW], 1u);
    if (steps > loop_cap && alive) atomicAdd(counters[COUNTER_LOOP_CAP], 1u);
}

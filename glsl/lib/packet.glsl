// One walk over the hierarchy for all rays of a subgroup (Wald, Slusallek, Benthin, Wagner, "Interactive
// Rendering with Coherent Ray Tracing", 2001): at each step the lanes fetch one node between them, a texel
// each, and hand the words round; the stack lies in the lanes too, entry i with lane i % lanes. Nothing
// is loaded or stored lane by lane, and nothing but the full test of a primitive diverges. For devices
// on which a vector of a few lanes is the whole machine (src/plan.rs, `walks_in_packets`); the hits are those of
// `walk_bvh`, bit for bit, since neither nodes nor order decide them (numerics.md, Boxes).
// All lanes of the subgroup must call it together.

#define least2(a, b) ((a) < (b) ? (a) : (b))
#define most2(a, b) ((a) > (b) ? (a) : (b))
#define GRID(k) number(subgroupShuffle(mine.grid, k))
#define STEPS(w) real3(float(int((w) & 1023u)), float(int((w) >> 10u & 1023u)), float(int((w) >> 20u & 1023u)))
#define RAY(j) real3 origin_##j = subgroupShuffle(r.origin, uint(j)), inverse_##j = subgroupShuffle(r.inverse, uint(j));
#define TEST(j) { \
        real x0 = (lo.x - origin_##j.x) * inverse_##j.x, x1 = (hi.x - origin_##j.x) * inverse_##j.x; \
        real y0 = (lo.y - origin_##j.y) * inverse_##j.y, y1 = (hi.y - origin_##j.y) * inverse_##j.y; \
        real z0 = (lo.z - origin_##j.z) * inverse_##j.z, z1 = (hi.z - origin_##j.z) * inverse_##j.z; \
        real xn = least2(x0, x1), xf = most2(x0, x1), yn = least2(y0, y1), yf = most2(y0, y1), zn = least2(z0, z1), zf = most2(z0, z1); \
        near = most2(most2(xn, yn), most2(zn, real(0.0))); \
        real far = least2(least2(xf, yf), zf) * SLAB_GROW; \
        met = met || near <= least2(far, limit_##j); \
    }
#define SORT(j, bit) { \
        int other = subgroupShuffle(key, lane ^ j); \
        key = (lane & bit) == 0u ? min(key, other) : max(key, other); \
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
        kept_##k = place < entered ? pushed : kept_##k; \
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
    RAY(0) RAY(1) RAY(2) RAY(3) RAY(4) RAY(5) RAY(6) RAY(7)
    uint top = 1u, steps = 0u;
    uint current = 0u; // the root is node 0
    bool overflowed = false;
    // Below 0 once a ray is done: then it meets no box.
    real limit = alive ? best.t : real(-1.0);
    do {
        real grown = limit * SLAB_GROW;
        real limit_0 = subgroupShuffle(grown, 0u);
        real limit_1 = subgroupShuffle(grown, 1u);
        real limit_2 = subgroupShuffle(grown, 2u);
        real limit_3 = subgroupShuffle(grown, 3u);
        real limit_4 = subgroupShuffle(grown, 4u);
        real limit_5 = subgroupShuffle(grown, 5u);
        real limit_6 = subgroupShuffle(grown, 6u);
        real limit_7 = subgroupShuffle(grown, 7u);
        do {
            CompressedChild mine = load_compressed_nodes(current * 8u + lane);
            real3 origin = real3(GRID(0u), GRID(1u), GRID(2u)), pace = real3(GRID(3u), GRID(4u), GRID(5u));
            real3 lo = origin + STEPS(mine.lo) * pace, hi = origin + STEPS(mine.hi) * pace;
            // Each lane tests its own child with all rays.
            bool met = false;
            real near, first;
            TEST(0) first = near; TEST(1) TEST(2) TEST(3) TEST(4) TEST(5) TEST(6) TEST(7)
            met = met && mine.link != NONE;
            // The first ray's order; the lane in the last bits. What no ray meets comes last.
            int key = (met ? floatBitsToInt(first) & 0x7ffffff8 : 0x7ffffff8) | int(lane);
            SORT(1u, 1u) SORT(3u, 2u) SORT(1u, 1u) SORT(7u, 4u) SORT(2u, 2u) SORT(1u, 1u)
            uint count = key < 0x7ffffff8 ? 1u : 0u;
            count += subgroupShuffle(count, lane ^ 1u);
            count += subgroupShuffle(count, lane ^ 2u);
            count += subgroupShuffle(count, lane ^ 4u);
            bool down = count != 0u;
            uint entered = max(count, 1u) - 1u;
            bool full = top + entered > (defect == DEFECT_SHORT_STACK ? 4u : stack_size + 1u);
            overflowed = overflowed || full;
            entered = full ? 0u : entered;
            uint sorted = subgroupShuffle(mine.link, uint(key) & 7u);
            // Farthest below.
            uint pushed = subgroupShuffle(sorted, (entered + top - lane) & 7u);
            EACH_KEPT(PUT)
            top += entered;
            top -= down ? 0u : 1u;
            uint below;
            POP(below)
            current = down ? subgroupShuffle(sorted, 0u) : below;
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

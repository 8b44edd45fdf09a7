// One walk over the hierarchy for all rays of a subgroup (Wald, Slusallek, Benthin, Wagner, "Interactive
// Rendering with Coherent Ray Tracing", 2001), over compressed nodes of eight children (src/prepare/bvh/compressed.rs):
// each lane fetches a child, a texel, and tests it with every ray of the packet in turn. So no box is handed
// round, and what any ray meets is known without asking. Of four lanes each has two children. The stack lies
// in the lanes too, entry i with lane i % lanes. Nothing is loaded or stored lane by lane, and nothing but the
// full test of a primitive diverges. For devices on which a vector of a few lanes is the whole machine
// (src/plan/mod.rs, `Limits::forms`); the hits are those of `walk_bvh`, bit for bit, since neither nodes nor order
// decide them (numerics.md, Boxes). All lanes of the subgroup must call it together.

// A corner of a compressed box, operation by operation as the host had it when it rounded the box outward.
real3 corner(real3 origin, real3 pace, uint steps) {
    // By way of int, whose conversion is one instruction.
    return origin + real3(float(int(steps & 1023u)), float(int(steps >> 10u & 1023u)), float(int(steps >> 20u))) * pace;
}

real lesser(real a, real b) {
    return a < b ? a : b;
}
real greater(real a, real b) {
    return a > b ? a : b;
}

// `box_interval` by least and greatest instead of by the signs of the direction: the same numbers, since a box's
// planes are in order and roundings keep it, without what depends on the ray alone.
bool meets(real3 lo, real3 hi, real3 o, real3 inv, real limit, out real near) {
    real x0 = (lo.x - o.x) * inv.x, x1 = (hi.x - o.x) * inv.x;
    real y0 = (lo.y - o.y) * inv.y, y1 = (hi.y - o.y) * inv.y;
    real z0 = (lo.z - o.z) * inv.z, z1 = (hi.z - o.z) * inv.z;
    near = greater(greater(lesser(x0, x1), lesser(y0, y1)), greater(lesser(z0, z1), real(0.0)));
    real far = lesser(lesser(greater(x0, x1), greater(y0, y1)), greater(z0, z1)) * SLAB_GROW;
    return near <= lesser(far, limit);
}

// Each ray of the packet, known to all lanes.
#define EACH_RAY(X) X(0) X(1) X(2) X(3) X(4) X(5) X(6) X(7)
#define SHARE_RAY(j) real3 origin_##j = real3(0.0), inverse_##j = real3(0.0); \
    if (j < lanes) { \
        origin_##j = subgroupShuffle(r.origin, j); \
        inverse_##j = subgroupShuffle(r.inverse, j); \
    }
#define SHARE_LIMIT(j) real limit_##j = j < lanes ? subgroupShuffle(grown, j) : grown;
#define MEET(j) if (j < lanes) { \
        real near; \
        bool by_##j = meets(lo, hi, origin_##j, inverse_##j, limit_##j, near); \
        met = met || by_##j; \
        first = j == 0 ? near : first; \
    }
// Whether any ray meets child `k`, the lane's own, as a key to sort by: the first ray's distance, with the child
// in the last bits; above UNMET if none does. A NaN's bits are below that.
#define TEST(child, k, key) { \
        real3 lo = corner(origin, pace, child.lo), hi = corner(origin, pace, child.hi); \
        bool met = false; \
        real first = 0.0; \
        EACH_RAY(MEET) \
        met = met && child.link != NONE; \
        key = (met ? floatBitsToInt(first) & UNMET : UNMET) | int(k); \
    }
const int UNMET = 0x7ffffff8;

// Batcher's bitonic sort (AFIPS 1968) of eight keys, ascending, each step with the lane whose number differs in
// the bits of `j`; the lane without `bit` takes the lesser.
#define EXCHANGE(key, j, bit) { \
        int other = subgroupShuffle(key, lane ^ j); \
        key = (lane & bit) == 0u ? min(key, other) : max(key, other); \
    }
// Of eight values, of which four lanes hold two each, the one numbered i.
uint pick(uint low, uint high, uint i) {
    if (lanes > 4u) return subgroupShuffle(low, i & 7u);
    uint a = subgroupShuffle(low, i & 3u), b = subgroupShuffle(high, i & 3u);
    return (i & 4u) == 0u ? a : b;
}

#define EACH_KEPT(X) X(0) X(1) X(2) X(3) X(4) X(5) X(6) X(7) X(8) X(9) X(10) X(11) X(12) X(13) X(14) X(15) \
    X(16) X(17) X(18) X(19) X(20) X(21) X(22) X(23)
#define IS_KEPT(k) (uint(k) * lanes <= stack_size)

#define PUT(k) if (IS_KEPT(k)) { \
        uint place = uint(k) * lanes + lane - top; \
        kept_##k = place < entered ? (lanes > 4u || k % 2 == 0 ? pushed : pushed_odd) : kept_##k; \
    }
#define TAKE(k) if (IS_KEPT(k)) popped = top >= uint(k) * lanes ? kept_##k : popped;
#define POP(into) { \
        uint popped = kept_0; \
        EACH_KEPT(TAKE) \
        into = subgroupShuffle(popped, top & (lanes - 1u)); \
    }

// `alive`: the ray looks for hits up to best.t. Loops end in their conditions, for lavapipe runs what
// follows a break once more for nobody; it runs both sides of a branch, and skips nothing else.
void walk_packet(TraversalRay r, bool alive, bool any, inout Best best) {
#define DECLARE(k) uint kept_##k = DONE;
    EACH_KEPT(DECLARE)
    uint lane = gl_SubgroupInvocationID;
    EACH_RAY(SHARE_RAY)
    uint top = 1u, steps = 0u;
    uint current = 0u; // the root is node 0
    bool overflowed = false;
    // Below 0 once a ray is done: then it meets no box.
    real limit = alive ? best.t : real(-1.0);
    do {
        real grown = limit * SLAB_GROW;
        EACH_RAY(SHARE_LIMIT)
        do {
            CompressedChild mine = load_compressed_nodes(current * 8u + lane), other = mine;
            if (lanes < 8u) other = load_compressed_nodes(current * 8u + 4u + lane);
#define GRID(k) number(lanes < 8u && k > 3u ? subgroupShuffle(other.grid, k & 3u) : subgroupShuffle(mine.grid, k & (lanes - 1u)))
            real3 origin = real3(GRID(0u), GRID(1u), GRID(2u)), pace = real3(GRID(3u), GRID(4u), GRID(5u));
            int low, high = UNMET;
            TEST(mine, lane, low)
            if (lanes < 8u) TEST(other, lane + 4u, high)
            EXCHANGE(low, 1u, 1u)
            EXCHANGE(low, 3u, 2u)
            EXCHANGE(low, 1u, 1u)
            if (lanes < 8u) {
                EXCHANGE(high, 1u, 1u)
                EXCHANGE(high, 3u, 2u)
                EXCHANGE(high, 1u, 1u)
                int of_high = subgroupShuffle(high, lane ^ 3u), of_low = subgroupShuffle(low, lane ^ 3u);
                low = min(low, of_high);
                high = max(high, of_low);
                EXCHANGE(high, 2u, 2u)
                EXCHANGE(high, 1u, 1u)
            } else {
                EXCHANGE(low, 7u, 4u)
            }
            EXCHANGE(low, 2u, 2u)
            EXCHANGE(low, 1u, 1u)
            uint count = (low < UNMET ? 1u : 0u) + (lanes < 8u && high < UNMET ? 1u : 0u);
            count += subgroupShuffle(count, lane ^ 1u);
            count += subgroupShuffle(count, lane ^ 2u);
            if (lanes > 4u) count += subgroupShuffle(count, lane ^ 4u);
            bool down = count != 0u;
            uint entered = max(count, 1u) - 1u;
            bool full = top + entered > stack_size + 1u;
            overflowed = overflowed || full;
            entered = full ? 0u : entered;
            uint near = pick(mine.link, other.link, uint(low)), distant = near;
            if (lanes < 8u) distant = pick(mine.link, other.link, uint(high));
            // Farthest below.
            uint pushed = pick(near, distant, entered + top - lane), pushed_odd = pushed;
            if (lanes < 8u) pushed_odd = pick(near, distant, entered + top - lane - 4u);
            EACH_KEPT(PUT)
            top += entered;
            top -= down ? 0u : 1u;
            uint below;
            POP(below)
            current = down ? subgroupShuffle(near, 0u) : below;
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

// Traversal of the hierarchy by all rays of a subgroup, a packet, together.
//
// What it does. The packet enters every node that any of its rays meets, nearest first, and tests
// every primitive of the leaves with all its rays, one ray per lane. It is for devices on which a
// vector of 4 or 8 lanes is the whole machine (src/plan/mod.rs, `Limits::forms`): a lane's own
// loads and stores are dear there, shuffles and arithmetic cheap, and both sides of a branch are
// executed. Every lane of the subgroup must call it. The hits are those of `traverse_hierarchy`,
// bit for bit: neither the nodes nor their order decide them (numerics.md, Boxes).
//
// Papers. Wald, Slusallek, Benthin and Wagner, "Interactive Rendering with Coherent Ray Tracing",
// Eurographics 2001: rays of a packet traverse together. Ylitie, Karras and Laine, "Efficient
// Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", HPG 2017: the nodes. Batcher,
// "Sorting Networks and Their Applications", AFIPS 1968: the order of children.
//
// Layout of a node (src/prepare/bvh/compressed.rs). It has eight children of one texel each. Lane i
// fetches child i; of four lanes each fetches child i and child i + 4. The first six texels also
// hold one number of the node's grid each. A lane tests its child with every ray of the packet, so
// boxes are never exchanged. Lanes exchange their rays once, before the traversal, and limits
// before each descent.
//
// Layout of the stack. Entry i lies in row i / lanes of lane i % lanes. A row is a variable of the
// lane, a register as far as the machine has them. `top`, the number of entries, is the same in all
// lanes. Entry 0 is DONE, which ends the traversal.
//
// Loops over rays and rows are unrolled: the optimiser then makes a variable of each array element,
// where an array with an index known only at run time would lie in memory. The number of a ray's
// lane is constant then, too: for such a shuffle lavapipe has an instruction, for others a loop
// over the lanes. A `while` is at the end of its loop, without a `break`: lavapipe executes what
// follows a `break` once more for no lane.

const uint LANES_MOST = 8u;
const uint ROWS_MOST = (PACKET_STACK_SIZE + 1u) / 4u;

// The rays of the packet, by lane.
struct Packet {
    real3 origin[LANES_MOST];
    real3 inverse[LANES_MOST];
    real limit[LANES_MOST]; // largest t of a box that the ray may enter; below 0: the ray is done
};

void share_rays(TraversalRay r, inout Packet packet) {
    [[unroll]] for (uint i = 0u; i < LANES_MOST; i++) {
        packet.origin[i] = real3(0.0);
        packet.inverse[i] = real3(0.0);
        if (i < lanes) {
            packet.origin[i] = subgroupShuffle(r.origin, i);
            packet.inverse[i] = subgroupShuffle(r.inverse, i);
        }
    }
}

void share_limits(real limit, inout Packet packet) {
    [[unroll]] for (uint i = 0u; i < LANES_MOST; i++) {
        packet.limit[i] = i < lanes ? subgroupShuffle(limit, i) : limit;
    }
}

// Number k of the node's grid. `low`: the child that the lane fetched first, `high`: of four lanes
// the second.
real grid_number(CompressedChild low, CompressedChild high, uint k) {
    bool is_high = lanes < 8u && k > 3u;
    return number(is_high ? subgroupShuffle(high.grid, k & 3u) : subgroupShuffle(low.grid, k & (lanes - 1u)));
}
real3 grid_numbers(CompressedChild low, CompressedChild high, uint k) {
    return real3(grid_number(low, high, k), grid_number(low, high, k + 1u), grid_number(low, high, k + 2u));
}

// A corner of a compressed box, operation by operation as the host had it when it rounded the box
// outward. `pace`: the length of a step on each axis.
real3 corner(real3 origin, real3 pace, uint steps) {
    // By way of int, whose conversion is one instruction.
    int x = int(steps & 1023u), y = int(steps >> 10u & 1023u), z = int(steps >> 20u);
    return origin + real3(float(x), float(y), float(z)) * pace;
}

real lesser(real a, real b) {
    return a < b ? a : b;
}
real greater(real a, real b) {
    return a > b ? a : b;
}

// `box_interval` by least and greatest instead of by the signs of the direction: the same numbers,
// since a box's planes are in order and rounding keeps the order. Every lane tests every ray, and
// selections by a ray's signs would be made anew for each box.
bool meets(real3 lo, real3 hi, real3 o, real3 inv, real limit, out real near) {
    real x0 = (lo.x - o.x) * inv.x, x1 = (hi.x - o.x) * inv.x;
    real y0 = (lo.y - o.y) * inv.y, y1 = (hi.y - o.y) * inv.y;
    real z0 = (lo.z - o.z) * inv.z, z1 = (hi.z - o.z) * inv.z;
    near = greater(greater(lesser(x0, x1), lesser(y0, y1)), greater(lesser(z0, z1), real(0.0)));
    real far = lesser(lesser(greater(x0, x1), greater(y0, y1)), greater(z0, z1)) * SLAB_GROW;
    return near <= lesser(far, limit);
}

// Key of a child that no ray meets: above all others. The last three bits are left for the child's
// number.
const int UNMET = 0x7ffffff8;

// Whether ray i meets the box, added to `met`; of ray 0 also where it enters the box.
void test_ray(uint i, real3 lo, real3 hi, Packet packet, inout bool met, inout real first) {
    if (i < lanes) {
        real near;
        bool met_by_ray = meets(lo, hi, packet.origin[i], packet.inverse[i], packet.limit[i], near);
        met = met || met_by_ray;
        first = i == 0u ? near : first;
    }
}

// A child's key to sort by. If any ray of the packet meets the child: bits of the distance at which
// ray 0 enters it, the last three replaced by the child's number. The bits of a NaN (0x7fc00000)
// are below UNMET too.
int sort_key(CompressedChild child, uint number_of_child, real3 origin, real3 pace, Packet packet) {
    real3 lo = corner(origin, pace, child.lo), hi = corner(origin, pace, child.hi);
    bool met = false;
    real first = 0.0;
    // No loop: the copies that the optimiser makes of a loop's body lack the marks that forbid
    // contraction, and the build refuses them.
    test_ray(0u, lo, hi, packet, met, first);
    test_ray(1u, lo, hi, packet, met, first);
    test_ray(2u, lo, hi, packet, met, first);
    test_ray(3u, lo, hi, packet, met, first);
    test_ray(4u, lo, hi, packet, met, first);
    test_ray(5u, lo, hi, packet, met, first);
    test_ray(6u, lo, hi, packet, met, first);
    test_ray(7u, lo, hi, packet, met, first);
    met = met && child.link != NONE;
    return (met ? floatBitsToInt(first) & UNMET : UNMET) | int(number_of_child);
}

// A step of the sort: with the lane whose number differs in the bits of `mask`. The lane without
// `bit` keeps the lesser key.
int exchange(int key, uint mask, uint bit) {
    int other = subgroupShuffle(key, gl_SubgroupInvocationID ^ mask);
    return (gl_SubgroupInvocationID & bit) == 0u ? min(key, other) : max(key, other);
}

// Batcher's bitonic sort of eight keys, ascending from lane to lane. Of four lanes `low` are keys 0
// to 3 and `high` keys 4 to 7.
void sort_keys(inout int low, inout int high) {
    low = exchange(low, 1u, 1u);
    low = exchange(low, 3u, 2u);
    low = exchange(low, 1u, 1u);
    if (lanes < 8u) {
        high = exchange(high, 1u, 1u);
        high = exchange(high, 3u, 2u);
        high = exchange(high, 1u, 1u);
        int of_high = subgroupShuffle(high, gl_SubgroupInvocationID ^ 3u);
        int of_low = subgroupShuffle(low, gl_SubgroupInvocationID ^ 3u);
        low = min(low, of_high);
        high = max(high, of_low);
        high = exchange(high, 2u, 2u);
        high = exchange(high, 1u, 1u);
    } else {
        low = exchange(low, 7u, 4u);
    }
    low = exchange(low, 2u, 2u);
    low = exchange(low, 1u, 1u);
}

// Children that any ray meets.
uint count_met(int low, int high) {
    uint count = (low < UNMET ? 1u : 0u) + (lanes < 8u && high < UNMET ? 1u : 0u);
    count += subgroupShuffle(count, gl_SubgroupInvocationID ^ 1u);
    count += subgroupShuffle(count, gl_SubgroupInvocationID ^ 2u);
    if (lanes > 4u) count += subgroupShuffle(count, gl_SubgroupInvocationID ^ 4u);
    return count;
}

// Of eight values in the lanes' order the one numbered i, modulo 8. Of four lanes `low` are values
// 0 to 3 and `high` values 4 to 7.
uint pick(uint low, uint high, uint i) {
    if (lanes > 4u) return subgroupShuffle(low, i & 7u);
    uint a = subgroupShuffle(low, i & 3u), b = subgroupShuffle(high, i & 3u);
    return (i & 4u) == 0u ? a : b;
}

// This lane's entries of the stack.
struct PacketStack {
    uint rows[ROWS_MOST];
    uint top; // entries, DONE included: the next is written there
};

// Whether a stack of stack_size entries above entry 0 reaches row k: known when the driver
// compiles.
bool has_row(uint k) {
    return k * lanes <= stack_size;
}

PacketStack empty_stack() {
    PacketStack stack;
    [[unroll]] for (uint k = 0u; k < ROWS_MOST; k++) stack.rows[k] = DONE;
    stack.top = 1u;
    return stack;
}

// Pushes `count` links, the farthest first. `low` and `high`: links in the order of their keys, as
// in `pick`; those numbered 1 to `count` are pushed.
void push_farther(uint low, uint high, uint count, inout PacketStack stack) {
    uint lane = gl_SubgroupInvocationID;
    // What this lane writes: into one row of eight lanes, into an even and an odd row of four.
    uint even = pick(low, high, count + stack.top - lane), odd = even;
    if (lanes < 8u) odd = pick(low, high, count + stack.top - lane - 4u);
    [[unroll]] for (uint k = 0u; k < ROWS_MOST; k++) {
        if (has_row(k)) {
            uint place = k * lanes + lane - stack.top;
            stack.rows[k] = place < count ? (lanes > 4u || k % 2u == 0u ? even : odd) : stack.rows[k];
        }
    }
    stack.top += count;
}

// The topmost entry, taken off. If it is not `wanted` the stack stays and the result means nothing:
// a branch would save no work on lavapipe.
uint pop(bool wanted, inout PacketStack stack) {
    stack.top -= wanted ? 1u : 0u;
    uint row = stack.rows[0];
    [[unroll]] for (uint k = 0u; k < ROWS_MOST; k++) {
        if (has_row(k)) row = stack.top >= k * lanes ? stack.rows[k] : row;
    }
    return subgroupShuffle(row, stack.top & (lanes - 1u));
}

// `alive`: the ray looks for hits up to best.t.
void traverse_packet(TraversalRay r, bool alive, bool any, inout Best best) {
    uint lane = gl_SubgroupInvocationID;
    Packet packet;
    share_rays(r, packet);
    PacketStack stack = empty_stack();
    uint current = 0u; // the root is node 0
    bool overflowed = false;
#ifdef IN_PARTS
    if (push.walk_round != 0u) {
        current = kept(0u);
        stack.top = kept(1u);
        [[unroll]] for (uint k = 0u; k < ROWS_MOST; k++) stack.rows[k] = kept(2u + k);
        if (current == DONE) return;
    }
#endif
    // Below 0 once a ray is done: then it meets no box.
    real limit = alive ? best.t : real(-1.0);
    do {
        share_limits(limit * SLAB_GROW, packet);
        // Down to a leaf.
        do {
            CompressedChild low_child = load_compressed_nodes(current * 8u + lane), high_child = low_child;
            if (lanes < 8u) high_child = load_compressed_nodes(current * 8u + 4u + lane);
            if (counting != 0u) {
                uint high_present = lanes < 8u && high_child.link != NONE ? 1u : 0u;
                uint present = sum_lanes((low_child.link != NONE ? 1u : 0u) + high_present);
                count_boxes(limit >= 0.0 ? present : 0u);
            }
            real3 origin = grid_numbers(low_child, high_child, 0u);
            real3 pace = grid_numbers(low_child, high_child, 3u);
            int low = sort_key(low_child, lane, origin, pace, packet), high = UNMET;
            if (lanes < 8u) high = sort_key(high_child, lane + 4u, origin, pace, packet);
            sort_keys(low, high);
            uint count = count_met(low, high);
            bool down = count != 0u;
            uint entered = max(count, 1u) - 1u;
            bool full = stack.top + entered > stack_size + 1u;
            overflowed = overflowed || full;
            entered = full ? 0u : entered;
            // Links in the order of the keys.
            uint near = pick(low_child.link, high_child.link, uint(low)), distant = near;
            if (lanes < 8u) distant = pick(low_child.link, high_child.link, uint(high));
            push_farther(near, distant, entered, stack);
            uint below = pop(!down, stack);
            current = down ? subgroupShuffle(near, 0u) : below;
            steps++;
        } while ((current & LEAF_BIT) == 0u && steps <= loop_cap);
        // Through leaves, a primitive an iteration, to the next node.
        do {
            uint at = current & ((1u << LEAF_FIRST_BITS) - 1u);
            uint more = (current & ~LEAF_BIT) >> LEAF_FIRST_BITS;
            bool leaf = int(current) < -1; // LEAF_BIT is the sign, and DONE is -1
            if (triangles_in_hierarchy) {
                bool mine = leaf && limit >= 0.0 && (!spheres_in_hierarchy || at < triangle_count);
                count_primitives(mine ? 1u : 0u);
                try_triangle(gather_triangle(leaf ? at : 0u), at, mine, r, best);
            }
            if (spheres_in_hierarchy) {
                bool sphere = leaf && at >= triangle_count, mine = sphere && limit >= 0.0;
                count_primitives(mine ? 1u : 0u);
                try_sphere(gather_sphere(sphere ? at - triangle_count : 0u), at, mine, r, best);
            }
            limit = limit >= 0.0 ? (any && best.primitive != NONE ? real(-1.0) : best.t) : limit;
            uint below = pop(more == 0u && leaf, stack);
            current = leaf ? (more != 0u ? current + 1u - (1u << LEAF_FIRST_BITS) : below) : current;
            if (any) current = any_lane(limit >= 0.0 ? 1u : 0u) == 0u ? DONE : current;
            steps++;
        } while (int(current) < -1);
        steps++; // lavapipe's limit is on the iterations of all loops
    } while (current != DONE && steps <= loop_cap);
#ifdef IN_PARTS
    keep(0u, current);
    keep(1u, stack.top);
    [[unroll]] for (uint k = 0u; k < ROWS_MOST; k++) keep(2u + k, stack.rows[k]);
#endif
    if (overflowed && alive) atomicAdd(counters[COUNTER_STACK_OVERFLOW], 1u);
    if (current != DONE && alive) atomicAdd(counters[COUNTER_UNFINISHED], 1u);
}

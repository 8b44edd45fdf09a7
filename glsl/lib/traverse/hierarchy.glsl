// Traversal of the hierarchy by one ray, over nodes with four children (src/prepare/bvh/wide.rs).

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

// Children that are there: the box of one that is not is inverted.
uint present(Node n) {
    return (n.lo_0.x <= n.hi_0.x ? 1u : 0u) + (n.lo_1.x <= n.hi_1.x ? 1u : 0u) + (n.lo_2.x <= n.hi_2.x ? 1u : 0u)
        + (n.lo_3.x <= n.hi_3.x ? 1u : 0u);
}

// Three loops within one, each as short as can be, so that lanes which have something to do seldom
// wait for others at something else (Aila and Laine, "Understanding the Efficiency of Ray Traversal
// on GPUs", HPG 2009, "while-while"): down to a leaf, through the leaf to a primitive that passes
// the filter, and the whole test when each lane has one or is done.
//
// Steps. What a driver counts for a vector of lanes is at most the sum of what its lanes count: every pass
// through a loop's body has a lane that takes part, and what else a loop costs, a pass of its condition alone,
// is counted with the loop around it. So a pass of an inner loop is one step; of the loop around the two of
// them, one and one for each of them; of the outermost, one and those three.
void traverse_hierarchy(TraversalRay r, bool any, inout Best best) {
    uint stack[STACK_SIZE + 4u]; // below all DONE, above all what is written and not kept
    stack[0] = DONE;
    uint top = 1u;
    uint current = 0u;      // the root is node 0
    uint at = 0u, end = 0u; // what is left of the leaf in hand
#ifdef IN_PARTS
    if (push.walk_round != 0u) {
        current = kept(0u);
        at = kept(1u);
        end = kept(2u);
        top = kept(3u);
        for (uint k = 1u; k < top; k++) stack[k] = kept(3u + k);
    }
#endif
    while (current != DONE || at < end) {
        uint candidate = NONE;
        while (candidate == NONE && (current != DONE || at < end)) {
            while (at == end && (current & LEAF_BIT) == 0u && steps <= loop_cap) {
                Node n = load_nodes(current);
                if (counting != 0u) count_boxes(present(n));
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
            // A leaf: LEAF_BIT is the sign, and DONE is -1.
            if (at == end && int(current) < -1) {
                at = current & ((1u << LEAF_FIRST_BITS) - 1u);
                end = at + ((current & ~LEAF_BIT) >> LEAF_FIRST_BITS) + 1u;
                current = stack[--top];
            }
            while (candidate == NONE && at < end) {
                count_primitives(1u);
                candidate = may_hit(at, r) ? at : NONE;
                at++;
                steps++;
            }
            steps += 3u;
            if (steps > loop_cap) break;
        }
        steps += 4u;
        if (candidate != NONE) {
            if (triangles_in_hierarchy && candidate < triangle_count) test_triangle(candidate, r, best);
            if (spheres_in_hierarchy && candidate >= triangle_count) test_sphere(candidate, r, best);
            if (any && best.primitive != NONE) {
                current = DONE;
                at = end;
            }
        }
        if (steps > loop_cap) break;
    }
#ifdef IN_PARTS
    keep(0u, current);
    keep(1u, at);
    keep(2u, end);
    keep(3u, top);
    for (uint k = 1u; k < top; k++) keep(3u + k, stack[k]);
#endif
    if (current != DONE || at < end) atomicAdd(counters[COUNTER_UNFINISHED], 1u);
}

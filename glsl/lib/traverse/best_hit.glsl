// The nearest hit so far, and the tests of primitives that may replace it.

// `id` is the primitive's position in the scene's own order: of hits at the same t the one with the
// smallest id counts, whatever the order in storage.
struct Best {
    real t, u, v;
    uint primitive;
    uint id;
};

// True if a hit near a triangle's plane is an artefact: t is off by some 40u over the triangle's
// height (slivers), so that a ray which leaves a surface may seem to meet a neighbour in its plane.
// The origin's side of the plane is what the spawn offset keeps clear of doubt. Where rounding
// could have made either sign (4u a component), the hit stands: meshes stay closed.
bool recedes(Triangle t, real3 normal, TraversalRay r, real distance) {
    real3 e1 = t.b - t.a, e2 = t.c - t.a, to = t.a - r.origin;
    real m1 = max_component(e1), m2 = max_component(e2);
    bool is_far = distance * max_component(r.direction) > (m1 > m2 ? m1 : m2);
    real height = dot3(normal, to), along = dot3(normal, r.direction);
    real unsure = (8.0 * U) * max_component(to), parallel = (8.0 * U) * max_component(r.direction);
    return !is_far && ((height < -unsure && along > parallel) || (height > unsure && along < -parallel));
}

// Takes a hit into `best` if it is nearer. It must lie in the primitive's own box, and its t is
// confined to the box's interval: whatever rounding did to t, no node around the primitive is
// culled then, and the hierarchy finds what brute force finds, bit for bit (numerics.md, Boxes).
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

// The test of a primitive that is loaded. It changes `best` only if `may` is true.
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

// The same by the primitive's number, loaded by each invocation for itself.
void test_triangle(uint primitive, TraversalRay r, inout Best best) {
    try_triangle(load_triangles(primitive), primitive, true, r, best);
}

void test_sphere(uint primitive, TraversalRay r, inout Best best) {
    try_sphere(load_spheres(primitive - triangle_count), primitive, true, r, best);
}

// Filters: a handful of operations without a branch, false only where the whole test of a primitive
// finds no hit. They use none of the exact rechecks, so a primitive that passes may still be
// missed.

// Of the primitives outside the hierarchy, as bits: triangle i is bit i, sphere i is bit
// outside_triangle_count + i.
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
    return may ? 1u << (outside_triangle_count + i) : 0u;
}

// Of one primitive of the hierarchy, by its number.
bool may_hit(uint primitive, TraversalRay r) {
    bool may = true;
    if (triangles_in_hierarchy && primitive < triangle_count) {
        may = primitive != r.skip && may_hit_triangle(load_triangles(primitive), r.origin, r.shear);
    }
    if (spheres_in_hierarchy && primitive >= triangle_count) {
        Sphere s = load_spheres(primitive - triangle_count);
        may = may_hit_sphere(s, r.origin, r.direction, primitive == r.skip);
    }
    return may;
}

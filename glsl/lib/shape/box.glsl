// Ray/box by slabs: Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013, with the factor for Vulkan's
// 2.5-ulp division (numerics.md, Boxes): t = (b - o) * (1/d) carries (1 + 2u)^7.

const real SLAB_GROW = 1.0 + 16.0 * U; // 1 + 2 g(7), rounded up to a power of two
// f32's pad at both precisions, though f64 could do with less.
const float PAD = 1.9073486328125e-6; // 2^-19: Woop's own enlargement is at most 20u, 32u covers it

// 1/d with |d| >= 2^-80, sign kept, so that no product is NaN; the padding of the boxes keeps a ray
// that lies in a face inside (numerics.md, Boxes).
real safe_reciprocal(real d) {
    real m = abs(d);
    m = m > 8.271806125530277e-25 ? m : real(8.271806125530277e-25); // 2^-80
    return 1.0 / (is_negative(d) ? -m : m);
}
real3 safe_reciprocal(real3 d) {
    return real3(safe_reciprocal(d.x), safe_reciprocal(d.y), safe_reciprocal(d.z));
}

// True if the ray crosses an axis upward; for a component of -0, whose reciprocal is -2^80, false.
bool is_upward(real inv) {
    return inv >= 0.0;
}

// Where the ray is within the box: [near, far], near >= 0. Empty if near > far.
void box_interval(real3 lo, real3 hi, real3 o, real3 inv, out real near, out real far) {
    real x0 = (lo.x - o.x) * inv.x, x1 = (hi.x - o.x) * inv.x;
    real y0 = (lo.y - o.y) * inv.y, y1 = (hi.y - o.y) * inv.y;
    real z0 = (lo.z - o.z) * inv.z, z1 = (hi.z - o.z) * inv.z;
    near = is_upward(inv.x) ? x0 : x1;
    far = is_upward(inv.x) ? x1 : x0;
    real yn = is_upward(inv.y) ? y0 : y1, yf = is_upward(inv.y) ? y1 : y0;
    real zn = is_upward(inv.z) ? z0 : z1, zf = is_upward(inv.z) ? z1 : z0;
    near = yn > near ? yn : near;
    near = zn > near ? zn : near;
    far = yf < far ? yf : far;
    far = zf < far ? zf : far;
    near = near > 0.0 ? near : real(0.0);
    far = far * SLAB_GROW;
}

// Entry distance, or a negative number if the ray misses the box within (0, limit].
real enter_box(real3 lo, real3 hi, real3 o, real3 inv, real limit) {
    real near, far;
    box_interval(lo, hi, o, inv, near, far);
    return near <= far && near <= limit * SLAB_GROW ? near : real(-1.0);
}

// A face of a primitive's own box: moved outward by the pad, in proportion beyond the unit frame.
// The host builds the hierarchy from the same expression (src/prepare/bvh), so its boxes contain this one.
real pad_down(real x) {
    return x - PAD * (abs(x) > 1.0 ? abs(x) : 1.0);
}
real pad_up(real x) {
    return x + PAD * (abs(x) > 1.0 ? abs(x) : 1.0);
}
real least(real a, real b, real c) {
    real m = a < b ? a : b;
    return m < c ? m : c;
}
real greatest(real a, real b, real c) {
    real m = a > b ? a : b;
    return m > c ? m : c;
}
void triangle_box(Triangle t, out real3 lo, out real3 hi) {
    lo = real3(pad_down(least(t.a.x, t.b.x, t.c.x)), pad_down(least(t.a.y, t.b.y, t.c.y)), pad_down(least(t.a.z, t.b.z, t.c.z)));
    hi = real3(pad_up(greatest(t.a.x, t.b.x, t.c.x)), pad_up(greatest(t.a.y, t.b.y, t.c.y)), pad_up(greatest(t.a.z, t.b.z, t.c.z)));
}
void sphere_box(Sphere s, out real3 lo, out real3 hi) {
    lo = real3(pad_down(s.center.x - s.radius), pad_down(s.center.y - s.radius), pad_down(s.center.z - s.radius));
    hi = real3(pad_up(s.center.x + s.radius), pad_up(s.center.y + s.radius), pad_up(s.center.z + s.radius));
}

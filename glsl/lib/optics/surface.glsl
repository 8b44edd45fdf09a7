// Position, normal and spawn offset of a hit.
// Spawn offset (numerics.md, Spawn origins): bounds the rounding of the hit point, so that a neighbour
// which the point lies on is not hit from behind; the primitive itself is skipped by identity.
#ifndef SURFACE
#define SURFACE

struct Point {
    real3 position;
    real3 geometric; // unit, as stored: outward for a solid's surface
    real3 normal;    // unit shading normal, on the side of `geometric`
    real3 offset;    // along `geometric`
};

// Share of a triangle's height that `by` is, for the height over `base`; at most an eighth, so that
// three of them leave room. Tiny triangles, whose area underflows, get the eighth.
real inset_share(real by, real3 base, real area) {
    real share = by * sqrt(dot3(base, base)) / area;
    return share < 0.125 ? share : real(0.125);
}

// Weights that keep a hit off the triangle's edges by what its position is uncertain by and its spawn
// offset: rounding would else put it beyond the wall that meets the triangle there, and its rays with
// it. Four times the offset serves walls that meet at atan(1/4) = 14 degrees or more. An edge inside a
// polygon has no wall.
void inset(real3 e1, real3 e2, real by, uint inner_edges, inout real u, inout real v) {
    real3 n = cross3(e1, e2);
    real area = sqrt(dot3(n, n));
    real least_u = (inner_edges & INNER_CA) != 0u ? real(0.0) : inset_share(by, e2, area);
    real least_v = (inner_edges & INNER_AB) != 0u ? real(0.0) : inset_share(by, e1, area);
    real least_w = inset_share(by, e2 - e1, area);
    u = u > least_u ? u : least_u;
    v = v > least_v ? v : least_v;
    real lack = least_w - (1.0 - u - v);
    if (lack > 0.0) {
        if (u > v) u -= lack;
        else v -= lack;
    }
}

Point triangle_point(Triangle t, real3 normal, real u, real v) {
    real3 e1 = t.b - t.a, e2 = t.c - t.a;
    Point p;
    p.geometric = real3(t.normal_x, t.normal_y, t.normal_z);
    p.normal = normal;
    real m1 = max_component(e1), m2 = max_component(e2), m3 = max_component(e2 - e1);
    real extent = m1 > m2 ? m1 : m2;
    extent = m3 > extent ? m3 : extent;
    real3 n = abs(p.geometric), a = abs(t.a);
    // The offset's bound along any direction, four times.
    if (robust != 0u) inset(e1, e2, (16.0 * U) * ((a.x + a.y) + a.z) + (96.0 * U) * extent, t.inner_edges, u, v);
    p.position = t.a + (u * e1 + v * e2);
    real length_ = (4.0 * U) * dot3(n, a) + (12.0 * U) * extent * ((n.x + n.y) + n.z);
    p.offset = length_ * p.geometric;
    return p;
}

// Interpolated normal, on the geometric side; `flat_normal` where the corners' cancel.
real3 smooth_normal(CornerNormals c, real3 flat_normal, real3 geometric, real u, real v) {
    if (max_component(c.a) == 0.0) return flat_normal;
    real3 n = safe_normalize((1.0 - u - v) * c.a + (u * c.b + v * c.c));
    real side = dot3(n, geometric);
    if (side == 0.0) return flat_normal;
    return side < 0.0 ? -n : n;
}

Point wide_sphere_point(ExtendedSphere s, real3 o, real3 d, real t) {
    Point p;
    real3 at = o + t * d;
    if (s.radius > 1.0) {
        // The surface point itself is sharp; the centre is too far to help.
        p.position = at;
        p.geometric = safe_normalize(s.normal + (at - s.point) / s.radius);
    } else {
        p.geometric = safe_normalize(((o - s.point) + t * d) + s.radius * s.normal);
        p.position = s.point + s.radius * (p.geometric - s.normal);
    }
    p.normal = p.geometric;
    // o + t d rounds to 2u (|o| + t), t itself to 8u: 16u covers both with the next rounding.
    p.offset = (16.0 * U) * ((max_component(o) + t * max_component(d)) + max_component(p.position)) * p.geometric;
    return p;
}

Point sphere_point(Sphere s, real3 o, real3 d, real t) {
    Point p;
    p.geometric = safe_normalize((o - s.center) + t * d);
    p.normal = p.geometric;
    p.position = s.center + s.radius * p.geometric;
    // The position is off by 6u r + u n.|c|, adding the offset rounds as much again, and
    // |o - c| rounds to 5u r: 16u leaves the origin's side in no doubt (own_course).
    p.offset = (16.0 * U) * (dot3(abs(p.geometric), abs(s.center)) + s.radius) * p.geometric;
    return p;
}

// At least the next number toward `by`: what adding a tiny offset may have lost. 2u |x| is at least
// one unit in the last place of x.
real nudge(real x, real by) {
    real step_ = (2.0 * U) * abs(x);
    return by > 0.0 ? x + step_ : (by < 0.0 ? x - step_ : x);
}

// Origin of a ray that leaves the surface in unit `direction`: moved off it to that side, or, where a
// fixed epsilon is being measured, `shift` along the direction.
real3 spawn_origin(real3 position, real3 offset, real3 direction, float shift) {
    if (origin_fixed != 0u) return position + real(shift) * direction;
    real3 o = dot3(direction, offset) < 0.0 ? -offset : offset;
    real3 p = position + o;
    return real3(nudge(p.x, o.x), nudge(p.y, o.y), nudge(p.z, o.z));
}
#endif

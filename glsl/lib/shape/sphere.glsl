// Ray/sphere: Haines, Guenther, Akenine-Moeller, "Precision Improvements for Ray/Sphere Intersection",
// Ray Tracing Gems, 2019, ch. 7: the discriminant from the vector perpendicular to the ray, and the
// roots without cancellation.
#include "shape/double_length.glsl"

// The nearest root ahead of t0 = c/q and t1 = q/a, or a negative number.
real nearest_root(real t0, real t1) {
    real near = t0 < t1 ? t0 : t1, far = t0 < t1 ? t1 : t0;
    return near > 0.0 ? near : far;
}

// A ray that starts on the sphere: one root is 0 by definition and the other is the chord 2b/a
// (numerics.md, Spheres). The origin is off by up to 6u (|o| + r) in each component, position and spawn
// offset together, so within 18u (|o| + r) |d| the sign of b is noise; the side that the offset moved
// the origin to decides then.
const int OUTWARD = 0, INWARD = 1, GRAZING = 2;
int own_course(real b, real3 o, real3 d, real radius) {
    real noise = (32.0 * U) * (max_component(o) + radius) * max_component(d);
    return b > noise ? INWARD : (b < -noise ? OUTWARD : GRAZING);
}

// The point's power |f|^2 - r^2, as a product: the squares of two near-equal lengths would cancel.
real power(real3 f, real radius) {
    real length_f = sqrt(dot3(f, f));
    return (length_f - radius) * (length_f + radius);
}

// True if the ray meets the sphere at 0 < t; sets the nearest such t. `own`: it starts on this sphere.
bool hit_sphere(Sphere s, real3 o, real3 d, bool own, out real t) {
    real3 f = o - s.center;
    real a = dot3(d, d);
    real b = -dot3(f, d);
    int course = own ? own_course(b, o, d, s.radius) : GRAZING;
    real3 p = f + (b / a) * d;
    real discriminant = s.radius * s.radius - dot3(p, p);
    real root = sqrt(a * (discriminant > 0.0 ? discriminant : 0.0));
    real q = b + (b < 0.0 ? -root : root);
    real c = power(f, s.radius);
    real root_ahead = nearest_root(c / q, q / a);
    // q == 0: tangent at the origin itself; no contact ahead. Starting here, c >= 0: grazes from outside.
    bool meets = discriminant >= 0.0 && q != 0.0 && root_ahead > 0.0 && (!own || c < 0.0);
    // One way out: lavapipe would run both and keep the values of each.
    t = course == GRAZING ? root_ahead : 2.0 * b / a;
    return course == GRAZING ? meets : course == INWARD;
}

// False only where `hit_sphere` is false: a line that passes the sphere by, or one that leaves it behind, whose
// roots are both negative. What it starts on and what is in double length is left to the test.
bool may_hit_sphere(Sphere s, real3 o, real3 d, bool own) {
    real3 f = o - s.center;
    real b = -dot3(f, d);
    real3 p = f + (b / dot3(d, d)) * d;
    bool behind = b < 0.0 && power(f, s.radius) > 0.0;
    return own || s.radius < 0.0 || (s.radius * s.radius - dot3(p, p) >= 0.0 && !behind);
}

// The same for a sphere whose radius f32 cannot tell from its distance, or the other way round
// (numerics.md, Spheres: local radii outside [2^-14, 2^12]). All in double length; c = |o - p|^2 + 2 r n.(o - p).
bool hit_extended_sphere(ExtendedSphere s, real3 o, real3 d, bool own, out real t) {
    Wide3 n = wide3(s.normal, s.normal_low);
    Wide r = Wide(s.radius, s.radius_low);
    Wide3 to = wide_add(wide3(o, real3(0.0)), wide3(-s.point, -s.point_low));
    Wide3 f = wide_add(to, wide_scale(r, n));
    Wide3 dir = wide3(d, real3(0.0));
    Wide a = wide_dot(dir, dir);
    Wide b = wide_negative(wide_dot(f, dir));
    int course = own ? own_course(b.hi, o, d, s.radius < 1.0 ? s.radius : real(1.0)) : GRAZING;
    if (course != GRAZING) {
        t = 2.0 * b.hi / a.hi;
        return course == INWARD;
    }
    Wide height = wide_mul(r, wide_dot(n, to));
    Wide c = wide_add(wide_dot(to, to), Wide(2.0 * height.hi, 2.0 * height.lo));
    if (own && !(c.hi < 0.0)) return false; // grazes from outside
    Wide discriminant; // times a
    if (s.radius > 1.0) {
        // Seen from near its surface, c is small and sharp.
        discriminant = wide_add(wide_mul(b, b), wide_negative(wide_mul(a, c)));
    } else {
        // Seen from afar, what is perpendicular to the ray is.
        Wide3 p = wide_add(f, wide_scale(wide_div(b, a), dir));
        discriminant = wide_mul(a, wide_add(wide_mul(r, r), wide_negative(wide_dot(p, p))));
    }
    if (!(discriminant.hi >= 0.0)) return false;
    Wide root = wide_sqrt(discriminant);
    Wide q = wide_add(b, b.hi < 0.0 ? wide_negative(root) : root);
    t = nearest_root(wide_div(c, q).hi, wide_div(q, a).hi);
    return q.hi != 0.0 && t > 0.0;
}

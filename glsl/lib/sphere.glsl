// Ray/sphere: Haines, Guenther, Akenine-Moeller, "Precision Improvements for Ray/Sphere Intersection",
// Ray Tracing Gems, 2019, ch. 7: the discriminant from the vector perpendicular to the ray, and the
// roots without cancellation.

// True if the ray meets the sphere at 0 < t; sets the nearest such t. `own`: the ray starts on this
// sphere, where one root is 0 by definition and the other is the chord 2b/a (numerics, finding 6).
bool hit_sphere(Sphere s, real3 o, real3 d, bool own, out real t) {
    real3 f = o - s.center;
    real a = dot3(d, d);
    real b = -dot3(f, d);
    if (own) {
        t = 2.0 * b / a;
        return b > 0.0;
    }
    real3 p = f + (b / a) * d;
    real discriminant = s.radius * s.radius - dot3(p, p);
    real root = sqrt(a * (discriminant > 0.0 ? discriminant : 0.0));
    real q = b + (b < 0.0 ? -root : root);
    // |f|^2 - r^2 as a product: the squares of two near-equal lengths would cancel.
    real length_f = sqrt(dot3(f, f));
    real c = (length_f - s.radius) * (length_f + s.radius);
    real t0 = c / q, t1 = q / a;
    real near = t0 < t1 ? t0 : t1, far = t0 < t1 ? t1 : t0;
    t = near > 0.0 ? near : far;
    // q == 0: tangent at the origin itself; no contact ahead.
    return discriminant >= 0.0 && q != 0.0 && t > 0.0;
}

// Numbers as unevaluated sums of two: some twice the digits of `real` without a wider type. Dekker,
// Numer. Math. 18 (1971); sums by Knuth's TwoSum. Each operation is right to a few units of U^2.

struct Wide {
    real hi, lo;
};

Wide two_sum(real a, real b) {
    real s = a + b, bb = s - a;
    return Wide(s, (a - (s - bb)) + (b - bb));
}
Wide quick_two_sum(real a, real b) { // |a| >= |b|
    real s = a + b;
    return Wide(s, b - (s - a));
}
Wide wide_add(Wide a, Wide b) {
    Wide s = two_sum(a.hi, b.hi), t = two_sum(a.lo, b.lo);
    s = quick_two_sum(s.hi, s.lo + t.hi);
    return quick_two_sum(s.hi, s.lo + t.lo);
}
Wide wide_negative(Wide a) {
    return Wide(-a.hi, -a.lo);
}
Wide wide_mul(Wide a, Wide b) {
    real p = a.hi * b.hi;
    return quick_two_sum(p, product_error(a.hi, b.hi, p) + (a.hi * b.lo + a.lo * b.hi));
}
Wide wide_div(Wide a, Wide b) {
    real q = a.hi / b.hi;
    Wide r = wide_add(a, wide_negative(wide_mul(b, Wide(q, 0.0))));
    return quick_two_sum(q, (r.hi + r.lo) / b.hi);
}
// Square root of a > 0: one Newton step from the rounded root.
Wide wide_sqrt(Wide a) {
    real s = sqrt(a.hi);
    if (!(s > 0.0)) return Wide(0.0, 0.0);
    real p = s * s;
    Wide r = wide_add(a, Wide(-p, -product_error(s, s, p)));
    return quick_two_sum(s, (r.hi + r.lo) / (2.0 * s));
}

struct Wide3 {
    Wide x, y, z;
};

Wide3 wide3(real3 hi, real3 lo) {
    return Wide3(Wide(hi.x, lo.x), Wide(hi.y, lo.y), Wide(hi.z, lo.z));
}
Wide3 wide_add(Wide3 a, Wide3 b) {
    return Wide3(wide_add(a.x, b.x), wide_add(a.y, b.y), wide_add(a.z, b.z));
}
Wide3 wide_scale(Wide s, Wide3 v) {
    return Wide3(wide_mul(s, v.x), wide_mul(s, v.y), wide_mul(s, v.z));
}
Wide wide_dot(Wide3 a, Wide3 b) {
    return wide_add(wide_add(wide_mul(a.x, b.x), wide_mul(a.y, b.y)), wide_mul(a.z, b.z));
}

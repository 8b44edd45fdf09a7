// Scalar building blocks with stated roundings. u = unit roundoff of `real`, g(n) = n u / (1 - n u).
// No dot(), cross(), length(), normalize(): their roundings are the driver's (numerics.md, Contraction).

#ifdef REAL_IS_DOUBLE
const real U = 1.1102230246251565404236316680908203125e-16lf; // 2^-53
const real SPLIT = 134217729.0lf;                              // 2^27 + 1
#else
const real U = 5.9604644775390625e-8; // 2^-24
const real SPLIT = 4097.0;            // 2^12 + 1
#endif

real dot3(real3 a, real3 b) {
    return (a.x * b.x + a.y * b.y) + a.z * b.z;
}

real3 cross3(real3 a, real3 b) {
    return real3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

real max_component(real3 v) {
    real x = abs(v.x), y = abs(v.y), z = abs(v.z);
    real m = x > y ? x : y;
    return m > z ? m : z;
}

// Unit vector along v, or zero for zero. Scaling by the largest component first keeps v.v in
// [1, 3], where neither overflow nor underflow touches it (numerics.md, Shading). 1 / sqrt, not
// inversesqrt: both operations are correctly rounded on IEEE hardware.
real3 safe_normalize(real3 v) {
    real m = max_component(v);
    if (!(m > 0.0)) return real3(0.0);
    real3 s = v / m;
    return s / sqrt(dot3(s, s));
}

// Exponent bits all set: NaN or infinity. By bits, since isnan() may be folded away (numerics.md, Devices).
bool is_not_finite(real x) {
#ifdef REAL_IS_DOUBLE
    return (unpackDouble2x32(x).y & 0x7ff00000u) == 0x7ff00000u;
#else
    return (floatBitsToUint(x) & 0x7f800000u) == 0x7f800000u;
#endif
}
bool is_not_finite(real3 v) {
    return is_not_finite(v.x) || is_not_finite(v.y) || is_not_finite(v.z);
}

bool is_negative(real x) { // the sign bit: true for -0
#ifdef REAL_IS_DOUBLE
    return (unpackDouble2x32(x).y & 0x80000000u) != 0u;
#else
    return (floatBitsToUint(x) & 0x80000000u) != 0u;
#endif
}

// a*b - p for p = fl(a*b), exactly: Dekker, Numer. Math. 18 (1971), with Veltkamp's split.
real product_error(real a, real b, real p) {
    real ca = SPLIT * a, cb = SPLIT * b;
    real ah = ca - (ca - a), bh = cb - (cb - b);
    real al = a - ah, bl = b - bh;
    return ((ah * bh - p) + ah * bl + al * bh) + al * bl;
}

// One step of Neumaier's compensated sum, ZAMM 54 (1974) (numerics.md, Accumulation), its two parts brought together
// after each step (Dekker's fast two-sum). Left apart, the compensation grows like a naive sum of the
// errors, and 2^20 samples lose (2^20 u)^2, some 900 units in the last place; so they lose 2^20 u^2.
void neumaier(inout vec3 sum, inout vec3 compensation, vec3 x) {
    vec3 t = sum + x;
    for (int i = 0; i < 3; i++) {
        compensation[i] += abs(sum[i]) >= abs(x[i]) ? (sum[i] - t[i]) + x[i] : (x[i] - t[i]) + sum[i];
    }
    sum = t + compensation;
    compensation -= sum - t;
}

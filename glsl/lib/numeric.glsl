// Scalar building blocks with stated roundings. u = 2^-24, g(n) = n u / (1 - n u).
// No dot(), cross(), length(), normalize(): their roundings are the driver's (numerics, finding 3).

const real U = 5.9604644775390625e-8; // 2^-24, unit roundoff of f32

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
// [1, 3], where neither overflow nor underflow touches it (numerics 8.5). 1 / sqrt, not
// inversesqrt: both operations are correctly rounded on IEEE hardware.
real3 safe_normalize(real3 v) {
    real m = max_component(v);
    if (!(m > 0.0)) return real3(0.0);
    real3 s = v / m;
    return s / sqrt(dot3(s, s));
}

// NaN or infinity, by bits: isnan() may be folded away (numerics 2.6).
bool is_not_finite(real3 v) {
    uvec3 e = floatBitsToUint(v) & 0x7f800000u;
    return e.x == 0x7f800000u || e.y == 0x7f800000u || e.z == 0x7f800000u;
}

// One step of Neumaier's compensated sum, ZAMM 54 (1974) (numerics 8.6).
void neumaier(inout vec3 sum, inout vec3 compensation, vec3 x) {
    vec3 t = sum + x;
    for (int i = 0; i < 3; i++) {
        compensation[i] += abs(sum[i]) >= abs(x[i]) ? (sum[i] - t[i]) + x[i] : (x[i] - t[i]) + sum[i];
    }
    sum = t;
}

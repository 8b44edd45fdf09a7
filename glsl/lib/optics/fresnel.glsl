// Shares of reflection at a surface between indices n1 (here) and n2 (beyond).
#ifndef FRESNEL
#define FRESNEL

// What Snell's law scales by eta: the part of d along the surface; n on the ray's side, c = -n.d.
real3 along_surface(real3 d, real3 n, real c) {
    return d + c * n;
}

// cos of the transmitted angle squared; negative = total internal reflection. `scaled` = n1 / n2 times
// the part of the direction along the surface. From its length, not from 1 - c^2: that would carry
// the rounding of c eta^2-fold, this carries that of `scaled` eta-fold.
real transmitted_cosine_squared(real3 scaled) {
    return 1.0 - dot3(scaled, scaled);
}

// Unpolarised dielectric reflectance (numerics.md, Refraction); ct = transmitted cosine.
real fresnel_exact(real n1, real n2, real c, real ct) {
    real rs = (n1 * c - n2 * ct) / (n1 * c + n2 * ct);
    real rp = (n2 * c - n1 * ct) / (n2 * c + n1 * ct);
    return (rs * rs + rp * rp) * 0.5;
}

// Schlick, "An Inexpensive BRDF Model for Physically-based Rendering", 1994, eq. 24, with the
// cosine on the less dense side.
real fresnel_schlick(real n1, real n2, real c, real ct) {
    real r = (n1 - n2) / (n1 + n2);
    real r0 = r * r;
    real m = 1.0 - (n1 > n2 ? ct : c);
    real m2 = m * m;
    return r0 + (1.0 - r0) * (m2 * m2 * m);
}

// Share of reflection. 1 at total internal reflection; 0 for the two laws where nothing changes.
real reflection_share(Material m, real n1, real n2, real3 d, real3 n, real c) {
    real eta = n1 / n2;
    real k = transmitted_cosine_squared(eta * along_surface(d, n, c));
    if (k < 0.0) return 1.0;
    if (m.fresnel_kind == FRESNEL_CONSTANT) return m.fresnel;
    if (n1 == n2) return 0.0;
    real ct = sqrt(k);
    return m.fresnel_kind == FRESNEL_EXACT ? fresnel_exact(n1, n2, c, ct) : fresnel_schlick(n1, n2, c, ct);
}

// Direction of the refracted ray; n on the ray's side, c = -n.d >= 0.
real3 refracted(real3 d, real3 n, real eta, real c) {
    real3 scaled = eta * along_surface(d, n, c);
    real k = transmitted_cosine_squared(scaled);
    return safe_normalize(scaled - sqrt(k > 0.0 ? k : 0.0) * n);
}

real3 reflected(real3 d, real3 n, real c) {
    return safe_normalize(d + (2.0 * c) * n);
}
#endif

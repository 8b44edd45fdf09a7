// Ray/triangle: Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013.
// Departs from it by not swapping kx and ky (that only flips the sign of all three edge functions)
// and by deciding a zero edge function exactly with Dekker's product instead of f64.

// As stored: from the corners in f64.
real3 geometric_normal(Triangle t) {
    return real3(t.normal_x, t.normal_y, t.normal_z);
}

// The ray's part of the test: the axes permuted so that kz is the direction's largest, and the shear.
struct Shear {
    int kz;
    real sx, sy, sz;
};

// Component kz, kx = kz + 1, ky = kz + 2 (mod 3) of v. Selects, since a dynamic index costs a load per lane.
real pick(real3 v, int k) {
    return k == 0 ? v.x : (k == 1 ? v.y : v.z);
}
real3 permute(real3 v, int kz) {
    return kz == 0 ? real3(v.y, v.z, v.x) : (kz == 1 ? real3(v.z, v.x, v.y) : v);
}

Shear make_shear(real3 d) {
    real x = abs(d.x), y = abs(d.y), z = abs(d.z);
    int kz = x > y ? (x > z ? 0 : 2) : (y > z ? 1 : 2);
    real3 p = permute(d, kz);
    return Shear(kz, p.x / p.z, p.y / p.z, 1.0 / p.z);
}

// Sign-exact a*b - c*d where the rounded difference was zero: then both products round to the same
// number, and what is left is the difference of their errors.
real exact_edge(real a, real b, real c, real d, real rounded) {
    if (rounded != 0.0) return rounded;
    return product_error(a, b, a * b) - product_error(c, d, c * d);
}

// True if the ray from o meets the triangle at 0 < t; sets t and the weights u of b and v of c.
// NaN anywhere fails every comparison and misses.
bool hit_triangle(Triangle tri, real3 o, real3 d, Shear s, out real t, out real u, out real v) {
    real3 a = permute(tri.a - o, s.kz), b = permute(tri.b - o, s.kz), c = permute(tri.c - o, s.kz);
    real ax = a.x - s.sx * a.z, ay = a.y - s.sy * a.z;
    real bx = b.x - s.sx * b.z, by = b.y - s.sy * b.z;
    real cx = c.x - s.sx * c.z, cy = c.y - s.sy * c.z;
    real ua = cx * by - cy * bx;
    real vb = ax * cy - ay * cx;
    real wc = bx * ay - by * ax;
    if (robust != 0u && (ua == 0.0 || vb == 0.0 || wc == 0.0)) {
        ua = exact_edge(cx, by, cy, bx, ua);
        vb = exact_edge(ax, cy, ay, cx, vb);
        wc = exact_edge(bx, ay, by, ax, wc);
    }
    bool inside = (ua >= 0.0 && vb >= 0.0 && wc >= 0.0) || (ua <= 0.0 && vb <= 0.0 && wc <= 0.0);
    real det = (ua + vb) + wc;
    real scaled = ((ua * a.z + vb * b.z) + wc * c.z) * s.sz;
    t = scaled / det;
    u = vb / det;
    v = wc / det;
    return inside && det != 0.0 && t > 0.0;
}

// False only where `hit_triangle` is false: it looks at the signs alone and leaves zeros to the test.
bool may_hit_triangle(Triangle tri, real3 o, Shear s) {
    real3 a = permute(tri.a - o, s.kz), b = permute(tri.b - o, s.kz), c = permute(tri.c - o, s.kz);
    real ax = a.x - s.sx * a.z, ay = a.y - s.sy * a.z;
    real bx = b.x - s.sx * b.z, by = b.y - s.sy * b.z;
    real cx = c.x - s.sx * c.z, cy = c.y - s.sy * c.z;
    real ua = cx * by - cy * bx;
    real vb = ax * cy - ay * cx;
    real wc = bx * ay - by * ax;
    real low = ua < vb ? ua : vb, high = ua < vb ? vb : ua;
    low = wc < low ? wc : low;
    high = wc > high ? wc : high;
    real scaled = ((ua * a.z + vb * b.z) + wc * c.z) * s.sz;
    // Ahead, the distance has the sign of the edge functions; a zero among them decides nothing.
    return (low >= 0.0 && !(scaled <= 0.0 && low > 0.0)) || (high <= 0.0 && !(scaled >= 0.0 && high < 0.0));
}

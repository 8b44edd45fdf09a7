// Ray/box by slabs: Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013, with the factor for Vulkan's
// 2.5-ulp division (numerics 2.4): t = (b - o) * (1/d) carries (1 + 2u)^7.

const real SLAB_GROW = 1.0 + 16.0 * U; // 1 + 2 g(7), rounded up to a power of two: 1 + 2^-20

// 1/d with |d| >= 2^-60, sign kept, so that no product is NaN; the padding of the boxes keeps a ray
// that lies in a face inside (numerics 2.4).
real safe_reciprocal(real d) {
    uint sign = floatBitsToUint(d) & 0x80000000u;
    real m = abs(d);
    m = m > 8.6736173798840355e-19 ? m : 8.6736173798840355e-19; // 2^-60
    return 1.0 / uintBitsToFloat(floatBitsToUint(m) | sign);
}

// Entry distance, or a negative number if the ray misses the box within (0, limit].
real enter_box(real3 lo, real3 hi, real3 o, real3 inv, real limit) {
    real x0 = (lo.x - o.x) * inv.x, x1 = (hi.x - o.x) * inv.x;
    real y0 = (lo.y - o.y) * inv.y, y1 = (hi.y - o.y) * inv.y;
    real z0 = (lo.z - o.z) * inv.z, z1 = (hi.z - o.z) * inv.z;
    real tn = inv.x >= 0.0 ? x0 : x1, tf = inv.x >= 0.0 ? x1 : x0;
    real yn = inv.y >= 0.0 ? y0 : y1, yf = inv.y >= 0.0 ? y1 : y0;
    real zn = inv.z >= 0.0 ? z0 : z1, zf = inv.z >= 0.0 ? z1 : z0;
    tn = yn > tn ? yn : tn;
    tn = zn > tn ? zn : tn;
    tf = yf < tf ? yf : tf;
    tf = zf < tf ? zf : tf;
    tn = tn > 0.0 ? tn : 0.0;
    return tn <= tf * SLAB_GROW && tn <= limit * SLAB_GROW ? tn : -1.0;
}

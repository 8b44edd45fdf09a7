// Twin of src/sampler.rs, bit for bit.

// pcg4d, Jarzynski and Olano, JCGT 9(3), 2020.
uvec4 pcg4d(uvec4 v) {
    v = v * 1664525u + 1013904223u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    v ^= v >> 16u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    return v;
}

// Position of sample k in its pixel, in [0, 1)^2, multiples of 2^-24.
vec2 sample_offset(uint seed, uint x, uint y, uint k, uint samples) {
    if (samples == 1u) return vec2(0.5);
    uvec4 h = pcg4d(uvec4(x, y, k, seed));
    return vec2(h.xy >> 8u) * (1.0 / 16777216.0);
}

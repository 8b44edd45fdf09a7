// Twin of src/settings/sampler.rs, bit for bit; there are the sources.

// pcg4d, Jarzynski and Olano, JCGT 9(3), 2020, with a third round and a last xorshift.
uvec4 pcg4d(uvec4 v) {
    v = v * 1664525u + 1013904223u;
    for (uint i = 0u; i < 3u; i++) {
        v.x += v.y * v.w;
        v.y += v.z * v.x;
        v.z += v.x * v.y;
        v.w += v.y * v.z;
        v ^= v >> 16u;
    }
    return v;
}

// Nested uniform scrambling of a number whose bits are reversed.
uint scramble_reversed(uint v, uint seed) {
    v ^= v * 0x3d20adeau;
    v += seed;
    v *= (seed >> 16u) | 1u;
    v ^= v * 0x05526c56u;
    return v ^ (v * 0x53a22864u);
}

// The second dimension of Sobol's sequence, bits reversed.
uint sobol_1_reversed(uint index) {
    uint v = index;
    v ^= (v >> 1u) & 0x55555555u;
    v ^= (v >> 2u) & 0x33333333u;
    v ^= (v >> 4u) & 0x0f0f0f0fu;
    v ^= (v >> 8u) & 0x00ff00ffu;
    return v ^ ((v >> 16u) & 0x0000ffffu);
}

// Bits 0, 2, 4, ... of v, side by side.
uint even_bits(uint v) {
    v &= 0x55555555u;
    v = (v | (v >> 1u)) & 0x33333333u;
    v = (v | (v >> 2u)) & 0x0f0f0f0fu;
    v = (v | (v >> 4u)) & 0x00ff00ffu;
    return (v | (v >> 8u)) & 0x0000ffffu;
}

// Point of a scrambled Sobol sequence.
uvec2 owen_point(uint index, uvec4 hash) {
    return uvec2(
        bitfieldReverse(scramble_reversed(index, hash.x)),
        bitfieldReverse(scramble_reversed(sobol_1_reversed(index), hash.y)));
}

// Point of a progressive jittered sequence.
uvec2 stratified_point(uint index, uvec4 hash, uvec4 low) {
    uint curve = bitfieldReverse(scramble_reversed(index, hash.x));
    return uvec2(
        (even_bits(curve >> 1u) << 16u) | ((low.z >> 24u) << 8u),
        (even_bits(curve) << 16u) | ((low.w >> 24u) << 8u));
}

// Position of sample k in its pixel, in [0, 1)^2, multiples of 2^-24.
vec2 sample_offset(uint seed, uint x, uint y, uint k, uint samples) {
    if (samples == 1u) return vec2(0.5);
    uvec4 own = pcg4d(uvec4(x, y, k, seed));
    uvec4 shared_hash = pcg4d(uvec4(x, y, k % replicates, seed));
    uvec2 point = sampler_kind == SAMPLER_RANDOM ? own.xy
        : sampler_kind == SAMPLER_STRATIFIED ? stratified_point(k / replicates, shared_hash, own)
        : owen_point(k / replicates, shared_hash);
    return vec2(point >> 8u) * (1.0 / 16777216.0);
}

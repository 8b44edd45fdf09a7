// What the lanes of a subgroup know together, where they work together (`lanes`, 4 or 8 of them, all of
// which must take part). By shuffles of constant lanes: lavapipe has an instruction for those, and loops
// over the lanes for all else.
uint any_lane(uint bits) {
    uint all = subgroupShuffle(bits, 0u) | subgroupShuffle(bits, 1u) | subgroupShuffle(bits, 2u) | subgroupShuffle(bits, 3u);
    if (lanes > 4u) {
        all |= subgroupShuffle(bits, 4u) | subgroupShuffle(bits, 5u) | subgroupShuffle(bits, 6u) | subgroupShuffle(bits, 7u);
    }
    return all;
}

uint sum_lanes(uint x) {
    uint all = subgroupShuffle(x, 0u) + subgroupShuffle(x, 1u) + subgroupShuffle(x, 2u) + subgroupShuffle(x, 3u);
    if (lanes > 4u) {
        all += subgroupShuffle(x, 4u) + subgroupShuffle(x, 5u) + subgroupShuffle(x, 6u) + subgroupShuffle(x, 7u);
    }
    return all;
}

// Consecutive texels, the first few lanes one each; up to `last`, 3 at most.
#define GATHER(x, at, last) texelFetch(x##_texels, int((at) + min(gl_SubgroupInvocationID, last)))

Triangle gather_triangle(uint i) {
    uvec4 p = GATHER(triangles, i * 4u, 3u);
    Triangle t;
    unpack(subgroupShuffle(p, 0u), subgroupShuffle(p, 1u), subgroupShuffle(p, 2u), subgroupShuffle(p, 3u), t);
    return t;
}
Sphere gather_sphere(uint i) {
    uvec4 p = GATHER(spheres, i * 2u, 1u);
    Sphere s;
    unpack(subgroupShuffle(p, 0u), subgroupShuffle(p, 1u), s);
    return s;
}

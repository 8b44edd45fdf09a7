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

// Texels of a node or of a leaf, one or two with each lane.
struct Pieces {
    uvec4 first, second;
};
#define GATHER(x, at, last) Pieces(texelFetch(x##_texels, int((at) + min(gl_SubgroupInvocationID, last))), \
    lanes < 8u ? texelFetch(x##_texels, int((at) + min(gl_SubgroupInvocationID + 4u, last))) : uvec4(0u))
#define LOW_PIECE(p, k) subgroupShuffle(p.first, k)
#define HIGH_PIECE(p, k, k_less_4) (lanes < 8u ? subgroupShuffle(p.second, k_less_4) : subgroupShuffle(p.first, k))

Triangle gather_triangle(uint i) {
    Pieces p = GATHER(triangles, i * 4u, 3u);
    Triangle t;
    unpack(LOW_PIECE(p, 0u), LOW_PIECE(p, 1u), LOW_PIECE(p, 2u), LOW_PIECE(p, 3u), t);
    return t;
}
Sphere gather_sphere(uint i) {
    Pieces p = GATHER(spheres, i * 2u, 1u);
    Sphere s;
    unpack(LOW_PIECE(p, 0u), LOW_PIECE(p, 1u), s);
    return s;
}

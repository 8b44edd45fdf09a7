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

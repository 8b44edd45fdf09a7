// The solids a ray is in: `media_capacity` words, outermost first, 0 = none. Of those with the highest
// priority the last is the medium (Schmidt and Budge, "Simple Nested Dielectrics in Ray Traced
// Images", JGT 7(2), 2002; equal priorities: the last entered). Needs READS(media),
// READS(solid_priorities).

bool is_inside(uint ray, uint solid) {
    for (uint j = 0u; j < media_capacity; j++) {
        if (media[ray * media_capacity + j] == solid) return true;
    }
    return false;
}

// The solid whose matter the ray is in, leaving `without` aside; 0 = the surrounding space.
uint medium(uint ray, uint without) {
    uint found = 0u;
    for (uint j = 0u; j < media_capacity; j++) {
        uint m = media[ray * media_capacity + j];
        if (m != 0u && m != without && (found == 0u || solid_priorities[m] >= solid_priorities[found])) found = m;
    }
    return found;
}

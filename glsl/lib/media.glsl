// The solids a ray is in: `media_capacity` words, outermost first, 0 = none. The last one is the
// medium. Needs READS(media).

bool is_inside(uint ray, uint solid) {
    for (uint j = 0u; j < media_capacity; j++) {
        if (media[ray * media_capacity + j] == solid) return true;
    }
    return false;
}

// The last solid entered, leaving `without` aside; 0 = none.
uint innermost(uint ray, uint without) {
    uint found = 0u;
    for (uint j = 0u; j < media_capacity; j++) {
        uint m = media[ray * media_capacity + j];
        if (m != 0u && m != without) found = m;
    }
    return found;
}

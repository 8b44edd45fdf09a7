// Adds the batch's samples to their pixels, in sample order, compensated: any split into batches
// gives the same bits.
// Reads slots. Updates film.
// One invocation per pixel of the tile.
#version 460
#include "prelude.glsl"
#include "numeric.glsl"
layout(local_size_x_id = 0) in;

READS(slots)
UPDATES(film)

void main() {
    uint pixel = item_index();
    if (pixel >= push.tile_pixels) return;
    vec3 sum = film[pixel].sum, compensation = film[pixel].compensation;
    for (uint k = 0u; k < push.batch_samples; k++) {
        neumaier(sum, compensation, slots[k * push.tile_pixels + pixel]);
    }
    film[pixel] = Film(sum, compensation);
}

// Adds the batch's samples to their pixels, in sample order, compensated: any split into batches
// gives the same bits. A survey joins what the samples' paths did.
// Reads sample_radiance, paths. Updates film, marks.
// One invocation per pixel of the tile.
#version 460
#include "base/prelude.glsl"
#include "base/numeric.glsl"
layout(local_size_x_id = 0) in;

READS(sample_radiance)
READS(paths)
UPDATES(film)
UPDATES(marks)

void main() {
    uint pixel = item_index();
    if (pixel >= push.tile_pixels) return;
    // Sample k belongs to replicate k % replicates.
    uint turn = push.first_sample % replicates;
    for (uint r = 0u; r < replicates; r++) {
        uint at = pixel * replicates + r;
        vec3 sum = film[at].sum, compensation = film[at].compensation;
        for (uint k = (r + replicates - turn) % replicates; k < push.batch_samples; k += replicates) {
            neumaier(sum, compensation, sample_radiance[k * push.tile_pixels + pixel]);
        }
        film[at] = Film(sum, compensation);
    }
    if (survey == 0u) return;
    Mark m = marks[pixel];
    for (uint k = 0u; k < push.batch_samples; k++) {
        Path p = paths[k * push.tile_pixels + pixel];
        m.hash_least_inverted = max(m.hash_least_inverted, ~p.hash);
        m.hash_most = max(m.hash_most, p.hash);
        m.rays += p.rays;
        m.depth = max(m.depth, p.depth);
        m.cut_low += p.cut;
        m.cut_high += m.cut_low < p.cut ? 1u : 0u;
    }
    marks[pixel] = m;
}

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

// Adds the batch's samples first, first + step, ... below `end` to sum `set` of the pixel's `sets`.
void add_samples(uint pixel, uint sets, uint set, uint first, uint end, uint step) {
    uint at = pixel * sets + set;
    vec3 sum = film[at].sum, compensation = film[at].compensation;
    for (uint k = first; k < end; k += step) {
        neumaier(sum, compensation, sample_radiance[k * push.tile_pixels + pixel]);
    }
    film[at] = Film(sum, compensation);
}

// Where part `p` of the range begins, as a sample of this batch: part p has the samples from ceil(p n / parts) on,
// n = push.range_samples.
uint place_in_batch(uint p) {
    uint begin = push.range_first + (p * push.range_samples + parts - 1u) / parts;
    return begin > push.first_sample ? min(begin - push.first_sample, push.batch_samples) : 0u;
}

void main() {
    uint pixel = item_index();
    if (pixel >= push.tile_pixels) return;
    if (parts == 1u) {
        // Sample k belongs to replicate k % replicates.
        uint turn = push.first_sample % replicates;
        for (uint r = 0u; r < replicates; r++) {
            add_samples(pixel, replicates, r, (r + replicates - turn) % replicates, push.batch_samples, replicates);
        }
    } else {
        for (uint p = 0u; p < parts; p++) {
            add_samples(pixel, parts, p, place_in_batch(p), place_in_batch(p + 1u), 1u);
        }
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

// Primary rays of a batch: one per pixel of the tile and sample.
// Reads camera, eye_media, pixels (in a survey). Writes rays, media and paths (zero).
// One invocation per ray: sample-major, so that a pixel's samples are `tile_pixels` apart; within a sample
// in blocks of pixels, so that neighbours in the queue are neighbours in the image both ways.
#version 460
#include "base/prelude.glsl"
#include "base/numeric.glsl"
#include "base/sampler.glsl"
#include "base/fetch.glsl"
layout(local_size_x_id = 0) in;

READS(camera)
READS(eye_media)
READS(pixels)
STORES_3(rays)
WRITES(media)
WRITES(paths)

Ray primary_ray(Camera c, uint sample_index) {
    uint pixel = sample_index % push.tile_pixels;
    uint at = survey != 0u ? pixels[pixel] : pixel;
    uint x = push.tile_x + at % push.tile_width;
    uint y = push.tile_y + at / push.tile_width;
    uint k = push.first_sample + sample_index / push.tile_pixels;
    vec2 offset = sample_offset(push.seed, x, y, k, push.samples);
    real sx = (real(x) + real(offset.x)) * c.step_x - 1.0;
    real sy = 1.0 - (real(y) + real(offset.y)) * c.step_y;
    real3 lateral = sx * c.right + sy * c.up;
    return Ray(c.origin + c.advance * lateral, safe_normalize(c.forward + lateral), sample_index, NONE, vec3(1.0), 0u);
}

// The pixel that is `at` in the queue: strips of 8 rows, in them blocks of 8x8 pixels in Morton order (so 8 rays
// are 4x2 pixels, 32 are 8x4), in the blocks' rest rows; whole rows where no strip is left.
uint in_blocks(uint at) {
    uint strip = push.tile_width * 8u, first = at - at % strip;
    if (survey != 0u || push.tile_pixels - first < strip) return at;
    uint i = at - first, blocks = push.tile_width / 8u * 64u;
    uint x = i / 64u * 8u + ((i & 1u) | (i >> 1 & 2u) | (i >> 2 & 4u));
    uint y = (i >> 1 & 1u) | (i >> 2 & 2u) | (i >> 3 & 4u);
    if (i >= blocks) {
        uint width = push.tile_width % 8u;
        x = push.tile_width - width + (i - blocks) % width;
        y = (i - blocks) / width;
    }
    return first + y * push.tile_width + x;
}

void main() {
    uint item = item_index();
    if (item >= push.items) return;
    uint at = item % push.tile_pixels, sample_index = item - at + in_blocks(at);
    store_rays(item, primary_ray(camera[0], sample_index));
    if (survey != 0u) paths[sample_index] = Path(0u, 0u, 0u, 0u);
    for (uint j = 0u; j < media_capacity; j++) {
        media[item * media_capacity + j] = eye_media[j];
    }
}

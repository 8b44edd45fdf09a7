// Primary rays of a batch: one per pixel of the tile and sample.
// Reads camera, eye_media, pixels (in a survey). Writes rays, media, slots and paths (zero).
// One invocation per ray: sample-major, so that a pixel's samples are `tile_pixels` apart.
#version 460
#include "prelude.glsl"
#include "numeric.glsl"
#include "sampler.glsl"
layout(local_size_x_id = 0) in;

READS(camera)
READS(eye_media)
READS(pixels)
WRITES(rays)
WRITES(media)
WRITES(slots)
WRITES(paths)

Ray primary_ray(Camera c, uint slot) {
    uint pixel = slot % push.tile_pixels;
    uint at = survey != 0u ? pixels[pixel] : pixel;
    uint x = push.tile_x + at % push.tile_width;
    uint y = push.tile_y + at / push.tile_width;
    uint k = push.first_sample + slot / push.tile_pixels;
    vec2 offset = sample_offset(push.seed, x, y, k, push.samples);
    real sx = (real(x) + real(offset.x)) * c.step_x - 1.0;
    real sy = 1.0 - (real(y) + real(offset.y)) * c.step_y;
    real3 lateral = sx * c.right + sy * c.up;
    return Ray(c.origin + c.advance * lateral, safe_normalize(c.forward + lateral), slot, NONE, vec3(1.0), 0u);
}

void main() {
    uint slot = item_index();
    if (slot >= push.items) return;
    rays[slot] = primary_ray(camera[0], slot);
    slots[slot] = vec3(0.0);
    if (survey != 0u) paths[slot] = Path(0u, 0u, 0u, 0u);
    for (uint j = 0u; j < media_capacity; j++) {
        media[slot * media_capacity + j] = eye_media[j];
    }
}

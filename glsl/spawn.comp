// Reflection and refraction rays of the next depth, in the order of their parents, reflection first.
// Reads queue, rays, media, surfaces, materials, offsets, camera (for a fixed origin shift). Writes next_rays, next_media. Counts rays
// that are in more solids than their list holds.
// One invocation per parent ray. Whitted, CACM 23(6), 1980.
#version 460
#include "prelude.glsl"
#include "numeric.glsl"
#include "fetch.glsl"
layout(local_size_x_id = 0) in;

READS(camera)
READS(materials)
FETCHES_3(rays)
READS(media)
READS(queue)
READS(next_queue)
FETCHES_4(surfaces)
READS(offsets)
STORES_3(next_rays)
WRITES(next_media)
UPDATES(counters)
#include "surface.glsl"
#include "fresnel.glsl"

// A shading normal may mirror a ray below the surface: bend it back until it just leaves (numerics.md, Shading).
real3 above(real3 direction, real3 offset) {
    if (smooth_normals == 0u || defect == DEFECT_BELOW_SURFACE) return direction;
    real3 n = safe_normalize(offset);
    real height = dot3(direction, n);
    return height < 4.0 * U ? safe_normalize(direction + (4.0 * U - height) * n) : direction;
}

void keep_media(uint from, uint to) {
    for (uint j = 0u; j < media_capacity; j++) {
        next_media[to * media_capacity + j] = media[from * media_capacity + j];
    }
}

// The list without `solid`, or with it as the last.
void change_media(uint from, uint to, uint solid, bool leaves) {
    uint n = 0u;
    for (uint j = 0u; j < media_capacity; j++) {
        uint m = media[from * media_capacity + j];
        if (m != 0u && m != solid) next_media[to * media_capacity + n++] = m;
    }
    if (!leaves) {
        if (n < media_capacity) {
            next_media[to * media_capacity + n++] = solid;
        } else {
            if (defect != DEFECT_SILENT_MEDIA) atomicAdd(counters[COUNTER_MEDIA_OVERFLOW], 1u);
        }
    }
    for (; n < media_capacity; n++) next_media[to * media_capacity + n] = 0u;
}

void main() {
    uint i = item_index();
    if (i >= queue[0].count || next_queue[0].count == 0u) return;
    Surface s = load_surfaces(i);
    if (s.primitive == NONE || (s.flags & (CHILD_REFLECTED | CHILD_REFRACTED)) == 0u) return;
    Ray ray = load_rays(i);
    real3 d = ray.direction;
    vec3 throughput = ray.throughput;
    if ((s.flags & PASSES) == 0u) throughput *= materials[s.material].secondary;
    uint skip = origin_fixed != 0u ? NONE : s.primitive;
    float shift = camera[0].origin_shift;
    uint to = offsets[group_index()] + (s.flags >> PREFIX_SHIFT);
    if ((s.flags & CHILD_REFLECTED) != 0u) {
        real3 w = above(reflected(d, s.normal, s.cosine), s.offset);
        store_next_rays(to, Ray(spawn_origin(s.position, s.offset, w, shift), w, ray.slot, skip, s.share * throughput, 0u));
        keep_media(i, to);
        to++;
    }
    if ((s.flags & CHILD_REFRACTED) != 0u) {
        real3 w = s.eta == 1.0 && defect != DEFECT_EQUAL_INDICES ? d : refracted(d, s.normal, s.eta, s.cosine);
        store_next_rays(to, Ray(spawn_origin(s.position, s.offset, w, shift), w, ray.slot, skip, (1.0 - s.share) * throughput, 0u));
        if (s.solid != 0u) {
            change_media(i, to, s.solid, (s.flags & LEAVES) != 0u);
        } else {
            keep_media(i, to);
        }
    }
}
